use super::median_spacing;
use glam::DVec3;
use proptest::prelude::*;

fn by_definition(positions: &[DVec3]) -> Option<f64> {
    let nearest = |a: &DVec3| {
        let distances = positions.iter().map(|b| a.distance_squared(*b));
        distances
            .filter(|d| *d > 0.0)
            .fold(f64::INFINITY, f64::min)
            .sqrt()
    };
    let mut all: Vec<f64> = positions.iter().map(nearest).collect();
    all.sort_by(f64::total_cmp);
    let n = all.len();
    let median = (n > 0).then(|| (all[(n - 1) / 2] + all[n / 2]) / 2.0)?;
    median.is_finite().then_some(median)
}

fn assert_right(positions: &[DVec3]) {
    assert_eq!(median_spacing(positions), by_definition(positions));
}

fn scattered(count: usize, seed: u64, place: impl Fn([f64; 4]) -> DVec3) -> Vec<DVec3> {
    let mut state = seed;
    let mut next = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    (0..count)
        .map(|_| place([next(), next(), next(), next()]))
        .collect()
}

#[test]
fn few_or_identical_points_have_a_spacing_only_when_two_are_apart() {
    assert_eq!(median_spacing(&[]), None);
    assert_eq!(median_spacing(&[DVec3::ONE]), None);
    assert_eq!(median_spacing(&[DVec3::ONE; 100_000]), None);
    assert_eq!(
        median_spacing(&[DVec3::ZERO, DVec3::new(0.0, 3.0, 4.0)]),
        Some(5.0)
    );
    assert_eq!(
        median_spacing(&[DVec3::ZERO, DVec3::ZERO, DVec3::X, DVec3::X * 5.0]),
        Some(1.0)
    );
}

#[test]
fn sets_of_many_kinds_agree_with_the_definition() {
    let uniform = |[x, y, z, _]: [f64; 4]| DVec3::new(x, y, z);
    assert_right(&scattered(1500, 1, uniform));
    assert_right(&scattered(1500, 2, |[x, ..]| DVec3::X * x));
    assert_right(&scattered(1500, 3, |[x, y, ..]| {
        DVec3::new(x, y, 0.0).round()
    }));
    assert_right(&scattered(1500, 4, |r| uniform(r) * (-30.0 * r[3]).exp2()));
    assert_right(&scattered(1500, 5, |r| {
        uniform(r) * 1e-3 + DVec3::splat(1e6)
    }));
    // Two clusters of fine spacing, two million apart, and a stray far out.
    let mut clusters = scattered(1500, 6, |r| {
        uniform(r) * 0.01 + DVec3::X * if r[3] < 0.5 { -1e6 } else { 1e6 }
    });
    clusters.push(DVec3::splat(1e15));
    assert_right(&clusters);
    assert_right(&scattered(600, 7, |r| (uniform(r) - 0.5) * 1e300));
}

#[test]
fn many_duplicates_are_no_trouble() {
    let mut positions = vec![DVec3::ZERO; 200_000];
    positions.push(DVec3::new(2.0, 0.0, 0.0));
    assert_eq!(median_spacing(&positions), Some(2.0));
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let positions = scattered(60_000, 8, |[x, y, z, _]| DVec3::new(x, y, z));
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| median_spacing(&positions))
            .map(f64::to_bits)
    };
    assert_eq!(with(1), with(3));
    assert_eq!(with(1), with(8));
}

proptest! {
    #[test]
    fn small_sets_agree_with_the_definition(points in prop::collection::vec([-3_i8..4, -3_i8..4, -3_i8..4], 0..80)) {
        let positions: Vec<DVec3> = points.iter().map(|p| DVec3::from_array(p.map(f64::from))).collect();
        prop_assert_eq!(median_spacing(&positions), by_definition(&positions));
    }
}
