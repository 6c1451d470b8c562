//! Attributes of particles on the surface, blended by field weight.

use crate::field::Contribution;
use crate::frame::Frame;
use crate::intersect::Hit;
use glam::DVec3;

/// Names and components of all attributes that any surface of the frame carries, each name once, in
/// order of first appearance; those of a name's first surface count.
pub fn frame_attributes(frame: &Frame) -> Vec<(String, usize)> {
    let mut all: Vec<(String, usize)> = Vec::new();
    for blobs in frame.blobs() {
        for attribute in &blobs.field.attributes {
            if !all.iter().any(|(name, _)| *name == attribute.name) {
                all.push((attribute.name.clone(), attribute.components));
            }
        }
    }
    all
}

/// Where the attributes of each geometry go in the list of [`frame_attributes`].
#[derive(Debug, Clone)]
pub struct AttributeLayout {
    /// Numbers over all attributes.
    total: usize,
    /// For each geometry, for each of its attributes: first number and how many fit.
    places: Vec<Vec<(usize, usize)>>,
}

impl AttributeLayout {
    /// The layout of a frame.
    pub fn new(frame: &Frame) -> Self {
        let all = frame_attributes(frame);
        let place = |name: &str, components: usize| {
            let mut offset = 0;
            for (known, known_components) in &all {
                if known == name {
                    return (offset, components.min(*known_components));
                }
                offset += known_components;
            }
            (offset, 0)
        };
        Self {
            total: all.iter().map(|(_, components)| components).sum(),
            places: frame
                .geometries
                .iter()
                .map(|geometry| {
                    geometry.blobs().map_or_else(Vec::new, |blobs| {
                        let attributes = blobs.field.attributes.iter();
                        attributes.map(|a| place(&a.name, a.components)).collect()
                    })
                })
                .collect(),
        }
    }
}

/// Attributes at one hit; buffers that are reused from hit to hit.
#[derive(Debug, Default)]
pub(super) struct SurfaceAttributes {
    parts: Vec<Contribution>,
    blend: Vec<f64>,
    own: Vec<f32>,
    /// When, in seconds relative to the frame.
    pub(super) time_secs: f64,
    /// All attributes of the frame, see [`frame_attributes`].
    pub(super) all: Vec<f32>,
}

impl SurfaceAttributes {
    /// Finds the blobs of surface `surface` at a world point; [`SurfaceAttributes::value`] blends what
    /// they carry.
    pub(super) fn gather(&mut self, frame: &Frame, surface: u32, position: DVec3) {
        self.parts.clear();
        let instance = frame.instances[surface as usize].at(self.time_secs);
        if let Some(blobs) = frame.geometries[instance.geometry as usize].blobs() {
            let object = instance.object_from_world.transform_point3(position);
            let local = object - blobs.field.origin;
            let field = blobs.field.at(self.time_secs);
            field.contributions(local, &mut self.parts);
        }
    }

    /// Attribute `attribute` of the surface that was gathered, all its components.
    pub(super) fn value(&mut self, frame: &Frame, surface: u32, attribute: usize) -> &[f32] {
        self.own.clear();
        let geometry = frame.instances[surface as usize].geometry as usize;
        if let Some(blobs) = frame.geometries[geometry].blobs()
            && let Some(column) = blobs.field.attributes.get(attribute)
        {
            self.blend.clear();
            self.blend.resize(column.components, 0.0);
            blobs.field.blend(attribute, &self.parts, &mut self.blend);
            self.own
                .extend(self.blend.iter().map(|&value| value as f32));
        }
        &self.own
    }

    /// Fills [`SurfaceAttributes::all`].
    pub(super) fn fill_all(&mut self, frame: &Frame, hit: &Hit, layout: &AttributeLayout) {
        self.all.clear();
        self.all.resize(layout.total, 0.0);
        let geometry = frame.instances[hit.surface as usize].geometry as usize;
        for (attribute, &(offset, components)) in layout.places[geometry].iter().enumerate() {
            self.value(frame, hit.surface, attribute);
            self.all[offset..offset + components].copy_from_slice(&self.own[..components]);
        }
    }
}
