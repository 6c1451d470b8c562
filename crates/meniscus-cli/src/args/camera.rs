//! Where the picture is taken from, and the sun.

use super::values::Triple;
use clap::Args;

/// Camera and light options.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "Camera and light")]
pub(crate) struct CameraArgs {
    /// Where the camera stands [default: such that it frames the object]
    #[arg(long, value_name = "x,y,z", allow_hyphen_values = true)]
    pub camera_eye: Option<Triple>,
    /// What it looks at [default: the middle of the object]
    #[arg(long, value_name = "x,y,z", allow_hyphen_values = true)]
    pub camera_target: Option<Triple>,
    /// Which way is up: x, y, z, -x, -y, -z or three numbers [default: y]
    #[arg(long, value_name = "AXIS", allow_hyphen_values = true)]
    pub up: Option<String>,
    /// Vertical field of view in degrees [default: 40]
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true)]
    pub fov: Option<f64>,
    /// Direction towards the sun [default: high, to one side behind the camera]
    #[arg(long, value_name = "x,y,z", allow_hyphen_values = true)]
    pub light: Option<Triple>,
    /// Cut the objects open; what stays is written as x<0.5, z>-1 or nx,ny,nz,d for n·p < d (repeatable)
    #[arg(long, value_name = "PLANE", allow_hyphen_values = true)]
    pub clip: Vec<String>,
}
