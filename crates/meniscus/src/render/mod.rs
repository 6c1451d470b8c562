//! From a frame and a camera to a film.
//!
//! A [`Backend`] renders a pixel rectangle and a sample range; what it returns merges with the films
//! of other rectangles and ranges to the same bits as one whole run, on any number of threads.

mod cpu;
mod error;
mod noise;
mod progress;
mod settings;
mod stages;
mod state;

pub use cpu::{CpuBackend, DeviceBackend};
pub use error::RenderError;
pub use progress::Progress;
pub use settings::{RenderSettings, RenderStats, Staging};
pub use stages::{
    STRIP_ROWS, SampleBlock, SampleRun, SampleStages, StagedHit, StagedPicture, StagedSample,
};
pub use state::RenderState;

use crate::film::Film;
use crate::frame::Frame;
use crate::scene::camera::Camera;

/// A machine that renders.
pub trait Backend {
    /// What `--device` calls it.
    fn name(&self) -> &'static str;

    /// Renders `settings.region` and `settings.samples` of the picture that `camera` takes of
    /// `frame`. `state` is what earlier frames left behind; the picture does not depend on it.
    ///
    /// # Errors
    /// Impossible settings, too little memory, or [`RenderError::Cancelled`]; there is no film then.
    fn render(
        &self,
        frame: &Frame,
        camera: &Camera,
        settings: &RenderSettings,
        state: &RenderState,
        progress: &Progress<'_>,
    ) -> Result<(Film, RenderStats), RenderError>;
}
