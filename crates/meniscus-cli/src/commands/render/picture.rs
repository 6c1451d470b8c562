//! One picture: read, build, render, write.

use super::ahead::Ready;
use super::options::PictureOptions;
use crate::exit::{Failure, Outcome};
use crate::interrupt;
use crate::job::device::{Tracing, trace_failure};
use crate::job::engine::EngineChoice;
use crate::job::output::PictureFormat;
use crate::progress::Reporter;
use crate::stats::{FrameStats, ImageStats, RayStats, peak_rss_bytes};
use meniscus::film::{ChannelSet, Curve, Film, FilmError, Legend, Tone, WhitePoint};
use meniscus::frame::{BaseColor, Frame};
use meniscus::render::{
    Backend, CpuBackend, DeviceBackend, Progress, RenderError, RenderSettings, RenderState,
    RenderStats, Staging,
};
use meniscus::scene::Scene;
use meniscus::scene::camera::Camera;
use meniscus::shade::frame_attributes;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

/// What one picture is made from.
pub(crate) struct FrameWork<'a> {
    /// The frame and its scene.
    pub ready: &'a Ready<'a>,
    /// Where the picture goes.
    pub output: &'a Path,
    /// About the file.
    pub options: &'a PictureOptions,
    /// How to trace.
    pub engine: &'a EngineChoice,
    /// What earlier frames left behind.
    pub state: &'a RenderState,
    /// How far the camera is turned around the object, in radians.
    pub turn: f64,
}

/// The scene's camera; what is open frames the objects.
pub(crate) fn camera(scene: &Scene, frame: &Frame) -> Outcome<Camera> {
    let size = [scene.film.width, scene.film.height];
    Camera::from_settings_at(
        &scene.camera,
        frame.framing_bounds(),
        size,
        scene.motion.time,
    )
    .map_err(|error| Failure::wrong(error.to_string()))
}

/// Samples that a pixel got on average.
fn mean_samples(film: &Film, rendered: &RenderStats) -> f64 {
    rendered.rays.primary as f64 / film.region().pixels().max(1) as f64
}

/// Who shaded.
fn told(staging: &Staging) -> String {
    match staging {
        Staging::Device { samples, on_cpu } => {
            format!("{samples} samples shaded on the card, {on_cpu} of them by the processor")
        }
        Staging::Processor(why) => format!("shaded by the processor: {why}"),
    }
}

/// Whether pixels may get fewer samples than `spp`.
fn film_stops_early(work: &FrameWork<'_>) -> bool {
    work.scene().film.noise.is_some() || work.options.time_limit.is_some()
}

/// Depths between which the framed objects lie.
fn depth_range(frame: &Frame, camera: &Camera) -> [f64; 2] {
    let bounds = frame.framing_bounds();
    let middle = camera.depth(bounds.center());
    let reach = (bounds.size() * 0.5).dot(camera.forward.abs());
    [middle - reach, middle + reach]
}

impl FrameWork<'_> {
    fn scene(&self) -> &Scene {
        &self.ready.scene
    }

    /// Renders and writes the picture.
    pub(crate) fn render(&self, reporter: &Reporter) -> Outcome<FrameStats> {
        let start = Instant::now();
        let Ready {
            loaded,
            read_secs,
            build_secs,
            ..
        } = self.ready;
        let mut camera = camera(self.scene(), &loaded.frame)?;
        if self.turn != 0.0 {
            let center = loaded.frame.framing_bounds().center();
            camera = camera.turned(center, loaded.frame.up, self.turn);
        }
        let (mut film, rendered, device_secs) = self.film(&loaded.frame, &camera, reporter)?;
        if self.options.denoise {
            reporter.stage("denoise");
            film.denoise()
                .map_err(|error| Failure::work(error.to_string()))?;
        }
        if self.scene().cues.are_wanted() {
            let range = depth_range(&loaded.frame, &camera);
            film.apply_cues(&self.scene().cues, &camera, range);
        }
        interrupt::check()?;
        if film_stops_early(self) {
            let mean = mean_samples(&film, &rendered);
            reporter.note(&format!("{mean:.1} samples per pixel"));
        }
        reporter.stage("write");
        let writing = Instant::now();
        self.write(&film, &loaded.frame)?;
        let write_secs = writing.elapsed().as_secs_f64();
        reporter.note(&format!(
            "{}: {} particles, read {:.3} s, build {:.3} s, render {:.3} s, write {write_secs:.3} s",
            self.output.display(),
            loaded.particles(),
            read_secs,
            build_secs,
            rendered.seconds,
        ));
        let total_secs = read_secs + build_secs + start.elapsed().as_secs_f64();
        let mean_samples = mean_samples(&film, &rendered);
        Ok(FrameStats {
            device_secs,
            ..self.stats(&rendered, mean_samples, [write_secs, total_secs])
        })
    }

    fn film(
        &self,
        frame: &Frame,
        camera: &Camera,
        reporter: &Reporter,
    ) -> Outcome<(Film, RenderStats, Option<f64>)> {
        let film = &self.scene().film;
        let mut aov = self.options.aov.clone();
        if self.scene().cues.silhouettes > 0.0 {
            aov.push("normal".to_owned());
        }
        if self.options.denoise {
            aov.extend(Film::DENOISING_CHANNELS.map(str::to_owned));
        }
        let channels = ChannelSet::new(&aov, &frame_attributes(frame))
            .map_err(|error| Failure::wrong(format!("--aov: {error}")))?;
        let settings = RenderSettings {
            region: self.options.region,
            spp: film.spp,
            samples: self.options.samples.clone(),
            channels: Arc::new(channels),
            background: film.background.unwrap_or_default(),
            shutter_secs: self.scene().motion.shutter_secs(),
            integrator: self.scene().integrator.clone(),
            noise: film.noise,
            time_limit: self.options.time_limit,
            ..RenderSettings::default()
        };
        reporter.stage("render");
        let start = Instant::now();
        let tracing = match &self.ready.tracing {
            Some(tracing) => Arc::clone(tracing),
            None => Arc::new(Tracing::seen_by(camera, self.engine, frame, reporter)?),
        };
        let upload_secs = start.elapsed().as_secs_f64();
        let advance = |done, total| reporter.advance(done, total);
        let progress = Progress::none()
            .with_cancel(&interrupt::CANCELLED)
            .with_callback(&advance);
        let rendered = match &*tracing {
            Tracing::Cpu => CpuBackend.render(frame, camera, &settings, self.state, &progress),
            Tracing::Gpu(tracer) => {
                let backend = DeviceBackend {
                    name: "gpu",
                    tracer: &**tracer,
                    stages: Some(&**tracer),
                };
                backend.render(frame, camera, &settings, self.state, &progress)
            }
            Tracing::Peel(tracer) => {
                let backend = DeviceBackend {
                    name: "gpu",
                    tracer: &**tracer,
                    stages: None,
                };
                backend.render(frame, camera, &settings, self.state, &progress)
            }
        };
        let device_secs = tracing.device_secs();
        tracing.tell(reporter);
        if let Ok((
            _,
            RenderStats {
                staging: Some(staging),
                ..
            },
        )) = &rendered
        {
            reporter.note(&told(staging));
        }
        rendered
            .map(|(film, stats)| {
                let seconds = stats.seconds + upload_secs;
                (film, RenderStats { seconds, ..stats }, device_secs)
            })
            .map_err(|error| match error {
                RenderError::Device(error) => trace_failure(&error),
                RenderError::Cancelled => Failure::Interrupted,
                RenderError::Film(FilmError::Write { .. }) | RenderError::Threads { .. } => {
                    Failure::work(error.to_string())
                }
                RenderError::Film(FilmError::Memory { .. }) => Failure::work(error.to_string())
                    .with_help("render parts with --region, or fewer channels"),
                _ => Failure::wrong(error.to_string()),
            })
    }

    fn write(&self, film: &Film, frame: &Frame) -> Outcome {
        let failed = |error: FilmError| Failure::work(error.to_string());
        if let Some(picture) = self.legend_beside()
            && let Some(legend) = self.legend(frame)
        {
            legend.write_beside(picture).map_err(failed)?;
        }
        match self.options.format {
            PictureFormat::Png | PictureFormat::Mp4 => {
                let settings = &self.scene().film;
                let tone = Tone {
                    curve: Curve::Filmic,
                    exposure: settings.exposure as f32,
                    white: settings
                        .white_balance
                        .map(WhitePoint::new)
                        .unwrap_or_default(),
                };
                let image = film.develop(tone, self.options.depth);
                image.write_png(self.output).map_err(failed)
            }
            PictureFormat::Exr => film
                .write_exr(self.output, self.options.style)
                .map_err(failed),
        }
    }

    /// The picture that the legend goes with: one of a sequence stands for all where the range is
    /// fixed; a film whose range moves has none.
    fn legend_beside(&self) -> Option<&Path> {
        let own = (self.options.format != PictureFormat::Mp4).then_some(self.output);
        self.options.shared_legend.as_deref().or(own)
    }

    /// The legend of the first surface that is coloured by a column.
    fn legend(&self, frame: &Frame) -> Option<Legend> {
        let coloring = frame
            .materials
            .iter()
            .find_map(|material| match &material.base {
                BaseColor::Attribute(coloring) => Some(coloring),
                BaseColor::Constant(_) | BaseColor::Direct(_) => None,
            })?;
        let by = Some(coloring.label.as_str());
        let surface = (self.scene().surfaces.iter()).find(|s| s.color_by.as_deref() == by)?;
        Some(Legend {
            name: coloring.label.clone(),
            unit: None,
            map: surface.color_map.unwrap_or_default(),
            range: coloring.range.map(f64::from),
        })
    }

    fn stats(
        &self,
        rendered: &RenderStats,
        mean_samples: f64,
        [write_secs, total_secs]: [f64; 2],
    ) -> FrameStats {
        let loaded = &self.ready.loaded;
        let reports = &loaded.reports;
        let settings = loaded.settings.first();
        let film = &self.scene().film;
        let rays = &rendered.rays;
        FrameStats {
            particles: loaded.particles(),
            dropped: reports.iter().map(|report| report.dropped).sum(),
            device: self.engine.device_name(),
            engine: self.engine.name_for(&loaded.frame),
            simd: self.engine.simd,
            threads: rendered.threads,
            kernel: settings.map_or("", |settings| settings.kernel.name()),
            threshold: settings.map_or(0.0, |settings| settings.threshold),
            weights: settings.map_or_else(String::new, |s| s.weights.name().to_owned()),
            spacing: reports.first().and_then(|report| report.spacing),
            support_min: reports
                .iter()
                .map(|r| r.support_min)
                .fold(f64::INFINITY, f64::min),
            support_max: reports.iter().map(|r| r.support_max).fold(0.0, f64::max),
            image: ImageStats {
                width: film.width,
                height: film.height,
                spp: film.spp,
                mean_samples,
            },
            read_secs: self.ready.read_secs,
            build_secs: self.ready.build_secs,
            render_secs: rendered.seconds,
            device_secs: None,
            write_secs,
            total_secs,
            structure_bytes: loaded.frame.structure_bytes(),
            peak_rss_bytes: peak_rss_bytes(),
            rays: RayStats {
                primary: rays.primary,
                shadow: rays.shadow,
                reflection: rays.reflection,
                refraction: rays.refraction,
                ambient_occlusion: rays.ambient_occlusion,
                diffuse: rays.diffuse,
            },
        }
    }
}
