//! `[motion]`: how long the shutter is open, and what time means in the files.

use serde::{Deserialize, Serialize};

/// `[motion]`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MotionSettings {
    /// Part of the time between two pictures that the shutter is open, its middle at the frame's time:
    /// 0 (no blur) to [`MAX_SHUTTER`].
    pub shutter: f64,
    /// Pictures per second, above 0.
    pub fps: f64,
    /// Factor that turns the particles' velocities (and accelerations) into the file's unit of length per
    /// second; not 0.
    pub velocity_scale: f64,
    /// When the frame is, in seconds: what the keys of the camera and of instances count in. `render` adds
    /// the time since the first frame of a sequence.
    pub time: f64,
}

/// Longest shutter, in times between two pictures.
pub const MAX_SHUTTER: f64 = 100.0;

impl Default for MotionSettings {
    fn default() -> Self {
        Self {
            shutter: 0.0,
            fps: 25.0,
            velocity_scale: 1.0,
            time: 0.0,
        }
    }
}

impl MotionSettings {
    /// When the shutter opens and closes, in seconds relative to the frame.
    pub fn shutter_secs(&self) -> [f64; 2] {
        let half = 0.5 * self.shutter / self.fps;
        [-half, half]
    }

    pub(super) fn is_default(&self) -> bool {
        *self == Self::default()
    }
}
