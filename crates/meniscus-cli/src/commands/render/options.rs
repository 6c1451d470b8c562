//! The options of `render`, checked and applied to scenes.

use crate::args::render::RenderArgs;
use crate::exit::{Failure, Outcome};
use crate::job::output::{PictureFormat, without_number};
use crate::job::scene::{apply_camera, apply_settings, apply_surface, scene_failure};
use crate::progress::Reporter;
use meniscus::film::{AovStyle, BitDepth, CHANNELS, Film, Region};
use meniscus::particles::sequence::{FrameSelection, is_pattern};
use meniscus::scene::film::MAX_SPP;
use meniscus::scene::{Background, ColorMap, Ground, IntegratorKind, Preset, Scene};
use std::ops::Range;
use std::path::PathBuf;
use std::time::Duration;

/// What decides about the file of a picture rather than about the scene.
#[derive(Debug)]
pub(crate) struct PictureOptions {
    /// Kind of file.
    pub format: PictureFormat,
    /// Channels asked for.
    pub aov: Vec<String>,
    /// Their names.
    pub style: AovStyle,
    /// Bits of a PNG.
    pub depth: BitDepth,
    /// Part of the picture.
    pub region: Option<Region>,
    /// Samples of each pixel.
    pub samples: Option<Range<u32>>,
    /// When to stop adding samples.
    pub time_limit: Option<Duration>,
    /// Frames per second of a film, where the command line says; else the scene does.
    pub fps: Option<f64>,
    /// Pictures for each frame of the input, where there are more than one.
    pub slow_motion: Option<f64>,
    /// Longest wait for the next frame of a running simulation.
    pub watch_timeout: Option<Duration>,
    /// Whether the noise is taken out at the end.
    pub denoise: bool,
    /// The one legend of a sequence whose colour range is fixed; else each picture has its own.
    pub shared_legend: Option<PathBuf>,
}

impl PictureOptions {
    /// Checks the options.
    pub(crate) fn new(
        args: &RenderArgs,
        format: PictureFormat,
        reporter: &Reporter,
    ) -> Outcome<Self> {
        refuse_what_is_to_come(args)?;
        check_denoise(args)?;
        if format != PictureFormat::Exr && !args.aov.is_empty() {
            return Err(
                Failure::wrong("--aov needs an EXR: PNG and MP4 hold colour alone")
                    .with_help("write the picture as .exr"),
            );
        }
        if format != PictureFormat::Exr && args.aov_style.is_some() {
            return Err(
                Failure::wrong("--aov-style needs an EXR").with_help("write the picture as .exr")
            );
        }
        let is_film = format == PictureFormat::Mp4;
        check_kinds_of_sequence(args, format)?;
        check_velocity_scale(args, reporter)?;
        let has_time = args.slow_motion.is_some() || args.shutter.is_some();
        if args.fps.is_some() && !is_film && !has_time {
            reporter.warn("--fps changes nothing: pictures without shutter time have no speed");
        }
        if is_film && args.png_depth != 8 {
            return Err(Failure::wrong("--png-depth needs a PNG: films have 8 bits"));
        }
        if is_film && args.color_by.is_some() && args.color_range.is_none() {
            reporter.warn(
                "colours are spread over each frame's own values, so they flicker; \
                 --color-range fixes them",
            );
        }
        let is_one_of_many = is_film || is_pattern(&args.output);
        let fixed_range = args.color_range.is_some() && is_one_of_many;
        Ok(Self {
            format,
            aov: args.aov.clone(),
            style: match args.aov_style.as_deref() {
                None | Some("plain") => AovStyle::Plain,
                Some("blender") => AovStyle::Blender,
                Some(other) => {
                    return Err(Failure::wrong(format!("there is no --aov-style `{other}`"))
                        .with_help("there are: plain, blender"));
                }
            },
            depth: match args.png_depth {
                8 => BitDepth::Eight,
                16 => BitDepth::Sixteen,
                other => {
                    return Err(Failure::wrong(format!(
                        "--png-depth {other}: a PNG has 8 or 16 bits"
                    )));
                }
            },
            region: args.region.map(|region| {
                let [x, y, width, height] = region.0;
                Region {
                    x,
                    y,
                    width,
                    height,
                }
            }),
            samples: args
                .samples
                .map(|range| range.first..range.last.saturating_add(1)),
            time_limit: args.time_limit.map(time_limit).transpose()?,
            fps: args.fps.map(checked_fps).transpose()?,
            slow_motion: args.slow_motion,
            watch_timeout: watch_timeout(args)?,
            denoise: args.denoise,
            shared_legend: fixed_range.then(|| without_number(&args.output)),
        })
    }
}

/// Most frames per second that make sense.
const MAX_FPS: f64 = 1000.0;

fn checked_fps(fps: f64) -> Outcome<f64> {
    if fps > 0.0 && fps <= MAX_FPS {
        return Ok(fps);
    }
    Err(Failure::wrong(format!(
        "--fps must be a number above 0 and up to {MAX_FPS}, not {fps}"
    )))
}

/// One picture cannot belong to two kinds of sequence.
fn check_kinds_of_sequence(args: &RenderArgs, format: PictureFormat) -> Outcome {
    let kinds = [
        ("--turntable", args.turntable.is_some()),
        ("--slow-motion", args.slow_motion.is_some()),
        ("--watch", args.watch),
    ];
    let given: Vec<&str> = kinds
        .iter()
        .filter(|kind| kind.1)
        .map(|kind| kind.0)
        .collect();
    if let [first, second, ..] = given[..] {
        return Err(Failure::wrong(format!(
            "{first} and {second} do not go together"
        )));
    }
    if args.watch && format != PictureFormat::Mp4 && !is_pattern(&args.output) {
        return Err(Failure::wrong(format!(
            "--watch writes a picture for every frame, which cannot all go to {}",
            args.output.display()
        ))
        .with_help("put {} where the frame number goes, as in -o 'frame_{}.png', or write .mp4"));
    }
    Ok(())
}

/// Whether the noise can be taken out of the picture.
fn check_denoise(args: &RenderArgs) -> Outcome {
    if args.denoise && !Film::CAN_DENOISE {
        return Err(
            Failure::wrong("--denoise: this meniscus was built without Open Image Denoise").with_help(
                "get its library (https://www.openimagedenoise.org, or the folder pyoidn/oidn of \
                 `pip install pyoidn`), set OIDN_DIR to the folder that holds its lib, and build with \
                 --features oidn",
            ),
        );
    }
    if args.denoise && args.samples.is_some() {
        return Err(Failure::wrong(
            "--samples makes a part of a picture, --denoise finishes one: not both",
        ));
    }
    Ok(())
}

fn check_velocity_scale(args: &RenderArgs, reporter: &Reporter) -> Outcome {
    let scale = args.velocity_scale.unwrap_or(1.0);
    if !(scale.is_finite() && scale != 0.0) {
        return Err(Failure::wrong(format!(
            "--velocity-scale must be a number other than 0, not {scale}"
        )));
    }
    if args.velocity_scale.is_some() && args.slow_motion.is_none() && args.shutter.is_none() {
        reporter.warn("--velocity-scale changes nothing without --slow-motion or --shutter");
    }
    Ok(())
}

fn watch_timeout(args: &RenderArgs) -> Outcome<Option<Duration>> {
    let Some(secs) = args.watch_timeout else {
        return Ok(None);
    };
    if !args.watch {
        return Err(Failure::wrong("--watch-timeout needs --watch"));
    }
    match Duration::try_from_secs_f64(secs) {
        Ok(timeout) => Ok(Some(timeout)),
        Err(_) => Err(Failure::wrong(format!(
            "--watch-timeout must be a number of seconds, not {secs}"
        ))),
    }
}

fn time_limit(secs: f64) -> Outcome<Duration> {
    Duration::try_from_secs_f64(secs)
        .ok()
        .filter(|limit| !limit.is_zero())
        .ok_or_else(|| {
            Failure::wrong(format!(
                "--time-limit must be a positive number of seconds, not {secs}"
            ))
        })
}

/// Most samples of a pixel where --noise decides and --spp says nothing.
const MOST_ADAPTIVE_SAMPLES: u32 = 1024;

/// Flags that are announced and not there yet are answered, never ignored.
fn refuse_what_is_to_come(args: &RenderArgs) -> Outcome {
    let channels = || {
        CHANNELS
            .iter()
            .map(|channel| channel.name)
            .collect::<Vec<_>>()
            .join(", ")
    };
    for name in &args.aov {
        if ["motion", "curvature"].contains(&name.trim()) {
            let available = format!("all, {} and names of columns", channels());
            return Err(Failure::not_yet(&format!("--aov {name}"), &available));
        }
    }
    Ok(())
}

/// The frames asked for.
pub(crate) fn selection(args: &RenderArgs) -> Outcome<Option<FrameSelection>> {
    let parse = |text: &str| {
        text.parse()
            .map_err(|error: meniscus::particles::sequence::SelectionError| {
                Failure::wrong(format!("--frames: {error}"))
            })
    };
    args.frames.as_deref().map(parse).transpose()
}

/// Applies every option to a scene: single keys first, then the options of their own, and the preset
/// to what is still open.
pub(crate) fn edit_scene(args: &RenderArgs, format: PictureFormat, scene: &mut Scene) -> Outcome {
    apply_settings(&args.settings, scene)?;
    apply_surface(&args.surface, scene)?;
    apply_camera(&args.camera, scene)?;
    apply_look(args, scene)?;
    apply_integrator(args, scene)?;
    if let Some(size) = args.size {
        [scene.film.width, scene.film.height] = size.0;
    }
    if args.noise.is_some() {
        scene.film.noise = args.noise;
        scene.film.spp = scene.film.spp.max(MOST_ADAPTIVE_SAMPLES);
    } else if args.time_limit.is_some() {
        scene.film.spp = MAX_SPP;
    }
    let motion = &mut scene.motion;
    motion.shutter = args.shutter.unwrap_or(motion.shutter);
    motion.fps = args.fps.unwrap_or(motion.fps) * args.slow_motion.unwrap_or(1.0);
    motion.velocity_scale = args.velocity_scale.unwrap_or(motion.velocity_scale);
    if let Some(spp) = args.spp {
        scene.film.spp = spp;
    }
    if args.samples.is_some() && (scene.film.noise.is_some() || args.time_limit.is_some()) {
        return Err(Failure::wrong(
            "--samples names samples that every pixel gets: not with --noise or --time-limit",
        ));
    }
    let background = args.background.as_deref().map(background).transpose()?;
    if format == PictureFormat::Mp4 && background == Some(Background::Transparent) {
        return Err(Failure::wrong("a film cannot be transparent")
            .with_help("write pictures: -o 'frame_{}.png' or 'frame_{}.exr'"));
    }
    if format == PictureFormat::Mp4 && scene.film.background == Some(Background::Transparent) {
        scene.film.background = None;
    }
    scene.film.background = background.or(scene.film.background).or(match format {
        PictureFormat::Png | PictureFormat::Mp4 => Some(Background::Sky),
        PictureFormat::Exr => Some(Background::Transparent),
    });
    if args.ground {
        scene.ground.get_or_insert_with(Ground::default);
    }
    scene.validate().map_err(scene_failure)?;
    check_parts(args, scene)
}

fn background(text: &str) -> Outcome<Background> {
    text.parse()
        .map_err(|error: meniscus::scene::film::BackgroundError| {
            Failure::wrong(format!("--background: {error}"))
        })
}

fn apply_look(args: &RenderArgs, scene: &mut Scene) -> Outcome {
    let map = args.color_map.as_deref().map(|name| {
        ColorMap::from_name(name).ok_or_else(|| {
            let all = ColorMap::ALL.map(ColorMap::name).join(", ");
            Failure::wrong(format!("there is no colour map `{name}`"))
                .with_help(format!("there are: {all}"))
        })
    });
    let map = map.transpose()?;
    let mut is_colored = false;
    for surface in &mut scene.surfaces {
        if let Some(color_by) = &args.color_by {
            surface.color_by = Some(color_by.clone());
        }
        surface.color_map = map.or(surface.color_map);
        surface.color_range = args
            .color_range
            .map(|range| range.0)
            .or(surface.color_range);
        is_colored |= surface.color_by.is_some();
    }
    if !is_colored && (map.is_some() || args.color_range.is_some()) {
        return Err(
            Failure::wrong("--color-map and --color-range need something to colour by")
                .with_help("add --color-by and the name of a column"),
        );
    }
    scene.cues.silhouettes = args.silhouettes.unwrap_or(scene.cues.silhouettes);
    scene.cues.depth_shading = args.depth_shading.unwrap_or(scene.cues.depth_shading);
    let Some(name) = &args.preset else {
        return Ok(());
    };
    let preset = Preset::from_name(name).ok_or_else(|| {
        let all = Preset::ALL.map(|preset| preset.name).join(", ");
        Failure::wrong(format!("there is no preset `{name}`"))
            .with_help(format!("there are: {all}"))
    })?;
    preset.apply(scene);
    Ok(())
}

/// What the integrator is, over what a preset made of it.
fn apply_integrator(args: &RenderArgs, scene: &mut Scene) -> Outcome {
    let Some(name) = &args.integrator else {
        return Ok(());
    };
    scene.integrator.kind = IntegratorKind::from_name(name).ok_or_else(|| {
        let all = IntegratorKind::ALL.map(IntegratorKind::name).join(", ");
        Failure::wrong(format!("there is no integrator `{name}`"))
            .with_help(format!("there are: {all}"))
    })?;
    Ok(())
}

/// Region and sample range against the picture.
fn check_parts(args: &RenderArgs, scene: &Scene) -> Outcome {
    let [width, height] = [scene.film.width, scene.film.height];
    if let Some(region) = args.region {
        let [x, y, w, h] = region.0;
        let whole = Region::full(width, height);
        let part = Region {
            x,
            y,
            width: w,
            height: h,
        };
        if w == 0 || h == 0 || !whole.contains(&part) {
            return Err(Failure::wrong(format!(
                "--region {x},{y},{w},{h} is not within the picture of {width}x{height} pixels"
            )));
        }
    }
    if let Some(range) = args.samples
        && range.last >= scene.film.spp
    {
        return Err(Failure::wrong(format!(
            "--samples {}-{}: there are {} samples per pixel, 0-{}",
            range.first,
            range.last,
            scene.film.spp,
            scene.film.spp.saturating_sub(1)
        )));
    }
    Ok(())
}
