//! Particles: positions and named columns, as files and simulations give them.

pub mod attribute;
pub mod between;
pub mod column;
pub mod elements;
pub mod filter;
pub mod io;
pub mod neighbours;
pub mod roles;
pub mod sequence;
pub mod several;
pub mod spacing;
pub mod trajectory;

pub use attribute::{Attribute, MissingColumn};
pub use column::{Column, ColumnData};
pub use roles::Role;
pub use several::Several;

use glam::DVec3;

/// A set of particles in structure-of-arrays form.
///
/// Positions stay in f64 in the file's own unit and coordinates. Every other property is a
/// [`Column`] under the name that the file gives it; [`Particles::role`] finds the columns that have
/// a meaning for us (radius, velocity, …) under their usual names.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Particles {
    /// Centres, in the file's unit.
    pub positions: Vec<DVec3>,
    /// All other properties, in file order; each has one row per position.
    pub columns: Vec<Column>,
    /// For each particle its 0-based row in the file, before anything was dropped or filtered.
    pub rows: Vec<u32>,
}

impl Particles {
    /// Particles with these centres and no other property; rows count from 0.
    pub fn from_positions(positions: Vec<DVec3>) -> Self {
        let rows = (0..positions.len() as u32).collect();
        Self {
            positions,
            columns: Vec::new(),
            rows,
        }
    }

    /// Number of particles.
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// Whether there is no particle.
    pub fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    /// The column of exactly that name.
    pub fn column(&self, name: &str) -> Option<&Column> {
        self.columns.iter().find(|column| column.name == name)
    }

    /// Keeps the particles for which `keep(index)` is true, in order, with their columns and rows.
    pub fn retain(&mut self, keep: impl Fn(usize) -> bool) {
        let kept: Vec<usize> = (0..self.len()).filter(|&i| keep(i)).collect();
        if kept.len() == self.len() {
            return;
        }
        self.positions = kept.iter().map(|&i| self.positions[i]).collect();
        self.rows = kept.iter().map(|&i| self.rows[i]).collect();
        for column in &mut self.columns {
            column.select(&kept);
        }
    }

    /// Drops particles whose position is NaN or infinite; says how many there were.
    pub fn drop_non_finite(&mut self) -> usize {
        let before = self.len();
        let finite: Vec<bool> = self.positions.iter().map(|p| p.is_finite()).collect();
        self.retain(|i| finite[i]);
        before - self.len()
    }
}
