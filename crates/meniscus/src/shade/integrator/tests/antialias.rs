//! Widened highlights: no light is made or lost, and differentials arrive where they should.

use super::*;
use crate::math::differential::RayDifferential;
use crate::shade::antialias::PIXEL_VARIANCE;
use crate::shade::interaction::Turn;
use glam::Vec3;

/// A ray whose neighbours in the film lie this far apart in direction.
fn broad(ray: Ray, step: f32) -> Ray {
    Ray {
        differential: Some(RayDifferential {
            origin: [Vec3::ZERO; 3],
            direction: [Vec3::X * step, Vec3::Y * step, Vec3::ZERO],
        }),
        ..ray
    }
}

fn antialiased(settings: ShadeSettings) -> ShadeSettings {
    ShadeSettings {
        integrator: IntegratorSettings {
            specular_antialiasing: true,
            ..settings.integrator
        },
        ..settings
    }
}

#[test]
fn widened_white_balls_vanish_in_white_light() {
    for kind in [
        MaterialKind::Mirror,
        MaterialKind::Metal,
        MaterialKind::Plastic,
        MaterialKind::Glossy,
        MaterialKind::Water,
    ] {
        for roughness in [0.0, 0.1, 0.4] {
            let material = Material {
                roughness: Some(roughness),
                absorption: kind.is_clear().then_some(Color::WHITE),
                ..material(kind)
            };
            let frame = furnace(material, 1.0);
            for (height, step) in [(0.0, 0.02), (0.6, 0.02), (0.9, 0.05)] {
                let ray = Ray::new(DVec3::new(0.1, height, 5.0), DVec3::NEG_Z);
                let settings = antialiased(path_settings(400));
                let (seen, error) = mean(&frame, &settings, &broad(ray, step), 512);
                // What is given back of lost light is that of a round lobe of the same mean width.
                assert!(
                    (seen - 1.0).abs() < 0.025 + 4.0 * error,
                    "{kind:?} {roughness} at {height}: {seen} ± {error}"
                );
            }
        }
    }
}

#[test]
fn nothing_changes_without_the_switch_or_where_normals_are_alike() {
    let polished = Material {
        roughness: Some(0.2),
        ..material(MaterialKind::Metal)
    };
    let mut scene = Scene::default();
    scene.materials.insert("floor".to_owned(), polished);
    scene.planes.push(Plane {
        material: Some("floor".to_owned()),
        ..Plane::default()
    });
    let mut frame = lit(&scene, Vec::new());
    frame.lights = vec![Light::Sun {
        towards: DVec3::new(0.3, 1.0, 0.1).normalize(),
        radiance: [1.0; 3],
        half_angle: 0.02,
    }];
    let eye = DVec3::new(-0.3, 1.0, -0.1);
    let ray = broad(Ray::new(eye, -eye.normalize()), 0.05);
    let (plain, _) = mean(&frame, &path_settings(1), &ray, 64);
    let (flat, _) = mean(&frame, &antialiased(path_settings(1)), &ray, 64);
    assert!(plain > 0.0);
    assert_eq!(plain, flat);
}

#[test]
fn a_highlight_is_the_mean_of_those_within_the_pixel() {
    // A polished ball under a sun: what the middle of a pixel sees, widened, against the mean over the
    // Gaussian pixel, beside the highlight's peak and on its flank.
    let polished = Material {
        roughness: Some(0.25),
        ..material(MaterialKind::Metal)
    };
    let mut frame = furnace(polished, 1.0);
    frame.lights = vec![Light::Sun {
        towards: DVec3::new(0.5, 0.4, 1.0).normalize(),
        radiance: [1.0; 3],
        half_angle: 1e-3,
    }];
    let eye = DVec3::Z * 6.0;
    // Normals turn by about 0.08 per pixel.
    let step = 0.016;
    let see_at = |x: f64, y: f64, settings: &ShadeSettings| {
        let direction = (DVec3::new(x, y, 0.0) - DVec3::Z * 6.0).normalize();
        mean(&frame, settings, &broad(Ray::new(eye, direction), step), 4).0
    };
    let (plain, wide) = (path_settings(1), antialiased(path_settings(1)));
    let sigma = PIXEL_VARIANCE.sqrt() * f64::from(step) * 6.0;
    let (mut error, mut error_of_plain, mut total) = (0.0, 0.0, 0.0);
    for (x, y) in [
        (0.25, 0.2),
        (0.3, 0.2),
        (0.2, 0.3),
        (0.38, 0.28),
        (0.1, 0.12),
    ] {
        let (mut sum, mut weights) = (0.0, 0.0);
        for i in -6_i32..=6 {
            for j in -6_i32..=6 {
                let (u, v) = (f64::from(i) * 0.5, f64::from(j) * 0.5);
                let weight = (-0.5 * (u * u + v * v)).exp();
                sum += weight * see_at(x + u * sigma, y + v * sigma, &plain);
                weights += weight;
            }
        }
        let expected = sum / weights;
        error += (see_at(x, y, &wide) - expected).abs();
        error_of_plain += (see_at(x, y, &plain) - expected).abs();
        total += expected;
    }
    assert!(
        error < 0.25 * total && error < 0.5 * error_of_plain,
        "{error}, without {error_of_plain}, of {total}"
    );
}

#[test]
fn rays_carry_their_differentials_through_a_ball_of_glass() {
    let mut clear = material(MaterialKind::Glass);
    clear.absorption = Some(Color::WHITE);
    let frame = furnace(clear, 1.0);
    let settings = antialiased(path_settings(8));
    let shader = Shader::new(&frame, &settings);
    let start = |x: f64| Ray::new(DVec3::new(0.3 + x, 0.2, 5.0), DVec3::NEG_Z);
    let mut scratch = ShadeScratch::default();
    // Straight to the point on the far side, refracted once.
    let mut far = |ray: &Ray| {
        let hit = frame.closest_hit(ray, &mut scratch.trace).unwrap();
        let outside = MediumStack::default();
        let point = shader
            .world
            .interaction(ray, hit, &outside, 0.0, &mut scratch)
            .unwrap();
        let eta = point.bsdf.index_ratio().unwrap();
        let cosine = point.view.z;
        let (_, other) = crate::shade::bsdf::dielectric_reflectance(cosine, eta);
        let local = DVec3::new(-eta * point.view.x, -eta * point.view.y, -other.unwrap());
        let inner = Ray {
            differential: point.differential(ray, Turn::Refraction(eta)),
            ..point.leaving(point.to_world(local), false, 0.0)
        };
        let hit = frame.closest_hit(&inner, &mut scratch.trace).unwrap();
        (inner, hit)
    };
    let ray = Ray {
        differential: Some(RayDifferential {
            origin: [Vec3::X, Vec3::Y, Vec3::ZERO],
            direction: [Vec3::ZERO; 3],
        }),
        ..start(0.0)
    };
    let (inner, hit) = far(&ray);
    let surface = frame.level_set(&hit, 0.0);
    let differential = inner.differential.unwrap();
    let found = differential.at_hit(inner.direction, hit.t, &surface);
    let h = 1e-3;
    let [after, before] = [h, -h].map(|x| far(&start(x)).1);
    let position = (after.position - before.position) / (2.0 * h);
    let normal = (after.normal - before.normal) / (2.0 * h);
    let error = found[0].position.distance(position) + found[0].normal.distance(normal);
    assert!(error < 2e-3, "{found:?} for {position}, {normal}");
}
