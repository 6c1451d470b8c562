//! Radii spread over six orders of magnitude cost a ray about as much as equal ones, counted in
//! nodes, leaves and blob evaluations.

use glam::DVec3;
use meniscus::accel::Engine;
use meniscus::field::BlobField;
use meniscus::frame::Blobs;
use meniscus::intersect::{Counters, Scratch};
use meniscus::kernel::Kernel;
use meniscus::math::simd::Level;
use meniscus::primitive::Shapes;
use meniscus_testing::oracle::Oracle;
use meniscus_testing::random::Stream;
use meniscus_testing::rays;

const BLOBS: usize = 20_000;

/// Blobs at random in the unit cube; `radius_of` gets a random number in [0, 1).
fn field(radius_of: impl Fn(f64) -> f64) -> BlobField {
    let (mut centers, mut radii) = (Vec::new(), Vec::new());
    for i in 0..BLOBS as u64 {
        let mut random = Stream::new(7, i);
        centers.push([(); 3].map(|()| random.unit() as f32 - 0.5));
        radii.push(radius_of(random.unit()) as f32);
    }
    BlobField {
        kernel: Kernel::Sextic,
        threshold: 0.2,
        origin: DVec3::splat(0.5),
        centers,
        shapes: Shapes::Balls(radii),
        weights: vec![1.0; BLOBS],
        rows: (0..BLOBS as u32).collect(),
        motion: None,
        attributes: Vec::new(),
        spacing: 0.02,
        search: meniscus::field::Search::default(),
    }
}

fn work(field: BlobField) -> Counters {
    let rays = rays::primary(&Oracle::new(&field), 100, DVec3::new(0.3, 0.5, 1.0));
    let blobs = Blobs::build(field, Engine::Cells, Level::new());
    let mut scratch = Scratch::default();
    let hits = rays
        .iter()
        .filter(|ray| blobs.closest(ray, &mut scratch).is_some())
        .count();
    assert!(hits > 1000, "only {hits} hits");
    scratch.counters
}

#[test]
fn work_per_ray_is_close_to_that_of_equal_radii() {
    let largest = 0.03;
    let equal = work(field(|_| largest));
    // Half of the blobs keep their size, so that there is as much to see.
    let spread = work(field(|u| {
        largest * 10_f64.powf(-6.0 * (2.0 * u - 1.0).max(0.0))
    }));
    // Leaves are as large as their smallest blob allows, so small blobs take more nodes and leaves, each
    // with fewer blobs.
    for (what, limit, spread, equal) in [
        ("nodes", 2.5, spread.nodes, equal.nodes),
        ("leaves", 2.0, spread.leaves, equal.leaves),
        (
            "blobs",
            1.0,
            spread.blob_evaluations,
            equal.blob_evaluations,
        ),
    ] {
        let ratio = spread as f64 / equal as f64;
        println!("{what}: {spread} against {equal}, {ratio:.2}");
        assert!(ratio < limit, "{what}: {ratio:.2} times the work");
    }
}
