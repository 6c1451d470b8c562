//! What one ray sees, against closed forms.

use super::*;

#[test]
fn absorption_in_a_ball_goes_by_the_chord_and_by_the_attribute() {
    let ior = 1.333;
    let water = Material {
        ior: Some(ior),
        absorption: Some(Color([0.5, 0.25, 1.0])),
        absorption_depth: Some(2.0),
        ..Material::of(MaterialKind::Water, None)
    };
    for (with_dye, density) in [(false, 1.0), (true, 0.5)] {
        let mut scene = Scene::default();
        named("ball", water.clone(), &mut scene);
        if with_dye {
            scene.surfaces[0].absorption_by = Some("dye".to_owned());
            scene.surfaces[0].absorption_range = Some([0.0, 0.5]);
        }
        let frame = lit(&scene, vec![ball(1.0)]);
        // Two surfaces: only the light that goes straight through both comes back.
        for height in [0.0, 0.6] {
            let ray = Ray::new(DVec3::new(0.0, height, 4.0), DVec3::NEG_Z);
            let (seen, error) = mean(&frame, &path_settings(2), &ray, 8192);
            let cosine = (1.0 - height * height).sqrt();
            let refracted = (1.0 - (height / ior).powi(2)).sqrt();
            let reflectance = crate::shade::bsdf::dielectric_reflectance(cosine, 1.0 / ior).0;
            let left = 0.25_f64.powf(2.0 * refracted / 2.0 * density);
            let expected = reflectance + (1.0 - reflectance).powi(2) * left;
            assert!(
                (seen - expected).abs() < 4.0 * error + 1e-3,
                "dye {with_dye}, height {height}: {seen} ± {error} for {expected}"
            );
        }
    }
}

#[test]
fn rays_leave_a_ball_where_closed_forms_say() {
    // Lights of one direction each show where mirrored and refracted rays go.
    let ior: f64 = 1.5;
    let glass = Material {
        ior: Some(ior),
        ..Material::of(MaterialKind::Dielectric, None)
    };
    for radius in [1e-3, 1.0, 1e4] {
        let frame = furnace(glass.clone(), radius);
        let outside = ShadeSettings {
            eye: DVec3::Z * 3.0 * radius,
            ..path_settings(8)
        };
        let shader = Shader::new(&frame, &outside);
        let mut scratch = ShadeScratch::default();
        let height = 0.5;
        let ray = Ray::new(DVec3::new(0.0, height, 3.0) * radius, DVec3::NEG_Z);
        let world = &shader.world;
        let hit = frame.closest_hit(&ray, &mut Scratch::default()).unwrap();
        let point = world
            .interaction(&ray, hit, &MediumStack::default(), 0.0, &mut scratch)
            .unwrap();
        let incident = height.asin();
        let angle_of = |d: DVec3| d.y.atan2(-d.z);
        let mirrored = point.bsdf.sample(point.view, 0.0, [0.5; 2]).unwrap();
        let mirrored = point.to_world(mirrored.light);
        assert!((angle_of(mirrored) - (PI - 2.0 * incident)).abs() < 1e-5);
        let refracted = point.bsdf.sample(point.view, 0.99, [0.5; 2]).unwrap();
        let inside = point.to_world(refracted.light);
        let bent = (height / ior).asin();
        assert!((angle_of(inside) + (incident - bent)).abs() < 1e-5);
        // On to the far side: the chord, then out, turned by twice the difference in all.
        let ray = point.leaving(inside, false, 0.0);
        let hit = frame.closest_hit(&ray, &mut Scratch::default()).unwrap();
        assert!(!hit.entering);
        assert!((hit.t / (2.0 * radius * bent.cos()) - 1.0).abs() < 1e-4);
        let exit = world
            .interaction(&ray, hit, &point.beyond, 0.0, &mut scratch)
            .unwrap();
        let out = exit.bsdf.sample(exit.view, 0.99, [0.5; 2]).unwrap();
        let out = exit.to_world(out.light);
        assert!(
            (angle_of(out) + 2.0 * (incident - bent)).abs() < 3e-4,
            "radius {radius}: {}",
            angle_of(out)
        );
        assert_eq!(exit.beyond, MediumStack::default());
    }
}

#[test]
fn a_ball_of_radius_ten_thousand_is_a_plane() {
    let radius = 1e4;
    let mut scene = Scene::default();
    named("ball", material(MaterialKind::Diffuse), &mut scene);
    let mut frame = lit(&scene, vec![ball(radius)]);
    frame.lights = vec![Light::Sphere {
        center: DVec3::new(0.0, radius + 2.0, 0.0),
        radius: 0.5,
        radiance: [3.0; 3],
    }];
    // Off the axis by 1: E = π L r²/d² cos θ.
    let target = DVec3::new(1.0, radius, 0.0);
    let eye = target + DVec3::new(1.0, 2.0, 3.0);
    let ray = Ray::new(eye, (target - eye).normalize());
    let (seen, error) = mean(&frame, &path_settings(3), &ray, 4096);
    let expected = 3.0 * 0.25 / 5.0 * (2.0 / 5.0_f64.sqrt());
    assert!(
        (seen - expected).abs() < 4.0 * error + 2e-3,
        "{seen} ± {error} for {expected}"
    );
    // No acne, no leak: without light nothing shines.
    frame.lights.clear();
    let settings = ShadeSettings {
        background: Background::Transparent,
        ..path_settings(8)
    };
    assert_eq!(mean(&frame, &settings, &ray, 256), (0.0, 0.0));
}

#[test]
fn ambient_occlusion_over_a_plane_has_its_closed_form() {
    // A ball of radius 1 whose centre is 2 above a plane covers 1/4 of the point below it, weighted by
    // the cosine: r²/d².
    let mut scene = Scene {
        ground: Some(Ground {
            height: Some(-2.0),
            ..Ground::default()
        }),
        ..Scene::default()
    };
    named("ball", material(MaterialKind::Diffuse), &mut scene);
    scene
        .materials
        .insert("white".to_owned(), material(MaterialKind::Diffuse));
    scene.ground.as_mut().unwrap().material = Some("white".to_owned());
    let frame = lit(&scene, vec![ball(1.0)]);
    let with = |samples: u32, distance: Option<f64>| ShadeSettings {
        integrator: IntegratorSettings {
            kind: IntegratorKind::Ao,
            samples: Some(samples),
            distance,
            ..IntegratorSettings::default()
        },
        ..ShadeSettings::default()
    };
    let eye = DVec3::new(4.0, 0.0, 0.0);
    let ray = Ray::new(eye, (DVec3::new(0.0, -2.0, 0.0) - eye).normalize());
    let open = |settings: &ShadeSettings| mean(&frame, settings, &ray, 16).0;
    assert!((open(&with(256, None)) - 0.75).abs() < 0.01);
    assert_eq!(open(&with(64, Some(0.9))), 1.0);
    // The top of the ball sees nothing but sky.
    let above = Ray::new(DVec3::new(0.0, 5.0, 0.0), DVec3::NEG_Y);
    assert_eq!(mean(&frame, &with(64, None), &above, 4).0, 1.0);
}

#[test]
fn whitted_splits_and_attenuates_as_the_tree_says() {
    let ior: f64 = 1.333;
    let glass = Material {
        ior: Some(ior),
        absorption: Some(Color([0.25; 3])),
        absorption_depth: Some(2.0),
        ..Material::of(MaterialKind::Dielectric, None)
    };
    let frame = furnace(glass, 1.0);
    let at_depth = |depth: u32| ShadeSettings {
        integrator: IntegratorSettings {
            kind: IntegratorKind::Whitted,
            depth,
            ..IntegratorSettings::default()
        },
        ..ShadeSettings::default()
    };
    let ray = Ray::new(DVec3::Z * 4.0, DVec3::NEG_Z);
    let seen = |depth: u32| mean(&frame, &at_depth(depth), &ray, 1).0;
    let r = ((ior - 1.0) / (ior + 1.0)).powi(2);
    // Straight through the middle: a chord of 2 leaves a quarter.
    assert!((seen(2) - r).abs() < 1e-4, "{}", seen(2));
    let expected = r + (1.0 - r) * 0.25 * (1.0 - r);
    assert!((seen(3) - expected).abs() < 1e-4, "{}", seen(3));
}

#[test]
fn an_eye_in_water_sees_total_reflection_beyond_the_critical_angle() {
    // Water below y = 0 under a sky that is 1 everywhere, and nothing below.
    let mut scene = Scene {
        planes: vec![Plane {
            material: Some("water".to_owned()),
            ..Plane::default()
        }],
        ..Scene::default()
    };
    let water = Material {
        absorption: Some(Color::WHITE),
        ..Material::of(MaterialKind::Water, None)
    };
    scene.materials.insert("water".to_owned(), water);
    let frame = lit(&scene, Vec::new());
    let eye = DVec3::new(0.0, -1.0, 0.0);
    let settings = ShadeSettings {
        eye,
        ..path_settings(4)
    };
    let shader = Shader::new(&frame, &settings);
    let mut scratch = ShadeScratch::default();
    for (angle, is_total) in [(0.3, false), (0.84, false), (0.86, true), (1.4, true)] {
        let direction = DVec3::new(f64::sin(angle), f64::cos(angle), 0.0);
        let ray = Ray::new(eye, direction);
        scratch.rays = Default::default();
        let seen = (0..64).map(|i| {
            let mut sampler = PixelSampler::new([0, 0], i, 0);
            see(&shader, &ray, &mut sampler, &mut scratch).radiance[0]
        });
        assert!(seen.count() == 64 && angle < FRAC_PI_2);
        assert_eq!(scratch.rays.refraction == 0, is_total, "{angle}");
    }
}
