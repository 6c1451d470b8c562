//! Where rays are traced: `--device`.

use super::engine::EngineChoice;
use crate::exit::{Failure, Outcome};
use crate::progress::Reporter;
use meniscus::frame::Frame;
use meniscus::intersect::{BlobTracer, Crossing, Hit, OnCpu, Scratch, TraceError};
use meniscus::math::ray::Ray;
use meniscus::scene::camera::Camera;
use meniscus_gpu::{
    AdapterChoice, Device, FrameTracer, GpuError, OpenOptions, PeelTracer, PeelWork, Takeover,
};
use std::fmt::Write as _;
use std::sync::Arc;
use std::time::Instant;

/// What was asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum DeviceWish {
    /// The processor.
    Cpu,
    /// A card, or an error.
    Gpu,
    /// A card where there is one that can do the work.
    Auto,
}

/// An open card.
#[derive(Debug, Clone)]
pub(crate) struct OpenDevice {
    device: Arc<Device>,
    takeover: Takeover,
}

/// What to do where a card cannot.
const ON_CPU: &str = "--device cpu traces on the processor";

impl DeviceWish {
    /// From the option's value.
    pub(crate) fn new(name: Option<&str>) -> Outcome<Self> {
        match name {
            None | Some("auto") => Ok(Self::Auto),
            Some("cpu") => Ok(Self::Cpu),
            Some("gpu") => Ok(Self::Gpu),
            Some(other) => Err(Failure::wrong(format!("there is no device `{other}`"))
                .with_help("there are: cpu, gpu, auto")),
        }
    }

    /// A card cannot do this work: an error, or the processor does it.
    pub(crate) fn refuse(self, undoable: &str, reporter: &Reporter) -> Outcome<Option<OpenDevice>> {
        match self {
            Self::Cpu => Ok(None),
            Self::Gpu => Err(
                Failure::wrong(format!("--device gpu cannot do {undoable} yet")).with_help(ON_CPU),
            ),
            Self::Auto => {
                reporter.note(&format!(
                    "on the processor: a card cannot do {undoable} yet"
                ));
                Ok(None)
            }
        }
    }

    /// Opens a card.
    pub(crate) fn open(self, reporter: &Reporter) -> Outcome<Option<OpenDevice>> {
        let options = OpenOptions::from_environment();
        match self {
            Self::Cpu => Ok(None),
            Self::Gpu => {
                let device = Device::open(options)
                    .map_err(|error| Failure::work(error.to_string()).with_help(ON_CPU))?;
                reporter.note(&format!("on {}", device.describe()));
                Ok(Some(OpenDevice {
                    device: Arc::new(device),
                    takeover: Takeover::Never,
                }))
            }
            Self::Auto => match Device::open(OpenOptions {
                choice: options.choice.without_software(),
                ..options
            }) {
                Ok(device) => {
                    reporter.tell(&format!("on {}; {ON_CPU}", device.describe()));
                    Ok(Some(OpenDevice {
                        device: Arc::new(device),
                        takeover: Takeover::ByCpu,
                    }))
                }
                Err(error @ GpuError::NoAdapter { .. }) => {
                    if options.choice != AdapterChoice::Nothing {
                        reporter.note(&format!("on the processor: {error}"));
                    }
                    Ok(None)
                }
                Err(error) => {
                    reporter.warn(&format!("on the processor: {error}"));
                    Ok(None)
                }
            },
        }
    }
}

/// What traces a frame.
pub(crate) enum Tracing<'a> {
    /// The processor.
    Cpu,
    /// A card.
    Gpu(Box<FrameTracer<'a>>),
    /// A card, the camera's rays by engine `peel`.
    Peel(Box<PeelTracer<'a>>),
}

impl OpenDevice {
    /// The card and its driver, for messages.
    pub(crate) fn describe(&self) -> String {
        self.device.describe()
    }

    /// Whether it is a driver that runs on the processor.
    pub(crate) fn is_software(&self) -> bool {
        self.device.is_software()
    }

    /// Uploads a frame, for engine `peel` as `camera` sees it; where that fails and the processor may
    /// take over, it does.
    pub(crate) fn upload(
        &self,
        frame: &Frame,
        camera: Option<&Camera>,
        reporter: &Reporter,
    ) -> Outcome<Tracing<'_>> {
        if self.takeover == Takeover::ByCpu && self.device.is_lost() {
            return Ok(Tracing::Cpu);
        }
        let uploaded = match camera {
            None => FrameTracer::upload(&self.device, frame, self.takeover)
                .map(|tracer| Tracing::Gpu(Box::new(tracer))),
            Some(camera) => PeelTracer::upload(&self.device, frame, camera, self.takeover)
                .map(|tracer| Tracing::Peel(Box::new(tracer))),
        };
        match uploaded {
            Ok(tracing) => Ok(tracing),
            Err(error @ GpuError::Unfit { .. }) => Err(Failure::wrong(error.to_string())
                .with_help("--engine particles can, and on the processor --engine sweep with all its switches")),
            Err(error) if self.takeover == Takeover::ByCpu => {
                reporter.warn(&format!("on the processor: {error}"));
                Ok(Tracing::Cpu)
            }
            Err(error) => Err(Failure::work(error.to_string()).with_help(ON_CPU)),
        }
    }
}

/// The failure of a device that nobody takes over from.
pub(crate) fn trace_failure(error: &TraceError) -> Failure {
    Failure::work(error.to_string()).with_help(format!(
        "{ON_CPU}; with --device auto it takes over by itself"
    ))
}

impl Tracing<'_> {
    /// What traces a frame on `device`, or on the processor where there is none.
    pub(crate) fn of<'d>(
        device: Option<&'d OpenDevice>,
        frame: &Frame,
        reporter: &Reporter,
    ) -> Outcome<Tracing<'d>> {
        match device {
            None => Ok(Tracing::Cpu),
            Some(device) => device.upload(frame, None, reporter),
        }
    }

    /// What traces a frame that `camera` sees, by the engine that was chosen.
    pub(crate) fn seen_by<'d>(
        camera: &Camera,
        engine: &'d EngineChoice,
        frame: &Frame,
        reporter: &Reporter,
    ) -> Outcome<Tracing<'d>> {
        match &engine.device {
            Some(device) if engine.is_peel => device.upload(frame, Some(camera), reporter),
            device => Tracing::of(device.as_ref(), frame, reporter),
        }
    }

    /// What traces a frame on `device`, put there while another frame may still be rendered; `None`
    /// where that does not work, such as for lack of memory: then it is asked for again when it is the
    /// frame's turn.
    pub(crate) fn ahead<'d>(engine: &'d EngineChoice, frame: &Frame) -> Option<Tracing<'d>> {
        let Some(device) = &engine.device else {
            return Some(Tracing::Cpu);
        };
        if engine.is_peel {
            // It has to know the camera.
            return None;
        }
        let tracer = FrameTracer::upload(&device.device, frame, device.takeover).ok()?;
        Some(Tracing::Gpu(Box::new(tracer)))
    }

    /// Takes the frame anew, in the same buffers where the card builds; how long that took, by the clock
    /// on the wall and by the card's own.
    pub(crate) fn update(&mut self, frame: &Frame) -> Outcome<Option<[f64; 2]>> {
        let Self::Gpu(tracer) = self else {
            return Ok(None);
        };
        let start = Instant::now();
        tracer
            .update(frame)
            .map_err(|error| Failure::work(error.to_string()).with_help(ON_CPU))?;
        Ok(Some([start.elapsed().as_secs_f64(), tracer.build_secs()]))
    }

    /// Memory that the frame's surfaces take on the device.
    pub(crate) fn bytes(&self) -> u64 {
        match self {
            Self::Cpu => 0,
            Self::Gpu(tracer) => tracer.bytes(),
            Self::Peel(tracer) => tracer.bytes(),
        }
    }

    /// Time of the device for building its trees, by its own clock.
    pub(crate) fn build_secs(&self) -> Option<f64> {
        match self {
            Self::Cpu | Self::Peel(_) => None,
            Self::Gpu(tracer) => Some(tracer.build_secs()),
        }
    }

    /// Rays to be asked about together.
    pub(crate) fn together(&self, on_cpu: usize) -> usize {
        match self {
            Self::Cpu => on_cpu,
            Self::Gpu(tracer) => tracer.together(),
            Self::Peel(tracer) => tracer.together(),
        }
    }

    /// First hits of many rays.
    pub(crate) fn closest_hits(
        &self,
        frame: &Frame,
        rays: &[Ray],
        hits: &mut [Option<Hit>],
        scratch: &mut Scratch,
    ) -> Result<(), TraceError> {
        match self {
            Self::Cpu => {
                let Ok(()) = frame.closest_hits_by(&OnCpu, rays, hits, scratch);
                Ok(())
            }
            Self::Gpu(tracer) => frame.closest_hits_by(&**tracer, rays, hits, scratch),
            Self::Peel(tracer) => frame.closest_hits_by(&**tracer, rays, hits, scratch),
        }
    }

    /// Whether many rays hit anything.
    pub(crate) fn any_hits(
        &self,
        frame: &Frame,
        rays: &[Ray],
        hits: &mut [bool],
        scratch: &mut Scratch,
    ) -> Result<(), TraceError> {
        match self {
            Self::Cpu => {
                let Ok(()) = frame.any_hits_by(&OnCpu, rays, hits, scratch);
                Ok(())
            }
            Self::Gpu(tracer) => frame.any_hits_by(&**tracer, rays, hits, scratch),
            Self::Peel(tracer) => frame.any_hits_by(&**tracer, rays, hits, scratch),
        }
    }

    /// Every crossing of many rays.
    pub(crate) fn crossings(
        &self,
        frame: &Frame,
        rays: &[Ray],
        crossings: &mut [Vec<Crossing>],
        scratch: &mut Scratch,
    ) -> Result<(), TraceError> {
        match self {
            Self::Cpu => {
                let Ok(()) = frame.crossings_by(&OnCpu, rays, crossings, scratch);
                Ok(())
            }
            Self::Gpu(tracer) => frame.crossings_by(&**tracer, rays, crossings, scratch),
            Self::Peel(tracer) => frame.crossings_by(&**tracer, rays, crossings, scratch),
        }
    }

    /// Time of the device by its own clock so far, in seconds; `None` where it keeps none.
    pub(crate) fn device_secs(&self) -> Option<f64> {
        let secs = match self {
            Self::Cpu => 0.0,
            Self::Gpu(tracer) => tracer.work().device_secs,
            Self::Peel(tracer) => tracer.tree_work().device_secs + tracer.work().secs.total(),
        };
        Some(secs).filter(|&secs| secs > 0.0)
    }

    /// What engine `peel` did so far.
    pub(crate) fn peel_work(&self) -> Option<PeelWork> {
        match self {
            Self::Cpu | Self::Gpu(_) => None,
            Self::Peel(tracer) => Some(tracer.work()),
        }
    }

    /// Says what became of the device's work.
    pub(crate) fn tell(&self, reporter: &Reporter) {
        let (lost, work) = match self {
            Self::Cpu => return,
            Self::Gpu(tracer) => (tracer.lost(), tracer.take_work()),
            Self::Peel(tracer) => {
                let work = tracer.work();
                reporter.note(&format!(
                    "{} of the camera's rays by engine peel, {} of them left to the tree",
                    work.rays, work.left
                ));
                (tracer.lost(), tracer.tree_work())
            }
        };
        if let Some(error) = lost {
            reporter.warn(&format!("{error}; the processor did the rest"));
        }
        let mut told = format!(
            "{} rays on the card, {} of them answered by the processor",
            work.rays, work.on_cpu
        );
        if work.device_secs > 0.0 {
            let _ = write!(told, "; {:.4} s by the card's own clock", work.device_secs);
        }
        reporter.note(&told);
    }
}
