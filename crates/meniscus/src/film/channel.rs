//! The closed list of channels: what a picture can hold beside colour, under which names.
//!
//! A new channel is one new row of [`CHANNELS`] (and, if the sample does not carry its value yet,
//! one field of [`SurfaceSample`]).

use thiserror::Error;

/// Value of `id` and `surface` where nothing was hit.
pub const NO_INDEX: u32 = u32::MAX;

/// What one sample saw on the surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceSample {
    /// Distance from the eye along the view axis, in world units.
    pub depth: f32,
    /// World position.
    pub position: [f32; 3],
    /// Unit outward normal, world space.
    pub normal: [f32; 3],
    /// Way of the surface across the film while the shutter is open, in pixels to the right and down.
    pub motion: [f32; 2],
    /// Mean and Gaussian curvature, positive where the surface bulges outwards; 1/length, 1/length².
    pub curvature: [f32; 2],
    /// Row of the strongest particle in its file; [`NO_INDEX`] on other geometry.
    pub id: u32,
    /// Index of the instance in the frame.
    pub surface: u32,
}

/// What one sample contributes to its pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PixelSample<'a> {
    /// Linear Rec. 709 radiance, premultiplied by coverage (and with the sky, if that is asked for).
    pub radiance: [f32; 3],
    /// 1 where a surface was hit, else 0.
    pub coverage: f32,
    /// Share of the background that shows: 1 where nothing was hit, and in between where a surface
    /// fades into the background.
    pub backdrop: f32,
    /// Diffuse reflectance of what was hit; 0 where nothing was.
    pub albedo: [f32; 3],
    /// What a denoiser may take for the colour of the surface, without light: `albedo`, and white
    /// where light goes through.
    pub denoising_albedo: [f32; 3],
    /// What was hit.
    pub surface: Option<SurfaceSample>,
    /// Attributes at the hit, all components of all attributes of the frame in its order; may be
    /// empty where nothing was hit.
    pub attributes: &'a [f32],
}

/// Number type of a channel in files.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Storage {
    /// 16-bit float.
    Half,
    /// 32-bit float.
    Float,
    /// 32-bit unsigned integer.
    Uint,
}

/// Where a channel's numbers come from.
#[derive(Debug, Clone, Copy)]
pub enum Source {
    /// Mean over the samples of a pixel.
    Mean(fn(&PixelSample<'_>) -> [f32; 4]),
    /// The sample nearest the pixel centre; 0 where it hit nothing.
    Nearest(fn(&SurfaceSample) -> [f32; 3]),
    /// As `Nearest`, but infinite where it hit nothing.
    NearestOrInfinite(fn(&SurfaceSample) -> f32),
    /// An index from the sample nearest the pixel centre; [`NO_INDEX`] where it hit nothing.
    NearestIndex(fn(&SurfaceSample) -> u32),
    /// How many samples the pixel holds.
    SampleCount,
}

/// One channel: its name in `--aov`, its planes in files, and where its numbers come from.
#[derive(Debug)]
pub struct ChannelInfo {
    /// Name in flags.
    pub name: &'static str,
    /// Names of its planes in plain style.
    pub planes: &'static [&'static str],
    /// Names of its planes in Blender style, without the leading `ViewLayer.`.
    pub blender_planes: &'static [&'static str],
    /// Number type in files.
    pub storage: Storage,
    /// Whether every picture has it.
    pub always: bool,
    /// Whether `all` means it, too.
    pub in_all: bool,
    /// Where its numbers come from.
    pub source: Source,
}

/// Every channel that exists, in the order of files.
pub static CHANNELS: &[ChannelInfo] = &[
    ChannelInfo {
        name: "color",
        planes: &["R", "G", "B", "A"],
        blender_planes: &["Combined.R", "Combined.G", "Combined.B", "Combined.A"],
        storage: Storage::Half,
        always: true,
        in_all: true,
        source: Source::Mean(|s| [s.radiance[0], s.radiance[1], s.radiance[2], s.coverage]),
    },
    ChannelInfo {
        name: "depth",
        planes: &["Z"],
        blender_planes: &["Depth.Z"],
        storage: Storage::Float,
        always: true,
        in_all: true,
        source: Source::NearestOrInfinite(|s| s.depth),
    },
    ChannelInfo {
        name: "position",
        planes: &["P.X", "P.Y", "P.Z"],
        blender_planes: &["Position.X", "Position.Y", "Position.Z"],
        storage: Storage::Float,
        always: false,
        in_all: true,
        source: Source::Nearest(|s| s.position),
    },
    ChannelInfo {
        name: "normal",
        planes: &["N.X", "N.Y", "N.Z"],
        blender_planes: &["Normal.X", "Normal.Y", "Normal.Z"],
        storage: Storage::Float,
        always: false,
        in_all: true,
        source: Source::Nearest(|s| s.normal),
    },
    ChannelInfo {
        name: "albedo",
        planes: &["albedo.R", "albedo.G", "albedo.B"],
        blender_planes: &["DiffCol.R", "DiffCol.G", "DiffCol.B"],
        storage: Storage::Half,
        always: false,
        in_all: true,
        source: Source::Mean(|s| [s.albedo[0], s.albedo[1], s.albedo[2], 0.0]),
    },
    ChannelInfo {
        name: MOTION,
        planes: &["motion.X", "motion.Y"],
        blender_planes: &["Vector.X", "Vector.Y"],
        storage: Storage::Float,
        always: false,
        in_all: true,
        source: Source::Nearest(|s| [s.motion[0], s.motion[1], 0.0]),
    },
    ChannelInfo {
        name: "id",
        planes: &["id"],
        blender_planes: &["ParticleId.X"],
        storage: Storage::Uint,
        always: false,
        in_all: true,
        source: Source::NearestIndex(|s| s.id),
    },
    ChannelInfo {
        name: "surface",
        planes: &["surface"],
        blender_planes: &["IndexOB.X"],
        storage: Storage::Uint,
        always: false,
        in_all: true,
        source: Source::NearestIndex(|s| s.surface),
    },
    ChannelInfo {
        name: CURVATURE,
        planes: &["curvature.mean", "curvature.gaussian"],
        blender_planes: &["Curvature.X", "Curvature.Y"],
        storage: Storage::Float,
        always: false,
        in_all: true,
        source: Source::Nearest(|s| [s.curvature[0], s.curvature[1], 0.0]),
    },
    ChannelInfo {
        name: "samples",
        planes: &["samples"],
        blender_planes: &["Debug Sample Count.X"],
        storage: Storage::Float,
        always: false,
        in_all: true,
        source: Source::SampleCount,
    },
    ChannelInfo {
        name: "denoising_albedo",
        planes: &[
            "denoising_albedo.X",
            "denoising_albedo.Y",
            "denoising_albedo.Z",
        ],
        blender_planes: &[
            "Denoising Albedo.R",
            "Denoising Albedo.G",
            "Denoising Albedo.B",
        ],
        storage: Storage::Half,
        always: false,
        in_all: false,
        source: Source::Mean(|s| {
            let [red, green, blue] = s.denoising_albedo;
            [red, green, blue, 0.0]
        }),
    },
    ChannelInfo {
        name: "denoising_normal",
        planes: &[
            "denoising_normal.X",
            "denoising_normal.Y",
            "denoising_normal.Z",
        ],
        blender_planes: &[
            "Denoising Normal.X",
            "Denoising Normal.Y",
            "Denoising Normal.Z",
        ],
        storage: Storage::Half,
        always: false,
        in_all: false,
        source: Source::Mean(|s| {
            let [x, y, z] = s.surface.map_or([0.0; 3], |surface| surface.normal);
            [x, y, z, 0.0]
        }),
    },
];

/// The channel of [`SurfaceSample::motion`], which is found out only where it is wanted.
pub const MOTION: &str = "motion";
/// The channel of [`SurfaceSample::curvature`]; likewise.
pub const CURVATURE: &str = "curvature";

/// Why a channel cannot be had.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum ChannelError {
    /// Neither a channel nor an attribute that the surface carries.
    #[error(
        "there is no channel or attribute '{name}'; channels: {known}; attributes: {attributes}"
    )]
    Unknown {
        /// What was asked for.
        name: String,
        /// The channels.
        known: String,
        /// The attributes.
        attributes: String,
    },
}

/// How planes are named in files.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum AovStyle {
    /// `R`, `Z`, `P.X`, …: flat names that Nuke, ImageMagick and scripts read.
    #[default]
    Plain,
    /// `ViewLayer.Combined.R`, `ViewLayer.Depth.Z`, …: Blender shows them as render passes of one
    /// view layer.
    Blender,
}

/// An attribute that the frame can evaluate on a surface.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct AttributeInfo {
    /// The column's name.
    pub name: String,
    /// Numbers per point.
    pub components: usize,
    /// Index of the first number in [`PixelSample::attributes`].
    pub offset: usize,
}

/// One plane of a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Plane {
    /// Full name.
    pub name: String,
    /// Number type in the file.
    pub storage: Storage,
}

/// The channels of one picture.
#[derive(Debug, Clone)]
pub struct ChannelSet {
    channels: Vec<&'static ChannelInfo>,
    attributes: Vec<AttributeInfo>,
}

impl Default for ChannelSet {
    /// Those that every picture has: R G B A Z.
    fn default() -> Self {
        Self {
            channels: CHANNELS.iter().filter(|channel| channel.always).collect(),
            attributes: Vec::new(),
        }
    }
}

impl PartialEq for ChannelSet {
    fn eq(&self, other: &Self) -> bool {
        let names = |set: &Self| set.channels.iter().map(|c| c.name).collect::<Vec<_>>();
        names(self) == names(other) && self.attributes == other.attributes
    }
}

impl ChannelSet {
    /// The channels that every picture has and those in `wanted`: names of [`CHANNELS`], names of
    /// `attributes` (name and components, in the frame's order), or `all` for whatever exists but what
    /// denoisers alone look at.
    ///
    /// # Errors
    /// A name that is neither, or a channel that this version cannot render: never silently absent.
    pub fn new(
        wanted: &[impl AsRef<str>],
        attributes: &[(String, usize)],
    ) -> Result<Self, ChannelError> {
        let mut offset = 0;
        let offered: Vec<AttributeInfo> = attributes
            .iter()
            .map(|(name, components)| {
                offset += components;
                AttributeInfo {
                    name: name.clone(),
                    components: *components,
                    offset: offset - components,
                }
            })
            .collect();
        let known = || {
            CHANNELS
                .iter()
                .map(|c| c.name)
                .collect::<Vec<_>>()
                .join(", ")
        };
        let mut with_channel: Vec<bool> = CHANNELS.iter().map(|c| c.always).collect();
        let mut with_attribute = vec![false; offered.len()];
        for name in wanted.iter().map(|name| name.as_ref().trim()) {
            if name == "all" {
                for (with, channel) in with_channel.iter_mut().zip(CHANNELS) {
                    *with |= channel.in_all;
                }
                with_attribute.fill(true);
            } else if let Some(i) = CHANNELS.iter().position(|c| c.name == name) {
                with_channel[i] = true;
            } else if let Some(i) = offered.iter().position(|a| a.name == name) {
                with_attribute[i] = true;
            } else {
                let names: Vec<&str> = offered.iter().map(|a| a.name.as_str()).collect();
                return Err(ChannelError::Unknown {
                    name: name.to_owned(),
                    known: known(),
                    attributes: if names.is_empty() {
                        "none carried (name them with -a)".to_owned()
                    } else {
                        names.join(", ")
                    },
                });
            }
        }
        let keep = |flags: &[bool], i: usize| flags[i];
        Ok(Self {
            channels: CHANNELS
                .iter()
                .enumerate()
                .filter(|(i, _)| keep(&with_channel, *i))
                .map(|(_, channel)| channel)
                .collect(),
            attributes: offered
                .into_iter()
                .enumerate()
                .filter(|(i, _)| keep(&with_attribute, *i))
                .map(|(_, attribute)| attribute)
                .collect(),
        })
    }

    /// The built-in channels, in file order.
    pub fn channels(&self) -> &[&'static ChannelInfo] {
        &self.channels
    }

    /// Whether a channel of this name is among them.
    pub fn has(&self, name: &str) -> bool {
        self.channels.iter().any(|channel| channel.name == name)
    }

    /// The attributes, in file order, after the built-in channels.
    pub fn attributes(&self) -> &[AttributeInfo] {
        &self.attributes
    }

    /// Every plane, in the order of [`super::Film::plane`].
    ///
    /// An attribute whose name a built-in plane already has gets the prefix `attribute.`.
    pub fn planes(&self, style: AovStyle) -> Vec<Plane> {
        let mut planes: Vec<Plane> = Vec::new();
        for channel in &self.channels {
            let names = match style {
                AovStyle::Plain => channel.planes,
                AovStyle::Blender => channel.blender_planes,
            };
            planes.extend(names.iter().map(|name| Plane {
                name: styled(name, style),
                storage: channel.storage,
            }));
        }
        let layers = |name: &str| -> bool {
            let layer = name.split('.').next().unwrap_or(name);
            CHANNELS
                .iter()
                .flat_map(|c| c.planes)
                .any(|plane| plane.split('.').next() == Some(layer))
        };
        for attribute in &self.attributes {
            let name = match style {
                AovStyle::Blender => attribute.name.replace('.', "_"),
                AovStyle::Plain if layers(&attribute.name) => {
                    format!("attribute.{}", attribute.name)
                }
                AovStyle::Plain => attribute.name.clone(),
            };
            for component in 0..attribute.components {
                let suffix = match (attribute.components, style) {
                    (1, AovStyle::Plain) => String::new(),
                    (1, AovStyle::Blender) => ".X".to_owned(),
                    (3, _) => [".X", ".Y", ".Z"][component].to_owned(),
                    _ => format!(".{component}"),
                };
                planes.push(Plane {
                    name: styled(&format!("{name}{suffix}"), style),
                    storage: Storage::Float,
                });
            }
        }
        planes
    }
}

fn styled(name: &str, style: AovStyle) -> String {
    match style {
        AovStyle::Plain => name.to_owned(),
        AovStyle::Blender => format!("ViewLayer.{name}"),
    }
}

#[cfg(test)]
mod tests;
