//! Balls in a device's buffers, and what shaders know of them.

use super::Clipping;
use super::field::PeelOptions;
use super::room::{Own, Room, stored};
use super::shader::{PeelKind, tile};
use super::slots::{Eye, Slots, two_floats};
use crate::device::Device;
use crate::error::GpuError;
use glam::DVec3;
use meniscus::frame::Blobs;
use meniscus::intersect::Tolerances;
use meniscus::intersect::particles::LONGEST_STRETCH;
use meniscus::math::aabb::Aabb;
use meniscus::scene::PeelVariant;

/// Balls that a stretch of a ray may meet.
const MET_CAPACITY: u32 = 96;
/// Balls that a pixel's list has room for.
const LIST_CAPACITY: u32 = 64;
/// The same in the paper (§4.2).
const PAPER_CAPACITY: u32 = 14;

/// Balls are too small for f32 below this part of a stretch, or this many times what rounding moves them.
const FINEST_PART: f32 = 1.0 / 64.0;
const MARGIN_PARTS: f32 = 8.0;

/// Depths reach this much farther than the longest ray: 1 stands for nothing.
const REACH_MARGIN: f32 = 1.01;

/// Balls in buffers, and what their rays are asked with.
pub(super) struct Balls {
    pub(super) shapes: wgpu::Buffer,
    pub(super) traits: wgpu::Buffer,
    pub(super) count: u32,
    pub(super) bounds: Aabb,
    pub(super) kind: PeelKind,
    /// Threshold, tolerance, rounding, distance of the start, length of a stretch.
    lengths: [f32; 5],
    fine_beta: f32,
    /// Whether a ball alone is solid where it reaches the threshold.
    pub(super) has_kernel_spheres: bool,
}

impl Balls {
    pub(super) fn upload(
        device: &Device,
        blobs: &Blobs,
        radii: &[f32],
        clipping: Clipping,
    ) -> Result<Self, GpuError> {
        let field = &blobs.field;
        let shapes: Vec<[f32; 4]> = (field.centers.iter().zip(radii))
            .map(|(&[x, y, z], radius)| [x, y, z, radius.recip()])
            .collect();
        let threshold = f64::from(field.threshold);
        let traits: Vec<[f32; 2]> = field
            .weights
            .iter()
            .map(|&weight| {
                let q = field.kernel.q_at(threshold / f64::from(weight));
                [weight, q.map_or(2.0, |q| (1.0 - q) as f32)]
            })
            .collect();
        let limits = &device.limits;
        let largest = limits
            .max_storage_buffer_binding_size
            .min(limits.max_buffer_size);
        let bytes = size_of_val(&shapes[..]) as u64;
        if bytes > largest {
            let message = format!("it binds {largest} bytes at most");
            return Err(device.too_large(bytes, message));
        }
        let bounds = field.bounds();
        let tolerances = Tolerances::of(blobs, bounds);
        let mut sorted = radii.to_vec();
        let (_, &mut median, _) = sorted.select_nth_unstable_by(radii.len() / 2, f32::total_cmp);
        let longest = LONGEST_STRETCH * median;
        let finest = (FINEST_PART * longest).max(MARGIN_PARTS * tolerances.rounding);
        Ok(Self {
            shapes: stored(device, bytemuck::cast_slice(&shapes))?,
            traits: stored(device, bytemuck::cast_slice(&traits))?,
            count: shapes.len() as u32,
            bounds,
            kind: PeelKind {
                kernel: field.kernel,
                variant: blobs.settings.peel,
                clipping,
            },
            lengths: [
                field.threshold,
                tolerances.crossing,
                tolerances.rounding,
                tolerances.near_start,
                longest,
            ],
            fine_beta: (finest * finest).recip(),
            has_kernel_spheres: !field.has_negative_weights(),
        })
    }

    pub(super) fn capacity(&self, options: PeelOptions) -> u32 {
        let usual = match (self.kind.variant, self.kind.clipping) {
            (PeelVariant::Tiles, _) => MET_CAPACITY,
            (PeelVariant::Sprites, Clipping::Own) => LIST_CAPACITY,
            (PeelVariant::Sprites, Clipping::Kanamori) => PAPER_CAPACITY,
        };
        options.capacity.unwrap_or(usual)
    }

    /// What shaders know of a round (`Params` in `shaders/peel/field.wgsl`).
    pub(super) fn params(&self, eye: &Eye, slots: &Slots, room: &Room) -> [u32; 40] {
        let side = f64::from(tile(self.kind.variant));
        // Film positions from the middle of the grid, where f32 is finest.
        let first = slots.grid_at.map(|at| f64::from(at) * side);
        let middle = [0, 1].map(|axis| first[axis] + 0.5 * side * f64::from(slots.grid_size[axis]));
        let map = eye.view.film_from_direction;
        let depth = map.row(2);
        let per_depth = depth.length().recip();
        let row = |axis: usize| (map.row(axis) - depth * middle[axis]) * per_depth;
        let (eye_high, eye_low) = two_floats(eye.view.eye - eye.field_origin);
        let reach = REACH_MARGIN * self.bounds.size().length();
        let (across, atlas) = match &room.own {
            Own::Tiles { .. } => (1, 1),
            Own::Sprites(layers) => (layers.across, layers.side),
        };
        let mut params = [0; 40];
        params[..5].copy_from_slice(&self.lengths.map(f32::to_bits));
        params[5..12].copy_from_slice(&[
            slots.records.len() as u32,
            slots.groups.len() as u32,
            room.kind.capacity,
            self.count,
            room.most_pairs,
            self.fine_beta.to_bits(),
            reach.to_bits(),
        ]);
        let bits = |v: DVec3| v.as_vec3().to_array().map(f32::to_bits);
        params[12..15].copy_from_slice(&bits(row(0)));
        params[16..19].copy_from_slice(&bits(row(1)));
        params[20..23].copy_from_slice(&bits(depth * per_depth));
        params[24..27].copy_from_slice(&eye_high);
        params[28..31].copy_from_slice(&eye_low);
        let at = [0, 1].map(|axis| ((first[axis] - middle[axis]) as f32).to_bits());
        params[32..34].copy_from_slice(&at);
        params[34..36].copy_from_slice(&slots.grid_size);
        params[36] = (slots.jitter as f32).to_bits();
        params[37] = across;
        params[38..40].copy_from_slice(&[atlas; 2]);
        params
    }
}
