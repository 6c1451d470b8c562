//! A protein-like molecule: α-helices packed side by side into a ball, in ångström
//! (the size of the "Molecule" scene of Gourmel et al. 2010).

use super::Generated;
use super::random::Random;
use super::staging::Staging;
use crate::kernel::Kernel;
use crate::math::aabb::DAabb;
use crate::particles::{Column, Particles};
use crate::scene::{BlobSettings, Weights};
use glam::DVec3;
use std::f64::consts::PI;

/// An element with its van der Waals radius (Bondi 1964).
#[derive(Clone, Copy)]
struct Element {
    number: u8,
    radius: f32,
}

const CARBON: Element = Element {
    number: 6,
    radius: 1.7,
};
const NITROGEN: Element = Element {
    number: 7,
    radius: 1.55,
};
const OXYGEN: Element = Element {
    number: 8,
    radius: 1.52,
};
const SULFUR: Element = Element {
    number: 16,
    radius: 1.8,
};

/// Rise of the helix from residue to residue.
const RISE: f64 = 1.5;
/// Turn from residue to residue, in degrees.
const TURN_DEGREES: f64 = 100.0;
/// Distance of neighbouring helix axes.
const HELIX_DISTANCE: f64 = 10.0;
/// Volume of an atom in the packing, measured on the packing itself.
const ATOM_VOLUME: f64 = 17.0;

/// Atoms of the backbone and Cβ in cylindrical coordinates (radius, angle in degrees, height) of the
/// helix: the standard bond lengths and angles solved for the rise and turn above.
const BACKBONE: [(Element, f64, f64, f64); 5] = [
    (NITROGEN, 1.583, -27.309, -0.908),
    (CARBON, 2.287, 0.0, 0.0),
    (CARBON, 1.671, 27.558, 1.039),
    (OXYGEN, 1.906, 21.628, 2.233),
    BETA_CARBON,
];
const BETA_CARBON: (Element, f64, f64, f64) = (CARBON, 3.33, 16.633, -0.783);

struct Atom {
    position: DVec3,
    element: Element,
    residue: u32,
}

/// A helix around `axis` through `center`, from −`half_length` to +`half_length` along it.
fn add_helix(
    atoms: &mut Vec<Atom>,
    residue: &mut u32,
    center: DVec3,
    axis: DVec3,
    half_length: f64,
    random: &mut Random,
) {
    let (u, v) = axis.any_orthonormal_pair();
    let phase = random.range(0.0, 360.0);
    let place = |radius: f64, degrees: f64, height: f64| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        center + u * (radius * cos) + v * (radius * sin) + axis * height
    };
    for k in 0..(2.0 * half_length / RISE) as usize {
        let turn = phase + TURN_DEGREES * k as f64;
        let height = RISE * k as f64 - half_length;
        *residue += 1;
        for (element, radius, degrees, rise) in BACKBONE {
            atoms.push(Atom {
                position: place(radius, turn + degrees, height + rise),
                element,
                residue: *residue,
            });
        }
        // The side chain zigzags outward from Cβ and ends in whatever it is.
        let (_, mut radius, mut degrees, mut rise) = BETA_CARBON;
        let length = random.below(4);
        let end = [CARBON, NITROGEN, OXYGEN, SULFUR][random.below(4)];
        let lean = random.range(-1.0, 1.0);
        for step in 0..length {
            let zigzag = if step % 2 == 0 { 1.0 } else { -1.0 };
            radius += 0.95;
            degrees += (lean * 0.6 + zigzag * 0.7) / radius * 180.0 / PI;
            rise -= 0.55 * lean * zigzag + 0.35;
            atoms.push(Atom {
                position: place(radius, turn + degrees, height + rise),
                element: if step + 1 == length { end } else { CARBON },
                residue: *residue,
            });
        }
    }
}

/// Helices side by side that fill a ball of `ball_radius`.
fn bundle(ball_radius: f64, seed: u64) -> Vec<Atom> {
    let mut random = Random::new(seed);
    let mut atoms = Vec::new();
    let mut residue = 0;
    let across = (ball_radius / HELIX_DISTANCE).ceil() as i32 + 1;
    for row in -across..=across {
        for place in -across..=across {
            let x = HELIX_DISTANCE * (f64::from(place) + 0.5 * f64::from(row.rem_euclid(2)));
            let z = HELIX_DISTANCE * 0.75f64.sqrt() * f64::from(row);
            let rest = ball_radius * ball_radius - x * x - z * z;
            if rest <= (2.0 * RISE) * (2.0 * RISE) {
                continue;
            }
            // Neighbours cross at a small angle, as they do in real bundles, and run up and down.
            let tilt = DVec3::new(-z, 0.0, x) * (0.30 / ball_radius);
            let sense = if (place + row) % 2 == 0 { 1.0 } else { -1.0 };
            let axis = (DVec3::Y + tilt + random.in_ball() * 0.05).normalize() * sense;
            let center = DVec3::new(x, 0.0, z) + random.in_ball() * 0.4;
            add_helix(
                &mut atoms,
                &mut residue,
                center,
                axis,
                rest.sqrt(),
                &mut random,
            );
        }
    }
    atoms
}

/// `count` atoms with `radius`, `element` (atomic number) and `residue`.
pub(super) fn generate(count: usize, seed: u64) -> Generated {
    let mut ball_radius = (count as f64 * ATOM_VOLUME * 0.75 / PI).cbrt().max(4.0);
    let mut atoms = bundle(ball_radius, seed);
    while atoms.len() < count {
        ball_radius *= 1.02;
        atoms = bundle(ball_radius, seed);
    }
    // Trim the outermost residues, so that the count is exact.
    let mut residue_distance = vec![f64::INFINITY; atoms.len() + 1];
    for atom in &atoms {
        let distance = &mut residue_distance[atom.residue as usize];
        *distance = distance.min(atom.position.length_squared());
    }
    let mut order: Vec<usize> = (0..atoms.len()).collect();
    order.sort_by(|&a, &b| {
        let distance = |i: usize| residue_distance[atoms[i].residue as usize];
        distance(a).total_cmp(&distance(b)).then(a.cmp(&b))
    });
    order.truncate(count);
    order.sort_unstable();
    let kept: Vec<&Atom> = order.iter().map(|&i| &atoms[i]).collect();

    let bounds = kept.iter().fold(DAabb::EMPTY, |bounds, atom| {
        let margin = DVec3::splat(f64::from(atom.element.radius));
        bounds
            .including(atom.position - margin)
            .including(atom.position + margin)
    });
    let mut particles = Particles::from_positions(kept.iter().map(|atom| atom.position).collect());
    let radii: Vec<f32> = kept.iter().map(|atom| atom.element.radius).collect();
    let numbers: Vec<u8> = kept.iter().map(|atom| atom.element.number).collect();
    let residues: Vec<u32> = kept.iter().map(|atom| atom.residue).collect();
    particles.columns = vec![
        Column::new("radius", 1, radii),
        Column::new("element", 1, numbers),
        Column::new("residue", 1, residues),
    ];
    let blobs = BlobSettings {
        kernel: Kernel::Quartic,
        threshold: 0.2,
        weights: Weights::Unit,
        ..BlobSettings::default()
    };
    let scene = Staging {
        blobs,
        bounds,
        towards_eye: DVec3::new(0.55, 0.35, 1.0),
        up: DVec3::Y,
        light: DVec3::new(0.45, 0.75, 0.55),
        preset: "molecule",
        ground: false,
    }
    .scene();
    Generated { particles, scene }
}
