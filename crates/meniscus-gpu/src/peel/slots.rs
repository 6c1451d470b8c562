//! Rays in slots: tile by tile of the film, so that what a tile's rays may meet is found once.

use super::view::View;
use crate::batch::RayRecord;
use glam::DVec3;
use meniscus::intersect::ClippedRay;
use meniscus::math::aabb::Aabb;
use meniscus::math::ray::{Ray, Side};
use std::collections::HashMap;

/// `LocalRay::flags`.
const STARTS_INSIDE: u32 = 1;
const STARTS_AT_T_MIN: u32 = 2;
const SIDE_IS_PROVEN: u32 = 4;

/// No group.
const NONE: u32 = u32::MAX;

/// A ray with its place on the film.
#[derive(Debug, Clone, Copy)]
pub(super) struct Seen {
    /// Index of the caller's ray.
    pub(super) index: usize,
    /// Film position in pixels.
    film: [f64; 2],
    pub(super) clipped: ClippedRay,
}

/// What the eye's rays have in common.
#[derive(Debug, Clone, Copy)]
pub(super) struct Eye {
    pub(super) view: View,
    pub(super) field_origin: DVec3,
    pub(super) bounds: Aabb,
    /// The side that the eye lies on.
    pub(super) side: Side,
}

impl Eye {
    /// Sorts rays: those of this eye that meet the field's box into `seen`, those that this eye's shaders
    /// cannot answer into `others`.
    pub(super) fn sort(&self, rays: &[Ray], seen: &mut Vec<Seen>, others: &mut Vec<usize>) {
        for (index, ray) in rays.iter().enumerate() {
            if !ray.is_traceable() {
                continue;
            }
            let is_as_known = ray.side == Side::Unknown || ray.side == self.side;
            match self.view.film_position(ray) {
                Some(film) if is_as_known && self.side != Side::Unknown => {
                    let clipped = ClippedRay::new(self.field_origin, self.bounds, ray);
                    seen.extend(clipped.map(|clipped| Seen {
                        index,
                        film,
                        clipped,
                    }));
                }
                _ => others.push(index),
            }
        }
    }

    fn record(&self, seen: &Seen, group: u32) -> RayRecord {
        let clipped = &seen.clipped;
        let mut flags = SIDE_IS_PROVEN;
        if clipped.starts_at_t_min {
            flags |= STARTS_AT_T_MIN;
            if self.side == Side::Inside {
                flags |= STARTS_INSIDE;
            }
        }
        let (origin, origin_low) = two_floats(clipped.origin);
        let (direction, direction_low) = two_floats(clipped.direction);
        // Rounded up.
        let eye_distance = (clipped.t_start * (1.0 + 1e-6)) as f32;
        [
            origin[0],
            origin[1],
            origin[2],
            clipped.length.to_bits(),
            origin_low[0],
            origin_low[1],
            origin_low[2],
            flags,
            direction[0],
            direction[1],
            direction[2],
            eye_distance.to_bits(),
            direction_low[0],
            direction_low[1],
            direction_low[2],
            group,
        ]
    }
}

/// Each component as a sum of two f32, in bits.
pub(super) fn two_floats(v: DVec3) -> ([u32; 3], [u32; 3]) {
    let high = v.as_vec3();
    let low = (v - high.as_dvec3()).as_vec3();
    (
        high.to_array().map(f32::to_bits),
        low.to_array().map(f32::to_bits),
    )
}

/// Rays of one round, as shaders read them.
#[derive(Debug, Default)]
pub(super) struct Slots {
    /// One per slot, group after group.
    pub(super) records: Vec<RayRecord>,
    /// The ray of each slot, into what was laid out; `usize::MAX`: none.
    pub(super) rays: Vec<usize>,
    /// (x, y of the tile in the grid, next group of this tile, –).
    pub(super) groups: Vec<[u32; 4]>,
    /// First group of each tile of the grid.
    pub(super) tiles: Vec<u32>,
    /// Film position of the grid's first tile, in tiles.
    pub(super) grid_at: [i32; 2],
    /// Tiles across and down.
    pub(super) grid_size: [u32; 2],
    /// How far a ray lies from its pixel's centre at most, in pixels.
    pub(super) jitter: f64,
}

impl Slots {
    /// Lays rays out in at most `most` groups of tiles of `side` pixels; what finds no place goes to
    /// `later`.
    pub(super) fn lay_out(
        eye: &Eye,
        seen: &[Seen],
        side: u32,
        most: usize,
        later: &mut Vec<Seen>,
    ) -> Self {
        let area = (side * side) as usize;
        let mut slots = Self::default();
        let mut grid = Grid::NOTHING;
        // The last group of each tile; groups know the one before.
        let mut first: HashMap<[i32; 2], u32> = HashMap::new();
        let mut tile_of: Vec<[i32; 2]> = Vec::new();
        for (number, ray) in seen.iter().enumerate() {
            let pixel = ray.film.map(|p| p.floor() as i32);
            let tile = pixel.map(|p| p.div_euclid(side as i32));
            let [x, y] = pixel.map(|p| p.rem_euclid(side as i32) as usize);
            let within = y * side as usize + x;
            let mut group = first.get(&tile).copied().unwrap_or(NONE);
            while group != NONE && slots.rays[group as usize * area + within] != usize::MAX {
                group = slots.groups[group as usize][2];
            }
            if group == NONE {
                let grown = grid.with(tile);
                if slots.groups.len() == most || grown.cells() > MOST_CELLS {
                    later.push(*ray);
                    continue;
                }
                grid = grown;
                group = slots.groups.len() as u32;
                let next = first.insert(tile, group).unwrap_or(NONE);
                slots.groups.push([0, 0, next, 0]);
                tile_of.push(tile);
                slots.rays.resize(slots.rays.len() + area, usize::MAX);
                slots.records.resize(slots.rays.len(), no_ray(group));
            }
            let slot = group as usize * area + within;
            slots.rays[slot] = number;
            slots.records[slot] = eye.record(ray, group);
            for axis in 0..2 {
                let off = (ray.film[axis] - f64::from(pixel[axis]) - 0.5).abs();
                slots.jitter = slots.jitter.max(off);
            }
        }
        slots.place(grid, &tile_of, &first);
        slots
    }

    fn place(&mut self, grid: Grid, tile_of: &[[i32; 2]], first: &HashMap<[i32; 2], u32>) {
        let within = |tile: &[i32; 2]| [0, 1].map(|axis| (tile[axis] - grid.first[axis]) as u32);
        self.grid_at = grid.first;
        self.grid_size = grid.size();
        self.tiles = vec![NONE; grid.cells() as usize];
        for (group, tile) in self.groups.iter_mut().zip(tile_of) {
            [group[0], group[1]] = within(tile);
        }
        for (tile, &group) in first {
            let [x, y] = within(tile);
            self.tiles[(y * self.grid_size[0] + x) as usize] = group;
        }
    }
}

/// Most tiles that a grid has.
const MOST_CELLS: u64 = 1 << 20;

/// The tiles between two corners.
#[derive(Debug, Clone, Copy)]
struct Grid {
    first: [i32; 2],
    last: [i32; 2],
}

impl Grid {
    const NOTHING: Self = Self {
        first: [i32::MAX; 2],
        last: [i32::MIN; 2],
    };

    fn with(self, tile: [i32; 2]) -> Self {
        Self {
            first: [0, 1].map(|axis| self.first[axis].min(tile[axis])),
            last: [0, 1].map(|axis| self.last[axis].max(tile[axis])),
        }
    }

    fn size(self) -> [u32; 2] {
        [0, 1].map(|axis| {
            (i64::from(self.last[axis]) - i64::from(self.first[axis]) + 1).max(0) as u32
        })
    }

    fn cells(self) -> u64 {
        let [width, height] = self.size();
        u64::from(width) * u64::from(height)
    }
}

/// A slot without a ray.
fn no_ray(group: u32) -> RayRecord {
    let mut record = [0; 16];
    record[3] = (-1.0_f32).to_bits();
    record[15] = group;
    record
}
