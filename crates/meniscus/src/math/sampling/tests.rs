use super::*;

fn points(pixel: [u32; 2], count: u32) -> Vec<[f64; 2]> {
    (0..count)
        .map(|sample| PixelSampler::new(pixel, sample, 0).next_2d())
        .collect()
}

#[test]
fn every_draw_of_sixteen_samples_fills_every_stratum_once() {
    for (x, y) in [(0, 0), (7, 3), (1279, 719)] {
        let mut samplers: Vec<_> = (0..16).map(|s| PixelSampler::new([x, y], s, 5)).collect();
        for draw in 0..40 {
            let mut cells = [0; 16];
            for sampler in &mut samplers {
                let [u, v] = sampler.next_2d();
                assert!((0.0..1.0).contains(&u) && (0.0..1.0).contains(&v));
                cells[(u * 4.0) as usize * 4 + (v * 4.0) as usize] += 1;
            }
            assert_eq!(cells, [1; 16], "draw {draw} of pixel {x}, {y}");
            let mut strata = [0; 16];
            for sampler in &mut samplers {
                strata[(sampler.next_1d() * 16.0) as usize] += 1;
            }
            assert_eq!(strata, [1; 16], "draw {draw} of pixel {x}, {y}");
        }
    }
}

#[test]
fn numbers_depend_on_pixel_sample_and_seed_alone() {
    let draw = |pixel, sample, seed| {
        let mut sampler = PixelSampler::new(pixel, sample, seed);
        [sampler.next_1d(), sampler.next_1d(), sampler.next_1d()]
    };
    let one = draw([3, 4], 5, 6);
    assert_eq!(one, draw([3, 4], 5, 6));
    let others = [
        draw([4, 3], 5, 6),
        draw([3, 4], 6, 6),
        draw([3, 4], 5, 7),
        draw([3, 4], 5 + SEQUENCE_LENGTH, 6),
    ];
    for other in others {
        assert_ne!(one, other);
    }
    assert!(one[0] != one[1] && one[1] != one[2]);
}

#[test]
fn neighbouring_pixels_and_dimensions_are_uncorrelated() {
    let (mut across, mut along, mut mean) = (0.0, 0.0, 0.0);
    let count = 20_000;
    for x in 0..count {
        let mut here = PixelSampler::new([x, 9], 0, 0);
        let [a, b] = [here.next_1d(), here.next_1d()];
        let next = PixelSampler::new([x + 1, 9], 0, 0).next_1d();
        mean += a;
        along += (a - 0.5) * (b - 0.5);
        across += (a - 0.5) * (next - 0.5);
    }
    let count = f64::from(count);
    // Standard deviations: 0.289/√n = 0.002 of the mean, 1/12/√n = 0.0006 of a covariance.
    assert!((mean / count - 0.5).abs() < 0.01, "{}", mean / count);
    assert!((along / count).abs() < 0.003, "{}", along / count);
    assert!((across / count).abs() < 0.003, "{}", across / count);
}

#[test]
fn things_are_drawn_by_their_weights() {
    let some = Distribution::new([0.0, 1.0, 0.0, 3.0, 0.0].into_iter());
    let mut counts = [0; 5];
    for i in 0..1000 {
        let u = (f64::from(i) + 0.5) / 1000.0;
        let (index, through, part) = some.sample(u).unwrap();
        counts[index] += 1;
        assert!((0.0..1.0).contains(&through));
        assert_eq!(part, some.part(index));
    }
    assert_eq!(counts, [0, 250, 0, 750, 0]);
    assert_eq!(some.sample(1.0 - f64::EPSILON / 2.0).unwrap().0, 3);
    assert_eq!(Distribution::new([0.0; 3].into_iter()).sample(0.5), None);
    assert_eq!(Distribution::new(std::iter::empty()).sample(0.5), None);
}

#[test]
fn points_of_one_draw_are_stratified_with_those_of_other_samples() {
    let mut cells = [0; 64];
    for sample in 0..16 {
        let mut sampler = PixelSampler::new([3, 1], sample, 0);
        for [u, v] in sampler.next_2d_of(4) {
            cells[(u * 8.0) as usize * 8 + (v * 8.0) as usize] += 1;
        }
    }
    assert_eq!(cells, [1; 64]);
}

#[test]
fn disk_is_uniform_by_area() {
    let mut quadrants = [0_u32; 4];
    let mut inner = 0;
    for u in points([1, 2], 4096) {
        let [x, y] = uniform_disk(u);
        let square = x * x + y * y;
        assert!(square <= 1.0 + 1e-12);
        inner += u32::from(square < 0.25);
        quadrants[usize::from(x < 0.0) * 2 + usize::from(y < 0.0)] += 1;
    }
    assert!((f64::from(inner) / 4096.0 - 0.25).abs() < 0.01, "{inner}");
    for count in quadrants {
        assert!(
            (f64::from(count) / 4096.0 - 0.25).abs() < 0.01,
            "{quadrants:?}"
        );
    }
    assert_eq!(uniform_disk([0.5, 0.5]), [0.0, 0.0]);
}

#[test]
fn hemisphere_directions_have_a_cosine_density() {
    let normals = [
        DVec3::Z,
        DVec3::NEG_Z,
        DVec3::X,
        DVec3::new(0.3, -0.5, -0.8).normalize(),
    ];
    for normal in normals {
        let (mut cosines, mut squares) = (0.0, 0.0);
        for u in points([5, 5], 4096) {
            let direction = cosine_hemisphere(normal, u);
            assert!((direction.length() - 1.0).abs() < 1e-12);
            let cosine = direction.dot(normal);
            assert!(cosine >= -1e-12);
            cosines += cosine;
            squares += cosine * cosine;
        }
        assert!(
            (cosines / 4096.0 - 2.0 / 3.0).abs() < 2e-3,
            "{}",
            cosines / 4096.0
        );
        assert!(
            (squares / 4096.0 - 0.5).abs() < 2e-3,
            "{}",
            squares / 4096.0
        );
    }
}

#[test]
fn sphere_directions_are_uniform() {
    let sum = points([8, 8], 4096)
        .into_iter()
        .fold([DVec3::ZERO; 2], |[first, second], u| {
            let d = uniform_sphere(u);
            assert!((d.length() - 1.0).abs() < 1e-12);
            [first + d, second + d * d]
        });
    assert!((sum[0] / 4096.0).length() < 5e-3, "{}", sum[0] / 4096.0);
    assert!(
        (sum[1] / 4096.0 - 1.0 / 3.0).length() < 5e-3,
        "{}",
        sum[1] / 4096.0
    );
}

#[test]
fn tangents_are_right_handed_and_orthonormal() {
    for u in points([2, 1], 512) {
        let n = uniform_sphere(u);
        let [t, b] = tangents(n);
        assert!((t.length() - 1.0).abs() < 1e-9 && (b.length() - 1.0).abs() < 1e-9);
        assert!(t.cross(b).distance(n) < 1e-9, "{n}");
    }
}

#[test]
fn filter_offsets_follow_the_window() {
    let filter = PixelFilter::default();
    // Moments of the window by the midpoint rule.
    let window = |x: f64| {
        let t = 0.5 * (x + 1.0);
        (0..4)
            .map(|k| PixelFilter::TERMS[k] * (TAU * k as f64 * t).cos())
            .sum::<f64>()
    };
    let steps: Vec<f64> = (0..2000)
        .map(|i| (f64::from(i) + 0.5) / 1000.0 - 1.0)
        .collect();
    let area: f64 = steps.iter().map(|&x| window(x)).sum();
    let variance = steps.iter().map(|&x| x * x * window(x)).sum::<f64>() / area;
    assert!((0.05..0.09).contains(&variance), "{variance}");

    let count = 4096;
    let (mut mean, mut square) = ([0.0; 2], [0.0; 2]);
    for u in points([0, 0], count) {
        let offset = filter.offset(u);
        for axis in 0..2 {
            assert!(offset[axis].abs() <= PixelFilter::RADIUS);
            mean[axis] += offset[axis] / f64::from(count);
            square[axis] += offset[axis] * offset[axis] / f64::from(count);
        }
    }
    for axis in 0..2 {
        assert!(mean[axis].abs() < 1e-3, "{mean:?}");
        assert!(
            (square[axis] - variance).abs() < 1e-3,
            "{square:?} against {variance}"
        );
    }
}

#[test]
fn a_single_sample_lies_at_the_pixel_centre() {
    let filter = PixelFilter::default();
    let at = |spp| filter.film_position([3, 5], spp, &mut PixelSampler::new([3, 5], 0, 0));
    assert_eq!(at(1), [3.5, 5.5]);
    assert_ne!(at(4), [3.5, 5.5]);
}

#[test]
fn times_cover_the_shutter_in_every_pixel_and_agree_in_blocks() {
    for spp in [1_u32, 2, 3, 16, 24] {
        let strata = 1_u32 << spp.ilog2();
        let stratum = |pixel, sample| {
            let part = Moments::new(spp, 5).part_of_shutter(pixel, sample);
            assert!((0.0..1.0).contains(&part));
            (part * f64::from(strata)) as u32
        };
        for pixel in [[0, 0], [7, 9], [640, 3]] {
            let mut seen: Vec<u32> = (0..strata).map(|sample| stratum(pixel, sample)).collect();
            for (sample, &stratum_of_first) in seen.iter().enumerate() {
                let neighbour = pixel.map(|k| k / TIME_BLOCK * TIME_BLOCK + 3);
                assert_eq!(stratum(neighbour, sample as u32), stratum_of_first);
            }
            seen.sort_unstable();
            assert!(seen.into_iter().eq(0..strata), "{spp}");
        }
    }
    // Blocks take strata in other orders, and pixels of a block other places in one.
    let mut moments = Moments::new(16, 5);
    let mut part = |pixel| moments.part_of_shutter(pixel, 0);
    let mut first = |k: u32| (part([4 * k, 0]) * 16.0) as u32;
    let of_origin = first(0);
    assert!((1..9).any(|k| first(k) != of_origin));
    assert!(part([0, 0]) != part([1, 0]));
    let mean = (0..4096).map(|k| part([k, 8])).sum::<f64>() / 4096.0;
    assert!((mean - 0.5).abs() < 0.04, "{mean}");
}
