//! Looks that follow particles' attributes: which numbers of them they need, and how they are packed.

use super::words::Words;
use super::{Shader, Unstaged};
use crate::field::BlobField;
use crate::frame::{BaseColor, Coloring, Scaling};
use crate::scene::attribute::Component;
use crate::scene::colormap::ColorTable;
use glam::Vec3;

/// Most numbers of each particle that the looks of a surface may follow.
pub const MOST_COLUMNS: usize = 8;

/// Entries of a colour map's table.
pub const MAP_ENTRIES: u32 = ColorTable::ENTRIES as u32;

/// Stands for an entry that is no finite number, and takes no part.
pub const NO_NUMBER: u32 = u32::MAX;

/// Numbers of a surface's particles that its looks follow, those of a particle side by side.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct StagedColumns {
    /// How many there are of each particle; 0 where nothing varies.
    pub per_particle: u32,
    /// f32 in bits, or [`NO_NUMBER`].
    pub bits: Vec<u32>,
}

/// Columns that follow each other, and the values that become 0 and 1.
#[derive(Debug, Clone, Copy, Default)]
struct Source {
    first: u32,
    /// 0: nothing varies; of several the length counts.
    count: u32,
    range: [f32; 2],
}

/// A colour, constant or not.
#[derive(Debug, Clone, Copy, Default)]
struct ColorSource {
    /// 0 constant, 1 through a map, 2 three columns.
    kind: u8,
    source: Source,
    /// Word of the map's table.
    map: u32,
}

/// What of a material follows attributes, as far as the integrator asks for it.
#[derive(Debug, Default)]
pub(super) struct Varying {
    color: ColorSource,
    roughness: Source,
    absorption: bool,
    /// Colour that absorption leaves behind its depth.
    left: ColorSource,
    density: Source,
    /// Attribute and component of each column.
    columns: Vec<[usize; 2]>,
}

impl Varying {
    /// Finds place for columns; those that are there already are not doubled.
    fn source(&mut self, wanted: &[[usize; 2]], range: [f32; 2]) -> Source {
        let count = wanted.len();
        let known = self.columns.windows(count).position(|w| w == wanted);
        let first = known.unwrap_or_else(|| {
            self.columns.extend_from_slice(wanted);
            self.columns.len() - count
        });
        Source {
            first: first as u32,
            count: count as u32,
            range,
        }
    }

    fn number(&mut self, field: &BlobField, scaling: Option<&Scaling>) -> Source {
        scaling.map_or_else(Source::default, |scaling| {
            let wanted = components(field, scaling.attribute, scaling.component);
            self.source(&wanted, scaling.range)
        })
    }

    fn color(&mut self, field: &BlobField, base: &BaseColor, words: &mut Words) -> ColorSource {
        match base {
            BaseColor::Constant(_) => ColorSource::default(),
            BaseColor::Attribute(coloring) => {
                let Coloring {
                    attribute,
                    component,
                    range,
                    table,
                    ..
                } = &**coloring;
                let map = words.here();
                for &color in table.entries() {
                    words.push(Vec3::from_array(color), 0.0);
                }
                ColorSource {
                    kind: 1,
                    source: self.source(&components(field, *attribute, *component), *range),
                    map,
                }
            }
            BaseColor::Direct(attribute) => ColorSource {
                kind: 2,
                source: self.source(
                    &[0, 1, 2].map(|component| [*attribute, component]),
                    [0.0; 2],
                ),
                map: 0,
            },
        }
    }

    /// 1: colour or roughness, 2: absorption, 3: both.
    pub(super) fn what(&self) -> u8 {
        let has_look = self.color.kind > 0 || self.roughness.count > 0;
        u8::from(has_look) | u8::from(self.absorption) << 1
    }

    /// (kind of colour, its map; kind of the colour that absorption leaves, its map), then (first column,
    /// number of columns, values that become 0 and 1) of colour, roughness, colour left, density, then
    /// (colour left where it is the same everywhere, depth).
    pub(super) fn push(&self, (left, depth): ([f32; 3], f64), words: &mut Words) {
        let kinds = [self.color, self.left].map(|color| (f32::from(color.kind), color.map as f32));
        let [(color, map), (left_kind, left_map)] = kinds;
        words.push(Vec3::new(color, map, left_kind), left_map);
        for source in [
            self.color.source,
            self.roughness,
            self.left.source,
            self.density,
        ] {
            let [low, high] = source.range;
            let columns = [source.first, source.count].map(|n| n as f32);
            words.push(Vec3::new(columns[0], columns[1], low), high);
        }
        words.push(Vec3::from_array(left), depth as f32);
    }

    /// The numbers of all particles.
    fn gathered(&self, field: &BlobField) -> StagedColumns {
        let number = |particle: usize, [attribute, component]: [usize; 2]| {
            let attribute = &field.attributes[attribute];
            let number = attribute.data[particle * attribute.components + component];
            if number.is_finite() {
                number.to_bits()
            } else {
                NO_NUMBER
            }
        };
        let particles = 0..field.len();
        let columns = self.columns.as_slice();
        StagedColumns {
            per_particle: columns.len() as u32,
            bits: particles
                .flat_map(|particle| columns.iter().map(move |&column| number(particle, column)))
                .collect(),
        }
    }
}

/// The columns of an attribute's number that counts.
fn components(field: &BlobField, attribute: usize, component: Component) -> Vec<[usize; 2]> {
    match component {
        Component::Index(index) => vec![[attribute, index]],
        Component::Magnitude => (0..field.attributes[attribute].components)
            .map(|component| [attribute, component])
            .collect(),
    }
}

impl Shader<'_> {
    /// What of a material varies; its maps go to `words`.
    pub(super) fn varying(&self, material: usize, words: &mut Words) -> Varying {
        let mut varying = Varying::default();
        let frame = self.world.frame;
        let mut instances = frame.instances.iter();
        let user = instances.find(|instance| instance.material as usize == material);
        let geometry = user.map(|user| &frame.geometries[user.geometry as usize]);
        let Some(blobs) = geometry.and_then(|geometry| geometry.blobs()) else {
            return varying;
        };
        let field = &blobs.field;
        let material = &frame.materials[material];
        varying.color = varying.color(field, &material.base, words);
        // Others ask for colours alone.
        if self.world.prepared.is_empty() {
            return varying;
        }
        varying.roughness = varying.number(field, material.roughness_by.as_ref());
        let absorption = &material.absorption;
        if material.kind.is_clear() && absorption.constant().is_none() {
            varying.absorption = true;
            varying.left = varying.color(field, &absorption.left, words);
            varying.density = varying.number(field, absorption.density.as_ref());
        }
        varying
    }

    /// The numbers that a surface's looks follow.
    pub(super) fn columns(&self, surface: u32) -> Result<StagedColumns, Unstaged> {
        let frame = self.world.frame;
        let instance = &frame.instances[surface as usize];
        let Some(blobs) = frame.geometries[instance.geometry as usize].blobs() else {
            return Ok(StagedColumns::default());
        };
        let varying = self.varying(instance.material as usize, &mut Words::default());
        match varying.columns.len() {
            0..=MOST_COLUMNS => Ok(varying.gathered(&blobs.field)),
            _ => Err(Unstaged::Attributes),
        }
    }
}
