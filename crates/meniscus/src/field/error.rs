//! Why particles and settings make no field.

use crate::particles::MissingColumn;
use crate::particles::filter::FilterError;

/// Particles or settings that define no field. Messages name the command line's flags; scene files
/// use the same words as keys.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FieldError {
    /// A number is out of its range.
    #[error("{name} is {value}: expected {expected}")]
    Setting {
        /// The setting's name, as in scene files.
        name: &'static str,
        /// Its value.
        value: f64,
        /// The values it may have.
        expected: &'static str,
    },
    /// Two settings that both decide on the supports.
    #[error(
        "{first} and {second} exclude each other: both decide how far a particle reaches; give one"
    )]
    Conflict {
        /// A setting.
        first: &'static str,
        /// Another.
        second: &'static str,
    },
    /// A quaternion turns what has radii.
    #[error("--orientation turns ellipsoids and needs their three radii; give --radii COLUMN")]
    OrientationNeedsRadii,
    /// With unit or column weights a lone particle reaches 1 at most.
    #[error(
        "threshold {threshold} with weights {weights}: no particle alone reaches 1 or more, so the radius \
         cannot tell how far particles reach; give --support"
    )]
    ThresholdNeedsSupport {
        /// The threshold.
        threshold: f64,
        /// The kind of weights.
        weights: String,
    },
    /// The filter does not parse or does not fit.
    #[error(transparent)]
    Filter(#[from] FilterError),
    /// A column is missing.
    #[error("{what}: {missing}")]
    Missing {
        /// What the column was asked for.
        what: &'static str,
        /// Its name and what there is.
        missing: MissingColumn,
    },
    /// A column has the wrong number of components.
    #[error("{what}: column `{name}` has {found} components, expected {expected}")]
    Components {
        /// What the column was asked for.
        what: &'static str,
        /// The column.
        name: String,
        /// How many it has.
        found: usize,
        /// How many it should have.
        expected: &'static str,
    },
    /// No radius in the file and none to estimate.
    #[error(
        "the file has no radii, and none can be estimated because no two particles are apart; give --radius \
         or --support"
    )]
    NoRadius,
    /// Nothing is left.
    #[error("no particle is left of {total}{}", explained(.reasons))]
    Empty {
        /// Particles before anything was removed.
        total: usize,
        /// What was removed and why.
        reasons: Vec<String>,
    },
}

fn explained(reasons: &[String]) -> String {
    if reasons.is_empty() {
        return String::new();
    }
    format!(": {}", reasons.join("; "))
}
