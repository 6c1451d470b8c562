//! How much light a rough boundary reflects in all, by angle and roughness.

use super::microfacet::Ggx;
use super::{SMOOTH, width_of};
use glam::DVec3;
use std::sync::LazyLock;

/// Entries along each side of a table.
pub(in crate::shade) const ENTRIES: usize = 32;
/// Points at which a mean over facets is taken.
const FACETS: u32 = 256;

/// Hemispherical reflectance of single scattering, tabled over the cosine of the view and the
/// roughness (Kulla & Conty, "Revisiting Physically Based Shading at Imageworks", 2017).
#[derive(Debug, Clone)]
pub(in crate::shade) struct AlbedoTable {
    /// Rows of equal roughness; along a row the square root of the cosine rises from 0 to 1.
    pub(in crate::shade) entries: Vec<f64>,
    /// Mean over all cosines, weighted by the cosine; one per row.
    pub(in crate::shade) means: Vec<f64>,
}

/// Of a boundary that reflects everything.
static FULL: LazyLock<AlbedoTable> = LazyLock::new(|| AlbedoTable::new(|_| 1.0, |_, _| 1.0));

impl AlbedoTable {
    /// Of a boundary that reflects everything: what single scattering keeps of it.
    pub(in crate::shade) fn full() -> &'static Self {
        &FULL
    }

    /// Of a boundary that reflects `reflectance(cosine)` at each facet.
    pub(super) fn of_reflectance(reflectance: impl Fn(f64) -> f64) -> Self {
        Self::new(&reflectance, |view, half| reflectance(view.dot(half)))
    }

    /// `smooth(cosine)` is the reflectance without roughness; `facet(view, half)` that of one facet.
    fn new(smooth: impl Fn(f64) -> f64, facet: impl Fn(DVec3, DVec3) -> f64) -> Self {
        Self::tabled(smooth, |ggx, view, half| {
            let light = half * (2.0 * view.dot(half)) - view;
            if light.z > 0.0 {
                facet(view, half) * ggx.shadowing(view, light)
            } else {
                0.0
            }
        })
    }

    /// `rough(ggx, view, half)` is what one visible facet keeps.
    pub(super) fn tabled(
        smooth: impl Fn(f64) -> f64,
        rough: impl Fn(&Ggx, DVec3, DVec3) -> f64,
    ) -> Self {
        let mut entries = Vec::with_capacity(ENTRIES * ENTRIES);
        for row in 0..ENTRIES {
            let width = width_of(row as f64 / (ENTRIES - 1) as f64);
            let ggx = Ggx::new(width);
            for column in 0..ENTRIES {
                let root = column as f64 / (ENTRIES - 1) as f64;
                let cosine = (root * root).max(1e-4);
                if width < SMOOTH {
                    entries.push(smooth(cosine));
                    continue;
                }
                let view = DVec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine);
                let sum: f64 = (0..FACETS)
                    .map(|i| {
                        let u = [
                            (f64::from(i) + 0.5) / f64::from(FACETS),
                            f64::from(i.reverse_bits()) / 4_294_967_296.0 + 0.5 / f64::from(FACETS),
                        ];
                        rough(&ggx, view, ggx.sample(view, u))
                    })
                    .sum();
                entries.push(sum / f64::from(FACETS));
            }
        }
        let mut table = Self {
            entries,
            means: Vec::new(),
        };
        const STEPS: u32 = 1024;
        table.means = (0..ENTRIES)
            .map(|row| {
                let roughness = row as f64 / (ENTRIES - 1) as f64;
                let sum: f64 = (0..STEPS)
                    .map(|i| {
                        let cosine = (f64::from(i) + 0.5) / f64::from(STEPS);
                        table.at(cosine, roughness) * 2.0 * cosine
                    })
                    .sum();
                sum / f64::from(STEPS)
            })
            .collect();
        table
    }

    /// The reflectance seen at a cosine.
    pub(super) fn at(&self, cosine: f64, roughness: f64) -> f64 {
        let (row, across) = place(roughness);
        let (column, along) = place(cosine.max(0.0).sqrt());
        let in_row = |row: usize| {
            let [a, b] = [0, 1].map(|next| self.entries[row * ENTRIES + column + next]);
            a + (b - a) * along
        };
        in_row(row) + (in_row(row + 1) - in_row(row)) * across
    }

    /// The mean over all cosines.
    pub(super) fn mean(&self, roughness: f64) -> f64 {
        let (row, across) = place(roughness);
        self.means[row] + (self.means[row + 1] - self.means[row]) * across
    }
}

/// The entry below and the part of the way to the next one.
fn place(part: f64) -> (usize, f64) {
    let position = part.clamp(0.0, 1.0) * (ENTRIES - 1) as f64;
    let below = (position as usize).min(ENTRIES - 2);
    (below, position - below as f64)
}
