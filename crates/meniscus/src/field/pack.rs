//! The last step of a build: f32 arrays about a local origin, and the report.

use super::build::{Build, PARALLEL};
use super::colors;
use super::supports::Supports;
use super::{
    BlobField, FieldAttribute, FieldBuild, FieldError, FieldReport, Search, SupportSource,
};
use crate::scene::surface::BlobSettings;
use glam::DVec3;
use rayon::prelude::*;

/// Share of the particles left out at either end of each axis when the origin is chosen, so that a few
/// that flew far away do not cost the rest their precision.
const OUTLIERS: f64 = 0.02;
/// At most this many particles decide on the origin.
const SAMPLES: usize = 1 << 12;

impl Build<'_> {
    /// Packs what is left.
    pub(super) fn pack(
        self,
        settings: &BlobSettings,
        supports: Supports,
        support_source: SupportSource,
        spacing: Option<f64>,
    ) -> Result<FieldBuild, FieldError> {
        let positions = self.places();
        let origin = local_origin(&positions);
        let centers: Vec<[f32; 3]> = positions
            .par_iter()
            .with_min_len(PARALLEL)
            .map(|p| (*p - origin).as_vec3().to_array())
            .collect();
        let attributes = self.attributes(&settings.attributes)?;
        let (support_min, support_max) = supports.range();
        let mut report = FieldReport {
            total: self.particles.len(),
            filtered: self.filtered,
            dropped: self.dropped.iter().map(|dropped| dropped.count).sum(),
            spacing,
            support_min,
            support_max,
            support_source,
            warnings: self
                .dropped
                .iter()
                .map(|d| d.sentence())
                .chain(self.notes.iter().cloned())
                .collect(),
        };
        let largest = positions
            .par_iter()
            .with_min_len(PARALLEL)
            .map(|p| (*p - origin).abs().max_element())
            .reduce(|| 0.0, f64::max);
        report.warnings.extend(notes(&report, largest));
        let weights = match &self.weights {
            None => vec![1.0; self.kept.len()],
            Some(weights) => weights.iter().map(|&weight| weight as f32).collect(),
        };
        let field = BlobField {
            kernel: settings.kernel,
            threshold: settings.threshold as f32,
            origin,
            centers,
            shapes: supports.packed(),
            weights,
            rows: self
                .kept
                .par_iter()
                .with_min_len(PARALLEL)
                .map(|&i| self.particles.rows[i as usize])
                .collect(),
            motion: None,
            attributes,
            spacing: spacing.unwrap_or(0.5 * support_min) as f32,
            search: Search::default(),
        };
        Ok(FieldBuild { field, report })
    }

    fn attributes(&self, names: &[String]) -> Result<Vec<FieldAttribute>, FieldError> {
        names
            .iter()
            .map(|name| {
                let missing = |missing| FieldError::Missing {
                    what: "attribute",
                    missing,
                };
                if let Some(colors) = colors::colors(self.particles, name) {
                    let kept = self.kept.iter().flat_map(|&i| colors(i as usize));
                    return Ok(FieldAttribute {
                        name: name.clone(),
                        components: 3,
                        data: kept.collect(),
                    });
                }
                let attribute = self.particles.attribute(name).map_err(missing)?;
                let components = attribute.components();
                let data = self
                    .kept
                    .iter()
                    .flat_map(|&i| (0..components).map(move |c| (i as usize, c)))
                    .map(|(row, component)| attribute.get(row, component) as f32)
                    .collect();
                Ok(FieldAttribute {
                    name: name.clone(),
                    components,
                    data,
                })
            })
            .collect()
    }
}

/// Sentences about how the supports came about and what f32 makes of the positions.
fn notes(report: &FieldReport, largest: f64) -> Vec<String> {
    let mut notes = Vec::new();
    match &report.support_source {
        SupportSource::Estimate => notes.push(format!(
            "the particles have no radius: took half their median nearest-neighbour distance, {:.6}; \
             --radius sets another",
            0.5 * report.spacing.unwrap_or(0.0)
        )),
        SupportSource::Metric { column, order } => notes.push(format!(
            "ellipsoids from column {column}, read as the metric M of q = dᵀMd, {}",
            order.describe()
        )),
        SupportSource::Elements => notes.push(
            "the particles have no radius: took the van der Waals radii of their elements in ångström; \
             --radius sets another"
                .to_owned(),
        ),
        SupportSource::Support
        | SupportSource::Radius
        | SupportSource::Column(_)
        | SupportSource::Ellipsoids(_) => {}
    }
    // Half a unit in the last place of the largest local coordinate.
    let rounding = largest * f64::from(f32::EPSILON) * 0.5;
    if rounding > 1e-3 * report.support_min {
        notes.push(format!(
            "positions are rounded by up to {rounding:.1e}, the smallest support radius is {:.1e}: the \
             particles spread too far for their size; --filter can remove what lies far out",
            report.support_min
        ));
    }
    notes
}

/// The middle of the particles without the farthest few, on a grid so coarse that subtracting it from
/// f32 coordinates is nearly always exact.
fn local_origin(positions: &[DVec3]) -> DVec3 {
    let stride = positions.len().div_ceil(SAMPLES).max(1);
    let sample: Vec<DVec3> = positions.iter().copied().step_by(stride).collect();
    if sample.is_empty() {
        return DVec3::ZERO;
    }
    let skipped = (sample.len() as f64 * OUTLIERS) as usize;
    let ends = [0, 1, 2].map(|axis| {
        let mut values: Vec<f64> = sample.iter().map(|p| p[axis]).collect();
        values.sort_unstable_by(f64::total_cmp);
        (values[skipped], values[values.len() - 1 - skipped])
    });
    let extent = ends
        .iter()
        .fold(0.0, |e: f64, (low, high)| e.max(high - low));
    let grid = if extent > 0.0 {
        (extent.log2().floor() - 3.0).exp2()
    } else {
        0.0
    };
    DVec3::from_array(ends.map(|(low, high)| {
        let middle = low * 0.5 + high * 0.5;
        let snapped = (middle / grid).round() * grid;
        if snapped.is_finite() { snapped } else { middle }
    }))
}
