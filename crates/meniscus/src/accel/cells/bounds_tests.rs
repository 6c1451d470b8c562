//! Bounds over moving cells against the field itself, at random places and times.

use super::filter::{FieldBounds, filter, is_settled};
use super::layout::Columns;
use super::list::BlobList;
use super::place::Place;
use crate::field::{BlobField, Motion, Search, Span};
use crate::kernel::{Kernel, KernelShape, Sextic, Wyvill};
use crate::math::aabb::Aabb;
use crate::math::sampling::PixelSampler;
use crate::math::simd::Level;
use crate::primitive::{Ball, Ellipsoid, Primitive, Shapes};
use fearless_simd::dispatch;
use glam::{DMat3, DVec3, Vec3};

const BLOBS: usize = 40;
const RADIUS: f32 = 0.3;
const PLACES: u32 = 60;
const POINTS: usize = 40;

/// Numbers from −1 to 1.
struct Random(PixelSampler);

impl Random {
    fn new(seed: u32) -> Self {
        Self(PixelSampler::new([seed, 5], 0, 3))
    }

    fn number(&mut self) -> f32 {
        2.0 * self.0.next_1d() as f32 - 1.0
    }

    fn vector(&mut self, size: f32) -> Vec3 {
        Vec3::from_array([(); 3].map(|()| self.number())) * size
    }
}

/// Blobs in a cube about the origin that move up to `way` in each direction, some of negative weight.
fn field(kernel: Kernel, way: f32, ellipsoids: bool, accelerated: bool) -> BlobField {
    let mut random = Random::new(1);
    let mut vectors = |size: f32| -> Vec<[f32; 3]> {
        let vector = |_| random.vector(size).to_array();
        (0..BLOBS).map(vector).collect()
    };
    // Of those that accelerate, that is most of their way.
    let (speed, bend) = if accelerated {
        (0.1 * way, way)
    } else {
        (way, 0.0)
    };
    let (centers, velocities, half_accelerations) = (vectors(0.5), vectors(speed), vectors(bend));
    let factor = |i: usize| {
        let radii = DVec3::new(0.5, 1.0, 1.5) * f64::from(RADIUS);
        let axes = DMat3::from_rotation_y(i as f64) * DMat3::from_diagonal(radii);
        let inverse = axes.inverse();
        Ellipsoid::from_metric(inverse.transpose() * inverse).expect("three axes")
    };
    BlobField {
        kernel,
        threshold: 0.3,
        origin: DVec3::ZERO,
        centers,
        shapes: match ellipsoids {
            false => Shapes::Balls(vec![RADIUS; BLOBS]),
            true => Shapes::Ellipsoids((0..BLOBS).map(factor).collect()),
        },
        weights: (0..BLOBS)
            .map(|i| if i % 5 == 0 { -0.5 } else { 1.0 })
            .collect(),
        rows: (0..BLOBS as u32).collect(),
        motion: Some(Motion {
            velocities,
            half_accelerations,
            velocity_gradients: Vec::new(),
            shutter: [-0.6, 1.4],
        }),
        attributes: Vec::new(),
        spacing: 0.2,
        search: Search::default(),
    }
}

/// A box that drifts and changes its size.
fn place(random: &mut Random, way: f32) -> Place {
    let center = random.vector(0.5);
    let size = 0.03 * RADIUS * 10_f32.powf(random.number());
    let drift = random.vector(0.1 * way);
    let end = |sign: f32, random: &mut Random| {
        let half = (random.vector(0.5) + 1.0) * size;
        let center = center + drift * sign;
        Aabb {
            min: center - half,
            max: center + half,
        }
    };
    Place {
        ends: [end(-1.0, random), end(1.0, random)],
    }
}

/// Bounds of all kinds over `place`, for all time. Blobs that reach it are the same whether the bounds
/// settle anything or not.
fn all_bounds<K: KernelShape, P: Primitive>(list: &BlobList, place: &Place) -> [FieldBounds; 3] {
    let mut found = [FieldBounds::NONE; 3];
    let [tight, close, loose] = &mut found;
    let mut kept = [(); 3].map(|()| BlobList::default());
    let [settled, settled_loosely, open] = &mut kept;
    let keep = |found: &mut FieldBounds, bounds: FieldBounds| {
        *found = bounds;
        true
    };
    let level = Level::new();
    dispatch!(level, simd => {
        is_settled::<_, K, P>(simd, list, place, |bounds| keep(tight, bounds));
        filter::<_, K, P>(simd, list, place, true, settled, |bounds| keep(close, bounds));
        filter::<_, K, P>(simd, list, place, false, settled_loosely, |bounds| keep(loose, bounds));
        filter::<_, K, P>(simd, list, place, true, open, |_| false);
    });
    let [first, others @ ..] = kept.map(|list| list.indices[..list.count].to_vec());
    assert!(others.iter().all(|other| *other == first));
    found
}

/// Returns how often bounds of second order were the tighter ones.
fn check<K: KernelShape, P: Primitive>(field: &BlobField, span: Span, way: f32) -> usize {
    let stored = Columns::of::<P>(field, &field.bounds());
    let all: Vec<u32> = (0..BLOBS as u32).collect();
    let mut tighter = 0;
    for seed in 0..PLACES {
        let mut random = Random::new(100 + seed);
        let place = place(&mut random, way);
        let mut list = BlobList::default();
        list.fill::<P>(field, span, stored, &all);
        list.pieces = if seed % 2 == 0 { 1 } else { 4 };
        let bounds = all_bounds::<K, P>(&list, &place);
        tighter += usize::from(bounds[0].upper < bounds[2].upper);
        for _ in 0..POINTS {
            // The corners of the box and the ends of the time are where bounds are closest.
            let [phase, x, y, z] = [(); 4].map(|()| (1.3 * random.number()).clamp(-1.0, 1.0));
            let [open, close] = place.ends;
            let part = 0.5 + 0.5 * phase;
            let (min, max) = (
                open.min.lerp(close.min, part),
                open.max.lerp(close.max, part),
            );
            let at = min + (max - min) * (0.5 + 0.5 * Vec3::new(x, y, z));
            let secs = span.middle_secs + f64::from(phase) * span.half_secs;
            let value = field.at(secs).value(at.as_dvec3()) as f32;
            for bounds in bounds {
                assert!(
                    bounds.lower - 1e-4 <= value && value <= bounds.upper + 1e-4,
                    "place {seed}, way {way}, phase {phase}: {value} is not in {bounds:?}"
                );
            }
        }
    }
    tighter
}

#[test]
fn bounds_hold_the_field_at_all_times() {
    let mut tighter = 0;
    for way in [0.003, 0.03, 0.3] {
        for accelerated in [false, true] {
            for part in 0..3 {
                let balls = field(Kernel::Sextic, way, false, accelerated);
                let ellipsoids = field(Kernel::Wyvill, way, true, accelerated);
                let motion = balls.motion.as_ref().expect("it moves");
                let whole = motion.whole();
                let span = match part {
                    0 => whole,
                    part => whole.parts(2).nth(part - 1).expect("two parts"),
                };
                tighter += check::<Sextic, Ball>(&balls, span, way);
                tighter += check::<Wyvill, Ellipsoid>(&ellipsoids, span, way);
            }
        }
    }
    assert!(
        tighter > 200,
        "{tighter} bounds of second order were of use"
    );
}
