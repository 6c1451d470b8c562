use super::*;
use crate::math::sampling::{PixelSampler, uniform_sphere};
use std::f64::consts::{PI, TAU};

/// What models share.
struct Models {
    coat: Coat,
    water: RoughBoundary,
}

impl Models {
    fn new() -> Self {
        Self {
            coat: Coat::new(1.5, 1.0),
            water: RoughBoundary::new(1.333),
        }
    }

    /// White models by name.
    fn white(&self, roughness: f64) -> Vec<(&'static str, Bsdf<'_>)> {
        let boundary = Some(&self.water);
        vec![
            ("diffuse", Bsdf::Diffuse(Diffuse { color: Vec3::ONE })),
            (
                "foam",
                Bsdf::Foam(Foam {
                    color: Vec3::ONE,
                    translucency: 0.3,
                }),
            ),
            (
                "conductor",
                Bsdf::Conductor(Conductor::new(Vec3::ONE, roughness)),
            ),
            (
                "plastic",
                Bsdf::Plastic(Plastic::new(&self.coat, Vec3::ONE, roughness)),
            ),
            (
                "water from above",
                Bsdf::Dielectric(Dielectric::new([1.0, 1.333], roughness, boundary)),
            ),
            (
                "water from below",
                Bsdf::Dielectric(Dielectric::new([1.333, 1.0], roughness, boundary)),
            ),
        ]
    }
}

fn view_at(cosine: f64) -> DVec3 {
    let sine = (1.0 - cosine * cosine).sqrt();
    DVec3::new(0.6 * sine, -0.8 * sine, cosine)
}

const ROUGHNESSES: [f64; 5] = [0.0, 0.2, 0.45, 0.7, 1.0];
const COSINES: [f64; 4] = [1.0, 0.8, 0.4, 0.1];

/// Calls `visit(direction, solid angle)` over the sphere, even in both angles.
fn over_sphere(steps: u32, mut visit: impl FnMut(DVec3, f64)) {
    let step = PI / f64::from(steps);
    for i in 0..steps {
        let (sine, z) = ((f64::from(i) + 0.5) * step).sin_cos();
        for j in 0..2 * steps {
            let (sin, cos) = ((f64::from(j) + 0.5) * step).sin_cos();
            let solid = sine * step * step;
            visit(DVec3::new(sine * cos, sine * sin, z), solid);
        }
    }
}

#[test]
fn white_surfaces_in_white_light_are_white_by_sampling() {
    let models = Models::new();
    let count = 4096;
    for roughness in ROUGHNESSES {
        let sheet = Bsdf::Sheet(Sheet::new(0.6, 1.0 / 1.5, Vec3::ZERO));
        for (name, bsdf) in models
            .white(roughness)
            .into_iter()
            .chain([("sheet", sheet)])
        {
            for cosine in COSINES {
                let view = view_at(cosine);
                let mut sum = 0.0;
                for i in 0..count {
                    let mut sampler = PixelSampler::new([7, 9], i, 1);
                    let (choice, u) = (sampler.next_1d(), sampler.next_2d());
                    if let Some(sample) = bsdf.sample(view, choice, u) {
                        assert!((sample.light.length() - 1.0).abs() < 1e-9);
                        sum += f64::from(sample.weight.y);
                    }
                }
                let albedo = sum / f64::from(count);
                assert!(
                    (albedo - 1.0).abs() < 0.012,
                    "{name}, roughness {roughness}, cosine {cosine}: {albedo}"
                );
            }
        }
    }
}

#[test]
fn white_surfaces_in_white_light_are_white_by_quadrature_and_densities_sum_to_one() {
    let models = Models::new();
    for roughness in [0.45, 0.7, 1.0] {
        for (name, bsdf) in models.white(roughness) {
            for cosine in [1.0, 0.8, 0.4] {
                let view = view_at(cosine);
                let (mut albedo, mut density) = (0.0, 0.0);
                over_sphere(600, |light, solid| {
                    albedo += f64::from(bsdf.evaluate(view, light).y) * solid;
                    density += bsdf.density(view, light) * solid;
                });
                let place = format!("{name}, roughness {roughness}, cosine {cosine}");
                assert!((albedo - 1.0).abs() < 0.012, "{place}: {albedo}");
                // Facets that would send light below the horizon draw nothing: density is lost there.
                assert!(density < 1.002, "{place}: {density}");
                let lost = (0..4096).filter(|&i| {
                    let mut sampler = PixelSampler::new([1, 2], i, 3);
                    let (choice, u) = (sampler.next_1d(), sampler.next_2d());
                    bsdf.sample(view, choice, u).is_none()
                });
                let lost = lost.count() as f64 / 4096.0;
                assert!(
                    (density + lost - 1.0).abs() < 0.01,
                    "{place}: {density} + {lost}"
                );
            }
        }
    }
}

#[test]
fn directions_are_drawn_with_the_density_stated() {
    const BANDS: usize = 8;
    const SECTORS: usize = 6;
    let cell = |light: DVec3| {
        let band = ((light.z + 1.0) * 0.5 * BANDS as f64) as usize;
        let sector = ((light.y.atan2(light.x) / TAU + 0.5) * SECTORS as f64) as usize;
        band.min(BANDS - 1) * SECTORS + sector.min(SECTORS - 1)
    };
    let models = Models::new();
    for roughness in [0.45, 0.8] {
        for (name, bsdf) in models.white(roughness) {
            let view = view_at(0.6);
            let mut expected = [0.0; BANDS * SECTORS];
            over_sphere(600, |light, solid| {
                expected[cell(light)] += bsdf.density(view, light) * solid;
            });
            let count = 1 << 14;
            let mut found = [0.0; BANDS * SECTORS];
            for i in 0..count {
                let mut sampler = PixelSampler::new([5, 5], i, 2);
                let (choice, u) = (sampler.next_1d(), sampler.next_2d());
                if let Some(sample) = bsdf.sample(view, choice, u) {
                    found[cell(sample.light)] += 1.0;
                    let density = bsdf.density(view, sample.light);
                    assert!(
                        (density / sample.density - 1.0).abs() < 1e-6,
                        "{name}: {density} for {}",
                        sample.density
                    );
                    let value = bsdf.evaluate(view, sample.light).y;
                    let weight = f64::from(value) / density;
                    assert!(
                        (weight / f64::from(sample.weight.y) - 1.0).abs() < 1e-3,
                        "{name}: {weight} for {}",
                        sample.weight.y
                    );
                }
            }
            // χ² of independent draws has mean 48 and standard deviation 10; these are stratified.
            let chi: f64 = expected
                .iter()
                .zip(found)
                .filter(|(p, _)| **p * f64::from(count) > 5.0)
                .map(|(p, n)| {
                    let mean = p * f64::from(count);
                    (n - mean) * (n - mean) / mean
                })
                .sum();
            assert!(chi < 100.0, "{name}, roughness {roughness}: {chi}");
        }
    }
}

#[test]
fn light_and_view_can_change_places() {
    let models = Models::new();
    let color = Vec3::new(0.9, 0.5, 0.1);
    let pairs = |count: u32| {
        (0..count).filter_map(|i| {
            let mut sampler = PixelSampler::new([1, 1], i, 0);
            let [a, b] = [sampler.next_2d(), sampler.next_2d()].map(uniform_sphere);
            let [a, b] = [a, b].map(|d| DVec3::new(d.x, d.y, d.z.abs()));
            (a.z > 0.02 && b.z > 0.02).then_some((a, b))
        })
    };
    for roughness in [0.2, 0.5, 1.0] {
        for bsdf in [
            Bsdf::Diffuse(Diffuse { color }),
            Bsdf::Conductor(Conductor::new(color, roughness)),
            Bsdf::Plastic(Plastic::new(&models.coat, color, roughness)),
            Bsdf::Foam(Foam {
                color,
                translucency: 0.4,
            }),
        ] {
            for (a, b) in pairs(500) {
                let there = bsdf.evaluate(a, b) / b.z as f32;
                let back = bsdf.evaluate(b, a) / a.z as f32;
                let size = there.max(back).max_element().max(1e-6);
                assert!(
                    (there - back).abs().max_element() < 2e-3 * size,
                    "{bsdf:?}: {there} and {back}"
                );
            }
        }
        // Refraction, for basic radiance: n² f(there) cos = n'² f(back) cos, but for the scaling that
        // gives back the light lost.
        let [ior, beyond] = [1.0, 1.333];
        let boundary = Some(&models.water);
        let down = Dielectric::new([ior, beyond], roughness, boundary);
        let up = Dielectric::new([beyond, ior], roughness, boundary);
        for (a, b) in pairs(500) {
            let below = DVec3::new(b.x, b.y, -b.z);
            let there = f64::from(down.evaluate(a, below).x) / (b.z * beyond * beyond);
            let flip = |d: DVec3| DVec3::new(d.x, d.y, -d.z);
            let back = f64::from(up.evaluate(flip(below), flip(a)).x) / (a.z * ior * ior);
            let [there, back] = [there / down.scale(a), back / up.scale(b)];
            if there.max(back) > 1e-6 {
                assert!((there / back - 1.0).abs() < 1e-3, "{there} and {back}");
            }
        }
    }
}

#[test]
fn no_colour_reflects_more_than_it_gets() {
    let models = Models::new();
    let color = Vec3::new(0.8, 0.4, 0.05);
    for roughness in [0.3, 1.0] {
        for bsdf in [
            Bsdf::Conductor(Conductor::new(color, roughness)),
            Bsdf::Plastic(Plastic::new(&models.coat, color, roughness)),
        ] {
            for cosine in [1.0, 0.5] {
                let view = view_at(cosine);
                let mut albedo = Vec3::ZERO;
                over_sphere(300, |light, solid| {
                    albedo += bsdf.evaluate(view, light) * solid as f32;
                });
                assert!(albedo.max_element() < 1.0, "{bsdf:?}: {albedo}");
                assert!(albedo.x > albedo.y && albedo.y > albedo.z);
            }
        }
    }
}

#[test]
fn smooth_boundaries_mirror_and_refract_by_snells_law() {
    let view = view_at(0.6);
    let water = Bsdf::Dielectric(Dielectric::new([1.0, 1.333], 0.0, None));
    let mirrored = water.sample(view, 0.0, [0.3, 0.4]).unwrap();
    assert!((mirrored.light - DVec3::new(-view.x, -view.y, view.z)).length() < 1e-12);
    assert_eq!(mirrored.scattering, Scattering::Reflection);
    let refracted = water.sample(view, 0.999, [0.3, 0.4]).unwrap();
    assert_eq!(refracted.scattering, Scattering::Refraction);
    let sine = |d: DVec3| (d.x * d.x + d.y * d.y).sqrt();
    assert!((sine(refracted.light) * 1.333 - sine(view)).abs() < 1e-12);
    assert!(refracted.light.z < 0.0);
    assert!(refracted.light.cross(view).dot(DVec3::Z).abs() < 1e-12);
    // From below, beyond the critical angle, everything is mirrored.
    let below = Bsdf::Dielectric(Dielectric::new([1.333, 1.0], 0.0, None));
    let total = below.sample(view, 0.999_999, [0.1, 0.9]).unwrap();
    assert_eq!(total.scattering, Scattering::Reflection);
    // A boundary between equals is none.
    let none = Bsdf::Dielectric(Dielectric::new([1.5, 1.5], 0.5, None));
    let straight = none.sample(view, 0.0, [0.1, 0.9]).unwrap();
    assert!((straight.light + view).length() < 1e-9);
    assert!(!water.is_spread());
}
