//! `meniscus render`.

use super::camera::CameraArgs;
use super::engine::EngineArgs;
use super::output::OutputArgs;
use super::surface::SurfaceArgs;
use super::values::{RegionArg, SampleRange, Setting, Size, ValueRange};
use clap::Args;
use std::path::PathBuf;

const EXAMPLES: &str = "\
Examples:
  meniscus render fluid.vtk -o fluid.png
  meniscus render fluid.vtk -o fluid.png --preset water --ground --size 1920x1080 --spp 64
  meniscus render 'frame_{}.vtk' -o film.mp4 --fps 25
  meniscus render 'frame_{}.vtk' -o 'frame_{}.png' --frames 1-100x2 --resume
  meniscus render fluid.vtk -o fluid.png --color-by velocity --color-range 0,3
  meniscus render fluid.vtk -o fluid.exr --aov all
  meniscus render scene.toml -o scene.png --set surface.0.threshold=0.5
  meniscus render fluid.vtk -o fluid.png --up z --light -1,2,3 --camera-eye -4,-3,2
  meniscus render 1ubq.pdb -o 1ubq.png --silhouettes --depth-shading --clip 'z<0'
  meniscus render 'frame_{}.vtk' -o slow.mp4 --slow-motion 8
  meniscus render 'frame_{}.vtk' -o 'frame_{}.png' --watch --resume
  meniscus render topology.pdb trajectory.xtc -o film.mp4
  meniscus render fluid.vtk -o turn.mp4 --turntable 100
  meniscus render fluid.vtk -o fluid.png --filter '|velocity| < 8 && y > -0.2'

A {} in INPUT stands for the frame number, and in OUT for the same number with the same padding
(put quotes around it). Options given here override those of a scene file.";

/// Options of `render`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct RenderArgs {
    /// Particle file, pattern such as 'frame_{}.vtk', or scene (.toml, .json); several particle files
    /// are the frames of one sequence; XTC, TRR and DCD trajectories follow a molecule file
    #[arg(required = true, value_name = "INPUT")]
    pub inputs: Vec<PathBuf>,
    /// Picture to write: .png or .exr; with several frames a pattern such as 'frame_{}.png', or .mp4
    /// (which takes the program ffmpeg)
    #[arg(short, long, value_name = "OUT")]
    pub output: PathBuf,

    /// Frames to render, as in 1-100, 1-100x2 or 1-10,20
    #[arg(long, value_name = "FRAMES", help_heading = "Frames")]
    pub frames: Option<String>,
    /// Skip the frames whose picture is there already. A film keeps its finished pictures in
    /// OUT.frames until it is whole, and goes on from them
    #[arg(long, help_heading = "Frames")]
    pub resume: bool,
    /// Frames per second of the sequence and of the film [default: 25]
    #[arg(
        long,
        value_name = "N",
        help_heading = "Frames",
        allow_hyphen_values = true
    )]
    pub fps: Option<f64>,
    /// This many pictures for each frame of the input, such as 4 or 2.5: particles are followed by
    /// their ids, along their velocities; those that come or go grow or shrink
    #[arg(
        long,
        value_name = "X",
        help_heading = "Frames",
        allow_hyphen_values = true
    )]
    pub slow_motion: Option<f64>,
    /// Factor on the particles' velocities, where their unit is another than the file's length per
    /// second (or per picosecond in a trajectory) [default: 1]
    #[arg(
        long,
        value_name = "X",
        help_heading = "Frames",
        allow_hyphen_values = true
    )]
    pub velocity_scale: Option<f64>,
    /// Wait for the frames of a running simulation and render each once it is written; Ctrl-C ends it,
    /// and finishes the film
    #[arg(long, help_heading = "Frames")]
    pub watch: bool,
    /// End when no new frame has come for this long
    #[arg(
        long,
        value_name = "SECS",
        help_heading = "Frames",
        allow_hyphen_values = true
    )]
    pub watch_timeout: Option<f64>,
    /// Shutter time as a fraction of the frame interval [default: 0]
    #[arg(
        long,
        value_name = "X",
        help_heading = "Frames",
        allow_hyphen_values = true
    )]
    pub shutter: Option<f64>,
    /// Turn the camera once around the object in N pictures, numbered from 0; OUT needs a {}, or is
    /// .mp4. Of a single still, --frames chooses among them
    #[arg(long, value_name = "N", help_heading = "Frames")]
    pub turntable: Option<u32>,

    /// Pixels [default: 1280x720]
    #[arg(
        long,
        value_name = "WxH",
        help_heading = "Picture",
        allow_hyphen_values = true
    )]
    pub size: Option<Size>,
    /// Samples per pixel; 1 samples pixel centres [default: 16]
    #[arg(
        long,
        value_name = "N",
        help_heading = "Picture",
        allow_hyphen_values = true
    )]
    pub spp: Option<u32>,
    /// Sample until this little noise is left, relative to brightness, as in 0.02; --spp is the most
    /// then [default with --noise: 1024]
    #[arg(
        long,
        value_name = "X",
        help_heading = "Picture",
        allow_hyphen_values = true
    )]
    pub noise: Option<f64>,
    /// Sample for about this many seconds; --spp is the most
    #[arg(
        long,
        value_name = "SECS",
        help_heading = "Picture",
        allow_hyphen_values = true
    )]
    pub time_limit: Option<f64>,
    /// Take the noise out of the finished picture (Open Image Denoise)
    #[arg(long, help_heading = "Picture")]
    pub denoise: bool,
    /// Render only this part, in pixels from the top left corner
    #[arg(
        long,
        value_name = "x,y,w,h",
        help_heading = "Picture",
        allow_hyphen_values = true
    )]
    pub region: Option<RegionArg>,
    /// Take only these samples of each pixel, counted from 0, as in 0-7
    #[arg(
        long,
        value_name = "a-b",
        help_heading = "Picture",
        allow_hyphen_values = true
    )]
    pub samples: Option<SampleRange>,
    /// What is behind the object: sky, transparent or #rrggbb [default: sky for PNG, transparent for
    /// EXR]
    #[arg(long, value_name = "B", help_heading = "Picture")]
    pub background: Option<String>,
    /// Put a ground plane under the object
    #[arg(long, help_heading = "Picture")]
    pub ground: bool,
    /// Bits per channel of a PNG: 8 or 16 [default: 8]
    #[arg(
        long,
        value_name = "BITS",
        help_heading = "Picture",
        default_value = "8",
        hide_default_value = true
    )]
    pub png_depth: u8,

    /// How light is gathered: shaded (a fast look), whitted (mirrors and refraction with hard
    /// shadows), ao (ambient occlusion) or path (path tracing) [default: shaded]
    #[arg(long, value_name = "NAME", help_heading = "Look")]
    pub integrator: Option<String>,
    /// A look under one name: water, milk, honey, mercury (these with --integrator path), molecule,
    /// clay, preview
    #[arg(long, value_name = "NAME", help_heading = "Look")]
    pub preset: Option<String>,
    /// Colour by a column: a number, a vector's magnitude, or a component such as velocity.y; by
    /// element (atoms), or color (the file's own)
    #[arg(
        long,
        value_name = "NAME",
        help_heading = "Look",
        allow_hyphen_values = true
    )]
    pub color_by: Option<String>,
    /// Colour map [default: viridis]
    #[arg(long, value_name = "NAME", help_heading = "Look")]
    pub color_map: Option<String>,
    /// Values at the two ends of the colour map, the same in all frames [default: of each frame]
    #[arg(
        long,
        value_name = "a,b",
        help_heading = "Look",
        allow_hyphen_values = true
    )]
    pub color_range: Option<ValueRange>,

    /// Dark lines where things end or turn away, 0 to 1; as --silhouettes=0.5 [default: 0, alone: 1]
    #[arg(
        long,
        value_name = "X",
        help_heading = "Look",
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "1"
    )]
    pub silhouettes: Option<f64>,
    /// Darken what lies behind something near (unsharp masking of the depth); as
    /// --depth-shading=0.5 [default: 0, alone: 1]
    #[arg(
        long,
        value_name = "X",
        help_heading = "Look",
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "1"
    )]
    pub depth_shading: Option<f64>,

    /// Channels of an EXR beside RGBA and Z: all, or of depth, position, normal, albedo, id, surface,
    /// samples and names of columns
    #[arg(
        long,
        value_name = "LIST",
        help_heading = "Files",
        value_delimiter = ','
    )]
    pub aov: Vec<String>,
    /// Names of the channels: plain or blender [default: plain]
    #[arg(long, value_name = "STYLE", help_heading = "Files")]
    pub aov_style: Option<String>,
    /// Write times, counts and settings as JSON
    #[arg(long, value_name = "FILE.json", help_heading = "Files")]
    pub stats: Option<PathBuf>,
    /// Set any key of the scene, as in surface.0.threshold=0.5 (repeatable)
    #[arg(
        long = "set",
        value_name = "key.path=value",
        help_heading = "Files",
        allow_hyphen_values = true
    )]
    pub settings: Vec<Setting>,

    /// Surface options.
    #[command(flatten)]
    pub surface: SurfaceArgs,
    /// Camera options.
    #[command(flatten)]
    pub camera: CameraArgs,
    /// Engine options.
    #[command(flatten)]
    pub engine: EngineArgs,
    /// Message options.
    #[command(flatten)]
    pub messages: OutputArgs,
}
