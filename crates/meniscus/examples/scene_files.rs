//! Writes what the scenes in `scenes/` need beside particles: a tank, a ring and a sky.
//!
//! ```text
//! cargo run -p meniscus --example scene_files -- scenes
//! ```

use image::Rgb;
use image::codecs::hdr::HdrEncoder;
use std::f64::consts::TAU;
use std::fmt::Write;
use std::path::PathBuf;

fn main() -> std::io::Result<()> {
    let folder = PathBuf::from(std::env::args().nth(1).unwrap_or_else(|| ".".to_owned()));
    std::fs::write(folder.join("tank.obj"), tank(0.03, 0.012, 0.5))?;
    std::fs::write(folder.join("ring.obj"), ring(1.0, 0.12, [64, 16]))?;
    let file = std::fs::File::create(folder.join("sky.hdr"))?;
    HdrEncoder::new(file)
        .encode(&sky(SKY_SIZE), SKY_SIZE[0], SKY_SIZE[1])
        .map_err(std::io::Error::other)
}

/// Texels of the sky image.
const SKY_SIZE: [usize; 2] = [256, 128];

/// A clear evening by formula, y up: blue above, warm towards the low sun, gray below. The sun is a soft
/// disk of 4 degrees, which these texels can show.
fn sky([width, height]: [usize; 2]) -> Vec<Rgb<f32>> {
    let sun = direction(0.62, 0.19);
    let mix = |a: [f32; 3], b: [f32; 3], t: f32| -> [f32; 3] {
        std::array::from_fn(|c| a[c] + (b[c] - a[c]) * t)
    };
    let texels = (0..height).flat_map(|row| (0..width).map(move |column| (column, row)));
    let color = |(column, row): (usize, usize)| {
        let across = (column as f64 + 0.5) / width as f64;
        let down = (row as f64 + 0.5) / height as f64;
        let towards = direction(across, 0.5 - down);
        let up = towards[1] as f32;
        let cosine: f64 = (0..3).map(|axis| towards[axis] * sun[axis]).sum();
        let away = cosine.clamp(-1.0, 1.0).acos().to_degrees();
        let sky = mix([0.85, 0.80, 0.74], [0.16, 0.30, 0.62], up.max(0.0).sqrt());
        let sky = mix(sky, [0.30, 0.28, 0.26], (-8.0 * up).clamp(0.0, 1.0));
        let glow = 1.2 * (-away / 14.0).exp() as f32;
        let disk = 420.0 * (1.0 - ((away - 1.6) / 0.8).clamp(0.0, 1.0)) as f32;
        Rgb(std::array::from_fn(|c| {
            sky[c] + (glow + disk) * [1.0, 0.86, 0.66][c]
        }))
    };
    texels.map(color).collect()
}

/// Unit vector at `across` of a turn and `up` of half a turn over the horizon.
fn direction(across: f64, up: f64) -> [f64; 3] {
    let (sin, cos) = (TAU * across).sin_cos();
    let (height, reach) = (0.5 * TAU * up).sin_cos();
    [reach * cos, height, reach * sin]
}

/// An open-topped tank around the unit square: one closed solid, z up. Its walls reach `lap` into the
/// square, so that there is no gap between them and what fills it.
fn tank(wall: f64, lap: f64, height: f64) -> String {
    let mut text = "# a tank around the unit square, z up; one closed solid\n".to_owned();
    // Rings of corners from the middle of the outer bottom up, over the rim and down to the inner one.
    let rings = [(-wall, -wall), (-wall, height), (lap, height), (lap, lap)];
    for (inset, z) in rings {
        let (low, high) = (inset, 1.0 - inset);
        for (x, y) in [(low, low), (high, low), (high, high), (low, high)] {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "v {x} {y} {z}");
        }
    }
    let mut face = |corners: [usize; 4]| {
        let [a, b, c, d] = corners.map(|corner| corner + 1);
        let _ = writeln!(text, "f {a} {b} {c} {d}");
    };
    face([3, 2, 1, 0]);
    for ring in 0..3 {
        for side in 0..4 {
            let next = (side + 1) % 4;
            let (below, above) = (4 * ring, 4 * (ring + 1));
            face([below + side, below + next, above + next, above + side]);
        }
    }
    face([12, 13, 14, 15]);
    text
}

/// A torus about the z axis with smooth normals.
fn ring(radius: f64, thickness: f64, [around, across]: [usize; 2]) -> String {
    let mut text = "# a ring about z\n".to_owned();
    for i in 0..around {
        let (sin, cos) = (TAU * i as f64 / around as f64).sin_cos();
        for j in 0..across {
            let (up, out) = (TAU * j as f64 / across as f64).sin_cos();
            let reach = radius + thickness * out;
            let (x, y, z) = (cos * reach, sin * reach, thickness * up);
            let (nx, ny) = (cos * out, sin * out);
            let _ = writeln!(text, "v {x:.6} {y:.6} {z:.6}\nvn {nx:.5} {ny:.5} {up:.5}");
        }
    }
    for i in 0..around {
        for j in 0..across {
            let at = |i: usize, j: usize| (i % around) * across + j % across + 1;
            let corners = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            let [a, b, c, d] = corners;
            let _ = writeln!(text, "f {a}//{a} {b}//{b} {c}//{c} {d}//{d}");
        }
    }
    text
}
