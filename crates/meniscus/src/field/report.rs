//! What a user should know about a field that was built.

use super::MetricOrder;

/// Where the supports came from.
#[derive(Debug, Clone, PartialEq)]
pub enum SupportSource {
    /// The setting `support`.
    Support,
    /// The setting `radius`.
    Radius,
    /// A column of radii.
    Column(String),
    /// A column of metrics.
    Metric {
        /// The column.
        column: String,
        /// How its components are ordered.
        order: MetricOrder,
    },
    /// Columns of radii, axes, orientations or displacements of ellipsoids.
    Ellipsoids(String),
    /// Van der Waals radii in ångström, by the column of atomic numbers.
    Elements,
    /// Half the median distance of nearest neighbours.
    Estimate,
}

/// What building a field did to the particles.
#[derive(Debug, Clone, PartialEq)]
pub struct FieldReport {
    /// Particles given.
    pub total: usize,
    /// Particles that the filter removed.
    pub filtered: usize,
    /// Particles dropped for other reasons; the warnings say which.
    pub dropped: usize,
    /// Median distance of nearest neighbours at a non-zero distance, in the file's unit; `None` when no
    /// two particles are apart. Of many particles whose supports do not depend on it, that of a part.
    pub spacing: Option<f64>,
    /// Smallest support radius; of ellipsoids the radius of the ball of the same volume.
    pub support_min: f64,
    /// Largest support radius.
    pub support_max: f64,
    /// Where the supports came from.
    pub support_source: SupportSource,
    /// What to tell the user, a sentence each.
    pub warnings: Vec<String>,
}
