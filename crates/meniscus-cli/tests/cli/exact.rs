//! Pixels of the EXR against a float64 program of a few lines that shares no code with Meniscus: the
//! field summed over all particles, the first crossing by dense steps and bisection.

use crate::run::Folder;
use exr::prelude::*;
use std::collections::HashMap;

const SIZE: [usize; 2] = [48, 36];
const SUPPORT: f64 = 0.3;
const THRESHOLD: f64 = 0.35;
const EYE: [f64; 3] = [1.6, 1.2, 2.1];
const TARGET: [f64; 3] = [0.5, 0.45, 0.5];
const FOV: f64 = 35.0;

type V = [f64; 3];

fn add(a: V, b: V, s: f64) -> V {
    [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]]
}

fn dot(a: V, b: V) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: V, b: V) -> V {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

fn unit(a: V) -> V {
    let length = dot(a, a).sqrt();
    a.map(|x| x / length)
}

/// Sixty particles from a small generator of its own.
fn particles() -> Vec<V> {
    let mut state = 12345_u64;
    let mut next = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        // f32, as the file's reader keeps positions no finer than its own text.
        f64::from((state >> 40) as f32 / (1 << 24) as f32)
    };
    (0..60).map(|_| [next(), next(), next()]).collect()
}

/// F − T with the quartic kernel and unit weights.
fn field(particles: &[V], x: V) -> f64 {
    let term = |p: &V| {
        let d = add(x, *p, -1.0);
        let g = (1.0 - dot(d, d) / (SUPPORT * SUPPORT)).max(0.0);
        g * g
    };
    particles.iter().map(term).sum::<f64>() - THRESHOLD
}

/// Where the ray first enters, and the largest F − T that it saw where it never does.
fn first_crossing(particles: &[V], origin: V, direction: V) -> std::result::Result<f64, f64> {
    let value = |t: f64| field(particles, add(origin, direction, t));
    let (step, end) = (5e-4, 4.5);
    let mut largest = f64::MIN;
    let mut t = 0.0;
    while t < end {
        let here = value(t + step);
        largest = largest.max(here);
        if here >= 0.0 {
            let (mut outside, mut inside) = (t, t + step);
            for _ in 0..60 {
                let middle = 0.5 * (outside + inside);
                if value(middle) >= 0.0 {
                    inside = middle;
                } else {
                    outside = middle;
                }
            }
            return Ok(inside);
        }
        t += step;
    }
    Err(largest)
}

#[test]
fn position_and_coverage_are_those_of_an_independent_program() {
    let folder = Folder::new();
    let particles = particles();
    let rows: String = particles
        .iter()
        .map(|p| format!("{:?},{:?},{:?}\n", p[0], p[1], p[2]))
        .collect();
    folder.write("p.csv", format!("x,y,z\n{rows}"));
    let list = |v: V| format!("{},{},{}", v[0], v[1], v[2]);
    folder.done(&format!(
        "render p.csv -o p.exr --size {}x{} --support {SUPPORT} -t {THRESHOLD} --kernel quartic \
         --weights unit --camera-eye {} --camera-target {} --fov {FOV} --spp 1 --aov all",
        SIZE[0],
        SIZE[1],
        list(EYE),
        list(TARGET)
    ));
    let image = read_first_flat_layer_from_file(folder.path("p.exr")).unwrap();
    let channels: HashMap<String, Vec<f32>> = image
        .layer_data
        .channel_data
        .list
        .iter()
        .map(|c| (c.name.to_string(), c.sample_data.values_as_f32().collect()))
        .collect();

    let forward = unit(add(TARGET, EYE, -1.0));
    let right = unit(cross(forward, [0.0, 1.0, 0.0]));
    let up = cross(right, forward);
    let tan = (FOV.to_radians() / 2.0).tan();
    let (mut hits, mut misses) = (0, 0);
    for y in 0..SIZE[1] {
        for x in 0..SIZE[0] {
            let pixel = y * SIZE[0] + x;
            let across = (x as f64 + 0.5) / SIZE[0] as f64 * 2.0 - 1.0;
            let down = (y as f64 + 0.5) / SIZE[1] as f64 * 2.0 - 1.0;
            let aspect = SIZE[0] as f64 / SIZE[1] as f64;
            let ray = add(forward, right, across * tan * aspect);
            let ray = unit(add(ray, up, -down * tan));
            let alpha = channels["A"][pixel];
            let position = ["P.X", "P.Y", "P.Z"].map(|name| f64::from(channels[name][pixel]));
            match first_crossing(&particles, EYE, ray) {
                Ok(t) => {
                    hits += 1;
                    assert_eq!(alpha, 1.0, "pixel {x}, {y}");
                    let off = add(position, add(EYE, ray, t), -1.0);
                    assert!(dot(off, off).sqrt() < 1e-5, "pixel {x}, {y}: {off:?}");
                    let depth = t * dot(ray, forward);
                    let z = f64::from(channels["Z"][pixel]);
                    assert!(
                        (z - depth).abs() < 1e-5,
                        "pixel {x}, {y}: Z {z} for {depth}"
                    );
                }
                // A touch narrower than a step is not decided here.
                Err(largest) if largest > -1e-4 => {}
                Err(_) => {
                    misses += 1;
                    assert_eq!(alpha, 0.0, "pixel {x}, {y}");
                    assert_eq!(position, [0.0; 3], "pixel {x}, {y}");
                    assert_eq!(channels["Z"][pixel], f32::INFINITY, "pixel {x}, {y}");
                }
            }
        }
    }
    assert!(hits > 1000 && misses > 200, "{hits} hits, {misses} misses");
}
