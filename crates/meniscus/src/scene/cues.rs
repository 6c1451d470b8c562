//! Depth cues: marks that help the eye to read a picture's depth, put over the finished light.

use serde::{Deserialize, Serialize};

/// `[cues]`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CueSettings {
    /// Dark lines where one thing ends before another and where surfaces turn away, 0 (none) to 1
    /// (black).
    pub silhouettes: f64,
    /// Darkens what lies behind something near and lifts what lies before something far, by unsharp
    /// masking of the depth (Luft, Colditz & Deussen 2006); 0 is none, 1 strong.
    pub depth_shading: f64,
    /// How wide [`CueSettings::depth_shading`] reaches, as a part of the picture's diagonal.
    pub depth_reach: f64,
}

impl Default for CueSettings {
    fn default() -> Self {
        Self {
            silhouettes: 0.0,
            depth_shading: 0.0,
            depth_reach: 0.02,
        }
    }
}

impl CueSettings {
    pub(super) fn is_default(&self) -> bool {
        *self == Self::default()
    }

    /// Whether there is anything to do.
    pub fn are_wanted(&self) -> bool {
        self.silhouettes > 0.0 || self.depth_shading > 0.0
    }
}
