//! Whether light is neither lost nor made, and arrives by every way that there is.

use super::*;

#[test]
fn white_balls_of_every_material_vanish_in_white_light() {
    let rough = |material: Material, roughness: f64| Material {
        roughness: Some(roughness),
        absorption: material.kind.is_clear().then_some(Color::WHITE),
        ..material
    };
    let mut materials: Vec<Material> = MaterialKind::ALL
        .into_iter()
        .map(|kind| Material {
            absorption: kind.is_clear().then_some(Color::WHITE),
            ..material(kind)
        })
        .collect();
    for kind in [
        MaterialKind::Metal,
        MaterialKind::Plastic,
        MaterialKind::Glossy,
        MaterialKind::Water,
    ] {
        materials.push(rough(material(kind), 0.5));
    }
    materials.push(thin_glass(1.0));
    for material in materials {
        let frame = furnace(material.clone(), 1.0);
        for height in [0.0, 0.5, 0.9] {
            let ray = Ray::new(DVec3::new(0.1, height, 5.0), DVec3::NEG_Z);
            let (seen, error) = mean(&frame, &path_settings(400), &ray, 512);
            assert!(
                (seen - 1.0).abs() < 0.012 + 4.0 * error,
                "{material:?} at {height}: {seen} ± {error}"
            );
        }
    }
}

/// A thin sheet that leaves `left` of the light that goes through its thickness.
fn thin_glass(left: f64) -> Material {
    Material {
        thin: Some(true),
        absorption: Some(Color([left; 3])),
        ..material(MaterialKind::Glass)
    }
}

/// A white floor under a thin pane at height 1 in its own light.
fn floor_under_a_pane(light: Light) -> Frame {
    let mut scene = Scene::default();
    for (name, height, material) in [
        ("floor", 0.0, material(MaterialKind::Diffuse)),
        ("pane", 1.0, thin_glass(0.5)),
    ] {
        scene.materials.insert(name.to_owned(), material);
        scene.planes.push(Plane {
            point: DVec3::Y * height,
            material: Some(name.to_owned()),
            ..Plane::default()
        });
    }
    let mut frame = lit(&scene, Vec::new());
    frame.lights = vec![light];
    frame
}

/// Part of the light that a pane of glass lets through that absorbs half of it head on.
fn pane_transmittance(cosine: f64) -> f64 {
    let (face, other) = crate::shade::bsdf::dielectric_reflectance(cosine, 1.0 / 1.517);
    let once = 0.5_f64.powf(1.0 / other.unwrap());
    (1.0 - face).powi(2) * once / (1.0 - (face * once).powi(2))
}

#[test]
fn light_goes_straight_through_thin_panes_by_both_ways() {
    let eye = DVec3::new(0.3, 0.8, 0.0);
    let ray = Ray::new(eye, -eye.normalize());
    // One surface: what the floor throws up and the pane mirrors down again does not count.
    let close = |light: Light, expected: f64| {
        let frame = floor_under_a_pane(light.clone());
        let (seen, error) = mean(&frame, &path_settings(1), &ray, 8192);
        assert!(
            (seen - expected).abs() < 4.0 * error + 4e-3 * expected,
            "{light:?}: {seen} ± {error} for {expected}"
        );
    };
    // A lamp that drawn directions find, and a sky that scattered rays alone find.
    let angle: f64 = 0.6;
    close(
        Light::Sun {
            towards: DVec3::new(angle.sin(), angle.cos(), 0.0),
            radiance: [2.0; 3],
            half_angle: 0.01,
        },
        2.0 * angle.cos() * pane_transmittance(angle.cos()),
    );
    let steps = 2000;
    let sky: f64 = (0..steps)
        .map(|i| (f64::from(i) + 0.5) / f64::from(steps))
        .map(|cosine| 2.0 * cosine * pane_transmittance(cosine) / f64::from(steps))
        .sum();
    close(Light::Constant { radiance: [1.0; 3] }, sky);
    // A large lamp near by is found by both.
    let lamp = |steps: i32| -> f64 {
        let mut sum = 0.0;
        for i in 0..steps {
            for j in 0..steps {
                let at = |k: i32| (f64::from(k) + 0.5) / f64::from(steps) * 4.0 - 2.0;
                let towards = DVec3::new(at(i), 1.5, at(j));
                let squared = towards.length_squared();
                let cosine = 1.5 / squared.sqrt();
                sum += cosine * cosine / squared * pane_transmittance(cosine);
            }
        }
        sum * 16.0 / f64::from(steps * steps) / PI
    };
    close(
        Light::Rectangle {
            center: DVec3::Y * 1.5,
            edges: [DVec3::X * 4.0, DVec3::Z * 4.0],
            radiance: [1.0; 3],
        },
        lamp(400),
    );
}

#[test]
fn panes_show_what_is_behind_them_and_mirror_what_is_before() {
    let frame = floor_under_a_pane(Light::Constant { radiance: [1.0; 3] });
    let ray = Ray::new(DVec3::Y * 2.0, DVec3::NEG_Y);
    let through = pane_transmittance(1.0);
    let (face, _) = crate::shade::bsdf::dielectric_reflectance(1.0, 1.0 / 1.517);
    let mirrored = face * (1.0 + 0.5 * through);
    let whitted = ShadeSettings {
        integrator: IntegratorSettings {
            kind: IntegratorKind::Whitted,
            ..IntegratorSettings::default()
        },
        ..ShadeSettings::default()
    };
    // `whitted` lights the floor unshaded.
    let (seen, _) = mean(&frame, &whitted, &ray, 1);
    assert!((seen - (mirrored + through)).abs() < 1e-4, "{seen}");
    let shader = Shader::new(&frame, &whitted);
    let mut sampler = PixelSampler::new([0, 0], 0, 0);
    let first = see(&shader, &ray, &mut sampler, &mut ShadeScratch::default());
    assert!((first.hit.unwrap().t - 1.0).abs() < 1e-6);
}

#[test]
fn a_furnace_full_of_company_stays_white() {
    // Water in a glass, foam on it, a mirror beside, seen from within the water.
    let mut scene = Scene::default();
    let clear = |kind| Material {
        absorption: Some(Color::WHITE),
        ..material(kind)
    };
    named("glass", clear(MaterialKind::Glass), &mut scene);
    named("water", clear(MaterialKind::Water), &mut scene);
    named("foam", material(MaterialKind::Foam), &mut scene);
    named("mirror", material(MaterialKind::Mirror), &mut scene);
    for (name, place) in [
        ("glass", [0.0, 0.0, 0.0]),
        ("water", [0.5, 0.0, 0.0]),
        ("foam", [0.3, 0.9, 0.0]),
        ("mirror", [-1.4, 0.2, 0.3]),
    ] {
        scene.instances.push(Instance {
            surface: name.to_owned(),
            matrix: crate::scene::Matrix(glam::DAffine3::from_translation(place.into())),
            material: None,
            keys: Vec::new(),
        });
    }
    let fields = vec![ball(1.0), ball(1.2), ball(0.4), ball(0.5)];
    let frame = lit(&scene, fields);
    for eye in [DVec3::new(0.2, 0.3, 6.0), DVec3::new(1.3, 0.1, 0.0)] {
        for towards in [DVec3::ZERO, DVec3::new(0.3, 0.9, 0.0), DVec3::X * 0.9] {
            let ray = Ray::new(eye, (towards - eye).normalize());
            let (seen, error) = mean(&frame, &path_settings(2000), &ray, 512);
            assert!(
                (seen - 1.0).abs() < 0.01 + 4.0 * error,
                "{eye} to {towards}: {seen} ± {error}"
            );
        }
    }
}

#[test]
fn drawn_lights_and_found_lights_agree() {
    // A glossy ground under a rectangle and a ball: with both ways, and with scattered rays alone.
    let mut scene = Scene {
        planes: vec![Plane {
            material: Some("floor".to_owned()),
            ..Plane::default()
        }],
        ..Scene::default()
    };
    let floor = Material::glossy(Color([0.5; 3]), 1.0, 0.4);
    scene.materials.insert("floor".to_owned(), floor);
    let mut frame = Frame::build(&scene, Vec::new(), &FrameSettings::default()).unwrap();
    frame.lights = vec![
        Light::Rectangle {
            center: DVec3::new(0.0, 2.0, -1.0),
            edges: [DVec3::X * 2.0, DVec3::Z * 2.0],
            radiance: [2.0; 3],
        },
        Light::Sphere {
            center: DVec3::new(1.0, 1.0, 0.0),
            radius: 0.3,
            radiance: [4.0; 3],
        },
    ];
    let eye = DVec3::new(0.0, 1.0, 2.0);
    let ray = Ray::new(eye, (DVec3::ZERO - eye).normalize());
    let shader = Shader::new(&frame, &path_settings(1));
    let (both, error) = mean(&frame, &path_settings(1), &ray, 8192);
    // By quadrature over the sphere of what the lights show.
    let hit = frame.closest_hit(&ray, &mut Scratch::default()).unwrap();
    let mut scratch = ShadeScratch::default();
    let point = shader
        .world
        .interaction(&ray, hit, &MediumStack::default(), 0.0, &mut scratch)
        .unwrap();
    let mut expected = 0.0;
    let steps = 1200;
    for i in 0..steps {
        let z = (f64::from(i) + 0.5) / f64::from(steps);
        let sine = (1.0 - z * z).sqrt();
        for j in 0..2 * steps {
            let (sin, cos) = ((f64::from(j) + 0.5) / f64::from(steps) * PI).sin_cos();
            let local = DVec3::new(sine * cos, sine * sin, z);
            let world = point.to_world(local);
            if let Some((_, found)) = shader.world.lights.met(hit.position, world, f64::INFINITY) {
                let value = point.bsdf.evaluate(point.view, local) * found.radiance;
                expected += f64::from(value.y) * PI / f64::from(steps) / f64::from(steps);
            }
        }
    }
    assert!(
        (both - expected).abs() < 4.0 * error + 2e-3 * expected,
        "{both} ± {error} for {expected}"
    );
}

#[test]
fn lamps_shine_through_boundaries_that_are_none() {
    // A floor in water, and more water of another surface within it: both ways to a lamp in the first
    // water cross boundaries that are none.
    let mut scene = Scene::default();
    let water = Material {
        absorption: Some(Color::WHITE),
        ..Material::of(MaterialKind::Water, None)
    };
    named("drop", water.clone(), &mut scene);
    scene.materials.insert("water".to_owned(), water);
    scene
        .materials
        .insert("floor".to_owned(), material(MaterialKind::Diffuse));
    for (name, height) in [("floor", -1.5), ("water", 9.0)] {
        scene.planes.push(Plane {
            point: DVec3::Y * height,
            material: Some(name.to_owned()),
            ..Plane::default()
        });
    }
    let mut frame = lit(&scene, vec![ball(1.0)]);
    frame.lights = vec![Light::Sphere {
        center: DVec3::Y * 2.5,
        radius: 0.5,
        radiance: [2.0; 3],
    }];
    let eye = DVec3::new(3.0, 0.0, 0.0);
    let ray = Ray::new(eye, (DVec3::NEG_Y * 1.5 - eye).normalize());
    let (seen, error) = mean(&frame, &path_settings(1), &ray, 4096);
    // E/π = L r²/d², and the lamp's basic radiance is L/n².
    let expected = 2.0 * 0.25 / 16.0 / 1.333_f64.powi(2);
    assert!(
        (seen - expected).abs() < 4.0 * error + 1e-3 * expected,
        "{seen} ± {error} for {expected}"
    );
}

#[test]
fn limits_by_kind_keep_the_light_that_comes_before_them() {
    // A floor under a lamp needs one diffuse surface and no bounce.
    let mut scene = Scene::default();
    let floor = material(MaterialKind::Diffuse);
    scene.materials.insert("floor".to_owned(), floor);
    scene.planes.push(Plane {
        material: Some("floor".to_owned()),
        ..Plane::default()
    });
    let mut frame = lit(&scene, Vec::new());
    frame.lights = vec![Light::Sphere {
        center: DVec3::Y * 2.0,
        radius: 1.5,
        radiance: [1.0; 3],
    }];
    let mut settings = path_settings(8);
    settings.integrator.diffuse_depth = Some(0);
    let eye = DVec3::new(4.0, 1.0, 0.0);
    let ray = Ray::new(eye, -eye.normalize());
    let (seen, error) = mean(&frame, &settings, &ray, 4096);
    let expected = (1.5_f64 / 2.0).powi(2);
    assert!(
        (seen - expected).abs() < 4.0 * error + 2e-3,
        "{seen} ± {error}"
    );
}

#[test]
fn caustics_left_out_let_lamps_shine_straight_through_clear_surfaces() {
    // A floor under a clear pane of index 1 that absorbs half: exactly half of the sun arrives.
    let mut scene = Scene::default();
    for (name, height, material) in [
        ("floor", 0.0, material(MaterialKind::Diffuse)),
        (
            "fog",
            2.0,
            Material {
                ior: Some(1.0),
                absorption: Some(Color([0.5; 3])),
                absorption_depth: Some(2.0),
                ..Material::of(MaterialKind::Dielectric, None)
            },
        ),
    ] {
        scene.materials.insert(name.to_owned(), material);
        scene.planes.push(Plane {
            point: DVec3::Y * height,
            material: Some(name.to_owned()),
            ..Plane::default()
        });
    }
    let mut frame = lit(&scene, Vec::new());
    frame.lights = vec![Light::Sun {
        towards: DVec3::Y,
        radiance: [1.0; 3],
        half_angle: 0.01,
    }];
    let eye = DVec3::new(0.0, 1.0, 0.0);
    let ray = Ray::new(eye, DVec3::NEG_Y);
    let seen = |caustics: bool| {
        let mut settings = path_settings(1);
        settings.integrator.caustics = caustics;
        mean(&frame, &settings, &ray, 64).0
    };
    // A way of 1 from the floor to the eye, and 2 from the pane to the floor.
    let expected = 0.5 * 0.5_f64.sqrt();
    assert!((seen(false) - expected).abs() < 1e-3, "{}", seen(false));
    assert_eq!(seen(true), 0.0);
}
