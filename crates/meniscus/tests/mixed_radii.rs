//! Blobs of radii spread over six orders of magnitude among large ones cost a ray little more than the
//! large ones alone, counted in nodes, leaves and blob evaluations.

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

/// Blobs at random in the unit cube; `radius_of` gets a random number in [0, 1) and says which blobs
/// there are.
fn field(radius_of: impl Fn(f64) -> Option<f64>) -> BlobField {
    let (mut centers, mut radii) = (Vec::new(), Vec::new());
    for i in 0..BLOBS as u64 {
        let mut random = Stream::new(7, i);
        let center = [(); 3].map(|()| random.unit() as f32 - 0.5);
        if let Some(radius) = radius_of(random.unit()) {
            centers.push(center);
            radii.push(radius as f32);
        }
    }
    let count = radii.len();
    BlobField {
        kernel: Kernel::Sextic,
        threshold: 0.2,
        origin: DVec3::splat(0.5),
        centers,
        shapes: Shapes::Balls(radii),
        weights: vec![1.0; count],
        rows: (0..count as u32).collect(),
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
fn small_blobs_among_large_ones_cost_rays_little() {
    let largest = 0.03;
    let large = work(field(|u| (u < 0.5).then_some(largest)));
    // The same blobs, and as many that are smaller: there is as much to see.
    let spread = work(field(|u| {
        Some(largest * 10_f64.powf(-6.0 * (2.0 * u - 1.0).max(0.0)))
    }));
    // Leaves are as small as f32 needs for their smallest blob, so small blobs take more nodes and leaves,
    // each with fewer blobs.
    for (what, limit, spread, large) in [
        ("nodes", 1.6, spread.nodes, large.nodes),
        ("leaves", 1.6, spread.leaves, large.leaves),
        (
            "blobs",
            1.0,
            spread.blob_evaluations,
            large.blob_evaluations,
        ),
    ] {
        let ratio = spread as f64 / large as f64;
        println!("{what}: {spread} against {large}, {ratio:.2}");
        assert!(ratio < limit, "{what}: {ratio:.2} times the work");
    }
}
