//! Atoms as molecule files give them, gathered into particles.

use super::bytes::assemble;
use super::{ParseError, Parsed};
use crate::particles::elements::{UNKNOWN_RADIUS, van_der_waals_radius};
use crate::particles::{Column, Particles};
use glam::DVec3;
use std::collections::HashMap;

/// One atom of a file.
#[derive(Debug, Clone, Default)]
pub(super) struct Atom<'a> {
    pub(super) position: DVec3,
    pub(super) name: &'a [u8],
    pub(super) chain: &'a [u8],
    pub(super) residue: i32,
    /// Insertion code: part of the residue's number.
    pub(super) insertion: &'a [u8],
    pub(super) serial: i32,
    /// `None` for a site without an atom.
    pub(super) atomic_number: Option<u8>,
    pub(super) hetero: bool,
    /// Identifier of an alternate location; empty where there is one location only.
    pub(super) alternate: &'a [u8],
    pub(super) occupancy: Option<f32>,
    pub(super) b_factor: Option<f32>,
    pub(super) charge: Option<i8>,
    pub(super) velocity: Option<[f32; 3]>,
}

/// Chain, residue, insertion code and name: atoms that share them are alternate locations of one.
type Identity = (u32, i32, Box<[u8]>, Box<[u8]>);

/// Anisotropic displacements in Å²: U₁₁ U₂₂ U₃₃ U₁₂ U₁₃ U₂₃.
pub(super) type Displacements = [f32; 6];

/// An isotropic B over the U that says the same: 8π² (IUCr, Acta Cryst. A52, 770, 1996).
pub(super) const B_OVER_U: f64 = 8.0 * std::f64::consts::PI * std::f64::consts::PI;

/// The atoms of one frame, columns first.
#[derive(Debug, Default)]
pub(super) struct Atoms {
    positions: Vec<DVec3>,
    rows: Vec<u32>,
    atomic_numbers: Vec<u8>,
    serials: Vec<i32>,
    residues: Vec<i32>,
    chains: Vec<u32>,
    hetero: Vec<u8>,
    occupancies: Vec<f32>,
    b_factors: Vec<f32>,
    charges: Vec<i8>,
    velocities: Vec<f32>,
    displacements: Vec<Option<Displacements>>,
    has_occupancy: bool,
    has_b_factor: bool,
    has_charge: bool,
    has_velocity: bool,
    chain_numbers: HashMap<Box<[u8]>, u32>,
    last_chain: Option<(Box<[u8]>, u32)>,
    alternates: HashMap<Identity, usize>,
    /// Atoms in the file so far, those left out included.
    seen: u32,
    replaced: usize,
    without_atom: usize,
}

impl Atoms {
    /// Takes an atom and gives its place, unless it is left out. Of alternate locations with a stated occupancy the one with the highest stays,
    /// the first among equals.
    pub(super) fn push(&mut self, atom: &Atom<'_>) -> Option<usize> {
        let row = self.seen;
        self.seen = self.seen.saturating_add(1);
        let Some(atomic_number) = atom.atomic_number else {
            self.without_atom += 1;
            return None;
        };
        let chain = self.chain_number(atom.chain);
        let occupancy = atom.occupancy.unwrap_or(1.0);
        if !atom.alternate.is_empty() && atom.occupancy.is_some() {
            let identity = (chain, atom.residue, atom.insertion.into(), atom.name.into());
            let here = self.positions.len();
            let first = *self.alternates.entry(identity).or_insert(here);
            if first != here {
                self.replaced += 1;
                if occupancy <= self.occupancies[first] {
                    return None;
                }
                self.set(first, row, atom, atomic_number, chain);
                return Some(first);
            }
        }
        let here = self.positions.len();
        self.positions.push(DVec3::ZERO);
        self.rows.push(0);
        self.atomic_numbers.push(0);
        self.serials.push(0);
        self.residues.push(0);
        self.chains.push(0);
        self.hetero.push(0);
        self.occupancies.push(0.0);
        self.b_factors.push(0.0);
        self.charges.push(0);
        self.velocities.extend([0.0; 3]);
        self.displacements.push(None);
        self.set(here, row, atom, atomic_number, chain);
        Some(here)
    }

    /// Gives the atom at a place that [`Atoms::push`] gave its displacements.
    pub(super) fn displace(&mut self, at: usize, displacements: Displacements) {
        if let Some(known) = self.displacements.get_mut(at) {
            *known = Some(displacements);
        }
    }

    /// Gives atoms their displacements by their serial numbers.
    pub(super) fn displace_by_serial(&mut self, displacements: &HashMap<i32, Displacements>) {
        for (known, serial) in self.displacements.iter_mut().zip(&self.serials) {
            *known = displacements.get(serial).copied().or(*known);
        }
    }

    /// Displacements of all atoms, those of the others from their isotropic B; `None` where no atom has
    /// any.
    fn all_displacements(&self) -> Option<Vec<f32>> {
        self.displacements.iter().any(Option::is_some).then(|| {
            let each = self.displacements.iter().zip(&self.b_factors);
            each.flat_map(|(known, &b)| {
                let u = (f64::from(b) / B_OVER_U) as f32;
                known.unwrap_or([u, u, u, 0.0, 0.0, 0.0])
            })
            .collect()
        })
    }

    fn set(&mut self, at: usize, row: u32, atom: &Atom<'_>, atomic_number: u8, chain: u32) {
        self.positions[at] = atom.position;
        self.rows[at] = row;
        self.atomic_numbers[at] = atomic_number;
        self.serials[at] = atom.serial;
        self.residues[at] = atom.residue;
        self.chains[at] = chain;
        self.hetero[at] = atom.hetero.into();
        self.occupancies[at] = atom.occupancy.unwrap_or(1.0);
        self.b_factors[at] = atom.b_factor.unwrap_or(0.0);
        self.charges[at] = atom.charge.unwrap_or(0);
        let velocity = atom.velocity.unwrap_or_default();
        self.velocities[3 * at..3 * at + 3].copy_from_slice(&velocity);
        self.displacements[at] = None;
        self.has_occupancy |= atom.occupancy.is_some();
        self.has_b_factor |= atom.b_factor.is_some();
        self.has_charge |= atom.charge.is_some_and(|charge| charge != 0);
        self.has_velocity |= atom.velocity.is_some();
    }

    /// Chains are numbered from 0 in the order of the file.
    fn chain_number(&mut self, chain: &[u8]) -> u32 {
        if let Some((last, number)) = &self.last_chain
            && **last == *chain
        {
            return *number;
        }
        let next = self.chain_numbers.len() as u32;
        let number = match self.chain_numbers.get(chain) {
            Some(&number) => number,
            None => *self.chain_numbers.entry(chain.into()).or_insert(next),
        };
        self.last_chain = Some((chain.into(), number));
        number
    }

    /// The particles, with radii in the file's unit, and what there is to say about them.
    pub(super) fn finish(
        self,
        unit_per_angstrom: f64,
    ) -> Result<(Particles, Vec<String>), ParseError> {
        let mut warnings = Vec::new();
        if self.replaced > 0 {
            warnings.push(format!(
                "{} alternate locations were left out: of each atom the one with the highest \
                 occupancy stays, the first among equals",
                self.replaced
            ));
        }
        if self.without_atom > 0 {
            warnings.push(format!(
                "{} sites without an atom (charges of a water model) were left out",
                self.without_atom
            ));
        }
        let unknown = self.atomic_numbers.iter().filter(|&&z| z == 0).count();
        if unknown > 0 {
            warnings.push(format!(
                "the element of {unknown} atoms is not known: they get a radius of {UNKNOWN_RADIUS} Å"
            ));
        }
        let displacements = self.all_displacements();
        let radii: Vec<f32> = self
            .atomic_numbers
            .iter()
            .map(|&z| (van_der_waals_radius(z) * unit_per_angstrom) as f32)
            .collect();
        let mut columns = vec![
            Column::new("atomic_number", 1, self.atomic_numbers),
            Column::new("radius", 1, radii),
            Column::new("serial", 1, self.serials),
            Column::new("residue", 1, self.residues),
            Column::new("chain", 1, self.chains),
        ];
        if self.hetero.contains(&1) {
            columns.push(Column::new("hetero", 1, self.hetero));
        }
        if self.has_occupancy {
            columns.push(Column::new("occupancy", 1, self.occupancies));
        }
        if self.has_b_factor {
            columns.push(Column::new("b_factor", 1, self.b_factors));
        }
        if self.has_charge {
            columns.push(Column::new("charge", 1, self.charges));
        }
        if self.has_velocity {
            columns.push(Column::new("velocity", 3, self.velocities));
        }
        columns.extend(displacements.map(|u| Column::new("anisou", 6, u)));
        let mut particles = assemble(self.positions, columns)?;
        particles.rows = self.rows;
        Ok((particles, warnings))
    }

    /// As [`Atoms::finish`], for the frame asked for of a file of `frames`.
    pub(super) fn into_parsed(
        self,
        unit_per_angstrom: f64,
        frames: usize,
    ) -> Result<Parsed, ParseError> {
        let seen = self.seen as usize;
        let (particles, warnings) = self.finish(unit_per_angstrom)?;
        Ok(Parsed {
            left_out: seen - particles.len(),
            particles,
            frames,
            warnings,
        })
    }
}
