use super::{Segment, SupportTree};
use crate::field::{BlobField, Search};
use crate::kernel::Kernel;
use crate::primitive::Shapes;
use glam::DVec3;

fn field(blobs: impl Iterator<Item = ([f32; 3], f32)>) -> BlobField {
    let (centers, radii): (Vec<_>, Vec<_>) = blobs.unzip();
    BlobField {
        kernel: Kernel::Quartic,
        threshold: 0.5,
        origin: DVec3::ZERO,
        weights: vec![1.0; centers.len()],
        rows: (0..centers.len() as u32).collect(),
        centers,
        shapes: Shapes::Balls(radii),
        motion: None,
        attributes: Vec::new(),
        spacing: 1.0,
        search: Search::default(),
    }
}

fn fraction(i: u32, salt: u32) -> f32 {
    (i.wrapping_mul(2_654_435_761)
        .wrapping_add(salt)
        .wrapping_mul(0x9E37_79B1)
        >> 8) as f32
        / (1 << 24) as f32
}

#[test]
fn finds_every_support_that_a_ray_pierces() {
    let point = |i, salt| [0_u32, 1, 2].map(|axis| 10.0 * fraction(i, salt + axis));
    // Radii over six orders of magnitude.
    let field = field((0..500).map(|i| (point(i, 1), 10.0_f32.powf(6.0 * fraction(i, 9) - 5.0))));
    let tree = SupportTree::build(&field);
    let mut pierced = 0;
    for i in 0..500 {
        let (from, to) = (point(i, 77), point(i, 99));
        let origin = DVec3::from_array(from.map(f64::from));
        let direction = (DVec3::from_array(to.map(f64::from)) - origin).normalize();
        let segment = Segment {
            origin,
            direction,
            start: -1.0,
            end: 4.0,
            time_secs: 0.0,
        };
        let mut found = Vec::new();
        tree.for_each_on_ray(&segment, |blob| found.push(blob));
        for blob in 0..field.len() {
            let w = field.center(blob).as_dvec3() - origin;
            let nearest = direction * w.dot(direction).clamp(-1.0, 4.0);
            if field.shapes.q(blob, nearest - w) < 1.0 {
                pierced += 1;
                assert!(found.contains(&(blob as u32)), "ray {i}, blob {blob}");
            }
        }
    }
    assert!(pierced > 500, "only {pierced}");
}

#[test]
fn degenerate_sets_build() {
    for count in [0, 1, 2, 5, 100] {
        let tree = SupportTree::build(&field((0..count).map(|_| ([1.0; 3], 1.0))));
        let mut found = 0;
        let segment = Segment {
            origin: DVec3::new(-5.0, 1.0, 1.0),
            direction: DVec3::X,
            start: 0.0,
            end: f64::INFINITY,
            time_secs: 0.0,
        };
        tree.for_each_on_ray(&segment, |_| found += 1);
        assert_eq!(found, count);
    }
}
