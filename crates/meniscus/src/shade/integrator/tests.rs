//! Integrators against closed forms: a ball, a plane, a furnace.

use super::*;
use crate::field::{BlobField, FieldAttribute, Search};
use crate::frame::{FrameSettings, Light};
use crate::intersect::Scratch;
use crate::kernel::Kernel;
use crate::primitive::Shapes;
use crate::scene::{Color, Ground, Instance, Material, MaterialKind, Plane, Scene, Surface};
use std::f64::consts::{FRAC_PI_2, PI};

/// A ball of radius `radius` around the origin; its attribute `dye` is 0.25.
fn ball(radius: f64) -> BlobField {
    // Quartic, T = 0.25: q = 1/2 on the surface.
    let support = radius * 2.0_f64.sqrt();
    BlobField {
        kernel: Kernel::Quartic,
        threshold: 0.25,
        origin: DVec3::ZERO,
        centers: vec![[0.0; 3]],
        shapes: Shapes::Balls(vec![support as f32]),
        weights: vec![1.0],
        rows: vec![0],
        attributes: vec![FieldAttribute {
            name: "dye".to_owned(),
            components: 1,
            data: vec![0.25],
        }],
        spacing: radius as f32,
        search: Search::default(),
    }
}

fn named(surface: &str, material: Material, scene: &mut Scene) {
    scene.materials.insert(surface.to_owned(), material);
    scene.surfaces.push(Surface {
        name: Some(surface.to_owned()),
        material: Some(surface.to_owned()),
        ..Surface::default()
    });
}

/// A ball of a material in a constant light of 1.
fn furnace(material: Material, radius: f64) -> Frame {
    let mut scene = Scene::default();
    named("ball", material, &mut scene);
    lit(&scene, vec![ball(radius)])
}

fn lit(scene: &Scene, fields: Vec<BlobField>) -> Frame {
    let mut frame = Frame::build(scene, fields, &FrameSettings::default()).unwrap();
    frame.lights = vec![Light::Constant { radiance: [1.0; 3] }];
    frame
}

fn path_settings(depth: u32) -> ShadeSettings {
    ShadeSettings {
        integrator: IntegratorSettings {
            kind: IntegratorKind::Path,
            depth,
            ..IntegratorSettings::default()
        },
        ..ShadeSettings::default()
    }
}

/// Mean, and standard error of the mean, of `count` samples along one ray, green.
fn mean(frame: &Frame, settings: &ShadeSettings, ray: &Ray, count: u32) -> (f64, f64) {
    let settings = ShadeSettings {
        eye: ray.origin,
        ..settings.clone()
    };
    let shader = Shader::new(frame, &settings);
    let mut scratch = ShadeScratch::default();
    let (mut sum, mut squares) = (0.0, 0.0);
    for i in 0..count {
        let mut sampler = PixelSampler::new([3, 5], i, 0);
        sampler.next_2d();
        let light = f64::from(shader.sample(ray, &mut sampler, &mut scratch).radiance[1]);
        sum += light;
        squares += light * light;
    }
    let count = f64::from(count);
    let mean = sum / count;
    let variance = (squares / count - mean * mean).max(0.0);
    (mean, (variance / count).sqrt())
}

fn material(kind: MaterialKind) -> Material {
    Material::of(kind, Some(Color::WHITE))
}

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
            shader.sample(&ray, &mut sampler, &mut scratch).radiance[0]
        });
        assert!(seen.count() == 64 && angle < FRAC_PI_2);
        assert_eq!(scratch.rays.refraction == 0, is_total, "{angle}");
    }
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
