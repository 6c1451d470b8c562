use super::*;

fn sample(seed: u32) -> ([f32; 3], f32) {
    let value = |k: u32| {
        let hash = (seed * 7 + k).wrapping_mul(2_654_435_761);
        (hash >> 8) as f32 / 1e6
    };
    (
        [value(0), value(1), value(2)],
        f32::from(!seed.is_multiple_of(3)),
    )
}

fn add_sample(film: &mut Film, x: u32, y: u32, s: u32) {
    let (radiance, coverage) = sample(x * 131 + y * 17 + s);
    let surface = (coverage > 0.0).then_some(crate::film::SurfaceSample {
        depth: radiance[0],
        position: radiance,
        normal: [0.0, 1.0, 0.0],
        motion: [0.0; 2],
        curvature: [0.0; 2],
        id: x + s,
        surface: 0,
    });
    let offset = [f64::from(s % 4) * 0.2 - 0.3, f64::from(s / 4) * 0.2 - 0.3];
    film.add(
        x,
        y,
        s,
        offset,
        &PixelSample {
            radiance,
            coverage,
            backdrop: 1.0 - coverage,
            albedo: radiance,
            denoising_albedo: [0.0; 3],
            surface,
            attributes: &[radiance[1], radiance[2]],
        },
    );
}

fn channels() -> Arc<ChannelSet> {
    let attributes = [("density".to_owned(), 1), ("age".to_owned(), 1)];
    Arc::new(ChannelSet::new(&["all"], &attributes).unwrap())
}

fn film(region: Region) -> Film {
    Film::new([8, 6], region, channels(), Background::Transparent).unwrap()
}

#[test]
fn tiles_and_sample_ranges_merge_to_the_same_bits_in_any_order() {
    let full = Region::full(8, 6);
    let mut whole = film(full);
    let mut parts = Vec::new();
    for tile in full.tiles(3) {
        for samples in [8..16_u32, 0..5, 5..8] {
            let mut part = film(tile);
            for s in samples {
                for y in tile.y..tile.y + tile.height {
                    for x in tile.x..tile.x + tile.width {
                        add_sample(&mut part, x, y, s);
                    }
                }
            }
            parts.push(part);
        }
    }
    for y in 0..6 {
        for x in 0..8 {
            for s in 0..16 {
                add_sample(&mut whole, x, y, s);
            }
        }
    }
    let mut forward = film(full);
    let mut backward = film(full);
    for part in &parts {
        forward.merge(part).unwrap();
    }
    for part in parts.iter().rev() {
        backward.merge(part).unwrap();
    }
    assert_eq!(whole, forward);
    assert_eq!(whole, backward);
    assert_eq!(
        whole.plane_named("samples"),
        Some(PlaneData::F32(vec![16.0; 48]))
    );
}

#[test]
fn means_and_nearest_are_what_they_say() {
    let mut film = film(Region::full(8, 6));
    for s in 0..4 {
        add_sample(&mut film, 2, 1, s);
    }
    let pixel = film.region().index(2, 1).unwrap();
    let expected: f64 = (0..4)
        .map(|s| f64::from(sample(2 * 131 + 17 + s).0[1]) / 4.0)
        .sum();
    assert!((f64::from(film.rgba(pixel)[1]) - expected).abs() < 1e-6 * expected);
    // Sample 1 and 2 lie 0.1 pixel from the centre column; sample 1 is the first of them.
    let (radiance, coverage) = sample(2 * 131 + 17 + 1);
    assert_eq!(coverage, 1.0, "the test's own sample should hit");
    let PlaneData::F32(z) = film.plane_named("Z").unwrap() else {
        panic!("Z is real");
    };
    assert_eq!(z[pixel], radiance[0]);
    assert_eq!(z[0], f32::INFINITY);
    let PlaneData::F32(age) = film.plane_named("age").unwrap() else {
        panic!("age is real");
    };
    assert_eq!(age[pixel], radiance[2]);
    let PlaneData::U32(id) = film.plane_named("id").unwrap() else {
        panic!("id is an index");
    };
    assert_eq!((id[pixel], id[0]), (3, NO_INDEX));
}

#[test]
fn not_a_number_and_huge_light_do_not_spoil_a_pixel() {
    let mut film = film(Region::full(8, 6));
    for (s, light) in [f32::NAN, f32::INFINITY, 1.0].into_iter().enumerate() {
        let seen = PixelSample {
            radiance: [light; 3],
            coverage: 1.0,
            backdrop: 0.0,
            albedo: [0.5; 3],
            denoising_albedo: [0.0; 3],
            surface: None,
            attributes: &[],
        };
        film.add(0, 0, s as u32, [0.0, 0.0], &seen);
    }
    assert!(film.rgba(0).iter().all(|x| x.is_finite()));
    assert_eq!(film.rgba(0)[3], 1.0);
}

#[test]
fn films_of_different_pictures_do_not_merge() {
    let mut whole = film(Region::full(8, 6));
    let plain = Film::new(
        [8, 6],
        Region::full(8, 6),
        Arc::new(ChannelSet::default()),
        Background::Transparent,
    )
    .unwrap();
    assert!(matches!(
        whole.merge(&plain),
        Err(FilmError::Merge { what: "channels" })
    ));
}
