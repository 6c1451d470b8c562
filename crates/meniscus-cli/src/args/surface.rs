//! What turns particles into a surface.

use clap::Args;

/// Surface options, shared by all commands that read particles.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "Surface")]
pub(crate) struct SurfaceArgs {
    /// Particle radius in the file's unit: half the spacing with volume weights, else the surface of
    /// a lone particle [default: the file's radii, else half the median spacing]
    #[arg(
        short,
        long,
        value_name = "X",
        allow_hyphen_values = true,
        conflicts_with = "support"
    )]
    pub radius: Option<f64>,
    /// Support radius R of every particle; overrides all radii
    #[arg(long, value_name = "X", allow_hyphen_values = true)]
    pub support: Option<f64>,
    /// Column with the metric tensor of ellipsoids, six or nine components; replaces all radii
    /// [default: a column named metric, if there is one]
    #[arg(long, value_name = "COLUMN", allow_hyphen_values = true)]
    pub metric: Option<String>,
    /// Column with the three radii of ellipsoids along their axes; with --axes, --orientation or neither.
    /// This and the next three may be several columns, as in u,v,w
    #[arg(long, value_name = "COLUMN", allow_hyphen_values = true)]
    pub radii: Option<String>,
    /// Columns with the axes of ellipsoids, three vectors; without radii their lengths are the radii
    #[arg(long, value_name = "COLUMN", allow_hyphen_values = true)]
    pub axes: Option<String>,
    /// Column with the quaternion x y z w that turns ellipsoids with radii
    #[arg(long, value_name = "COLUMN", allow_hyphen_values = true)]
    pub orientation: Option<String>,
    /// Column with the deformation gradient, row by row, that stretches supports
    #[arg(long, value_name = "COLUMN", allow_hyphen_values = true)]
    pub deformation: Option<String>,
    /// Where shapes of supports come from: columns of usual names (auto), none, the neighbours (estimate),
    /// which makes thin sheets whole and flat, or thermal ellipsoids of atoms (thermal) [default: auto]
    #[arg(long, value_name = "HOW")]
    pub anisotropy: Option<String>,
    /// Probability of thermal ellipsoids [default: 0.5]
    #[arg(long, value_name = "P", allow_hyphen_values = true)]
    pub probability: Option<f64>,
    /// R over the radius with volume weights [default: 4]
    #[arg(long, value_name = "X", allow_hyphen_values = true)]
    pub smoothing: Option<f64>,
    /// Threshold T > 0: the surface is where the field equals T [default: 0.6]
    #[arg(short, long, value_name = "X", allow_hyphen_values = true)]
    pub threshold: Option<f64>,
    /// Kernel: quartic, sextic, octic, wyvill [default: sextic]
    #[arg(long, value_name = "NAME")]
    pub kernel: Option<String>,
    /// Weight of each particle: unit, volume, ball-volume (for --anisotropy estimate), or a column [default: volume]
    #[arg(
        long,
        value_name = "unit|volume|ball-volume|COLUMN",
        allow_hyphen_values = true
    )]
    pub weights: Option<String>,
    /// Keep only the particles for which this holds, as in 'y > -1 && |velocity| < 3'
    #[arg(long, value_name = "EXPR", allow_hyphen_values = true)]
    pub filter: Option<String>,
    /// Column to carry along and blend on the surface (repeatable)
    #[arg(
        short,
        long = "attribute",
        value_name = "NAME",
        allow_hyphen_values = true
    )]
    pub attributes: Vec<String>,
}
