//! Particle files. The format is told by content, never by the file's ending.
//!
//! To add a format: one file beside these with `fn detect(bytes) -> bool` and
//! `fn read(bytes, frame) -> Result<Parsed, ParseError>`, its `mod` line, and one line in the
//! [`Format`] table. Readers get the whole decompressed content in memory and must never allocate by
//! a number that stands in the file without holding it against the bytes that are really there.

pub mod error;
mod atom_names;
mod atoms;
mod bgeo;
mod bgeo_write;
mod bytes;
mod csv;
mod csv_write;
mod foreign;
mod geo;
mod gro;
mod gzip;
mod mmcif;
mod npy;
mod npy_write;
mod npz;
mod pdb;
mod ply;
mod ply_write;
mod raw_xyz;
mod table;
#[cfg(test)]
mod tests_support;
mod text;
mod vtk_legacy;
mod vtk_values;
mod vtk_xml;
mod write;
mod vtk_write;
mod xyz;
mod xyz_write;

pub use error::{ParseError, Place, ReadError};
pub use write::{WRITTEN_ENDINGS, WriteError, can_write, write};

use super::Particles;
use std::path::Path;

/// What a reader found in the bytes of one file.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Parsed {
    /// The particles of the frame asked for.
    pub particles: Particles,
    /// How many frames (time steps) the file holds.
    pub frames: usize,
    /// Rows of the frame that are no particles: further locations of an atom, sites without one.
    pub left_out: usize,
    /// What a user should know, one sentence each.
    pub warnings: Vec<String>,
}

/// A particle file as [`read`] gives it.
#[derive(Debug, Clone, PartialEq)]
pub struct ParticleFile {
    /// The particles of the frame asked for.
    pub particles: Particles,
    /// What the content turned out to be.
    pub format: Format,
    /// How many frames (time steps) the file holds.
    pub frames: usize,
    /// Rows of the frame that are no particles: further locations of an atom, sites without one.
    pub left_out: usize,
    /// What a user should know, one sentence each.
    pub warnings: Vec<String>,
}

macro_rules! formats {
    ($($variant:ident $module:ident $name:literal $description:literal;)*) => {
        /// The formats that we read, in the order in which detection asks them: those with an
        /// unmistakable start first.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        pub enum Format {
            $(#[doc = $description] $variant,)*
        }

        impl Format {
            /// Every format, in the order of detection.
            pub const ALL: &'static [Self] = &[$(Self::$variant,)*];

            /// Short name, as `info` prints it.
            pub fn name(self) -> &'static str {
                match self { $(Self::$variant => $name,)* }
            }

            /// What the format is and which endings it usually has.
            pub fn description(self) -> &'static str {
                match self { $(Self::$variant => $description,)* }
            }

            /// The format of some (decompressed) content.
            pub fn detect(bytes: &[u8]) -> Option<Self> {
                $(if $module::detect(bytes) {
                    return Some(Self::$variant);
                })*
                None
            }

            fn read(self, bytes: &[u8], frame: usize) -> Result<Parsed, ParseError> {
                match self { $(Self::$variant => $module::read(bytes, frame),)* }
            }
        }
    };
}
formats! {
    Ply ply "ply" "Polygon File Format, Stanford PLY, ascii or binary (.ply)";
    VtkLegacy vtk_legacy "vtk" "VTK legacy, ascii or binary, versions 1.0 to 5.1 (.vtk)";
    VtkXml vtk_xml "vtk-xml" "VTK XML, ascii, base64 or appended, compressed or not (.vtu .vtp .vts)";
    Bgeo bgeo "bgeo" "Houdini's classic binary geometry, version 5 (.bgeo)";
    Geo geo "geo" "Houdini's classic text geometry, version 5 (.geo)";
    Npy npy "npy" "NumPy array (n, 3) or with named fields (.npy)";
    Npz npz "npz" "NumPy archive with an array of positions and one array per column (.npz)";
    Pdb pdb "pdb" "Protein Data Bank text, models as frames (.pdb, .ent)";
    Mmcif mmcif "mmcif" "macromolecular CIF, models as frames (.cif, .mmcif)";
    Gro gro "gro" "GROMACS text coordinates in nm, several frames (.gro)";
    Csv csv "csv" "text table with a header, separated by commas, semicolons or tabs (.csv, .tsv)";
    Xyz xyz "xyz" "XYZ text, plain or extended, several frames, or bare rows of numbers (.xyz)";
    RawXyz raw_xyz "raw-xyz" "raw little-endian f32 x y z triples without a header (.xyz of splashsurf)";
}

impl Format {
    /// Whether its particles are atoms with van der Waals radii, which decides what settings a
    /// surface starts from.
    pub fn is_molecule(self) -> bool {
        matches!(self, Self::Pdb | Self::Mmcif | Self::Gro)
    }

    /// Reads frame `frame` (from 0) of content that is not compressed as this format, whatever it
    /// looks like.
    ///
    /// # Errors
    /// When the content is not of this format, is damaged, or has no such frame.
    pub fn parse(self, bytes: &[u8], frame: usize) -> Result<Parsed, ParseError> {
        let parsed = self.read(bytes, frame)?;
        if frame >= parsed.frames.max(1) {
            return Err(no_such_frame(frame, parsed.frames));
        }
        Ok(parsed)
    }
}

impl std::fmt::Display for Format {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

/// Reads frame `frame` (from 0) of a particle file in any known format, gzip-compressed or not.
///
/// Memory stays within a small multiple of the file's size. Compressed files may unfold to at most
/// 128 MiB plus 32 times their compressed size; beyond that they are refused (a simulation frame
/// rarely compresses tenfold, a "gzip bomb" thousandfold).
///
/// NaN and infinite positions are kept as they stand in the file.
///
/// # Errors
/// When the file cannot be read, is of no known format, is damaged, or has no such frame.
pub fn read(path: &Path, frame: usize) -> Result<ParticleFile, ReadError> {
    let bytes = std::fs::read(path).map_err(|source| ReadError::Io {
        path: path.to_owned(),
        source,
    })?;
    match parse_content(bytes.into(), frame) {
        Ok((format, parsed)) => Ok(ParticleFile {
            particles: parsed.particles,
            format,
            frames: parsed.frames,
            left_out: parsed.left_out,
            warnings: parsed.warnings,
        }),
        Err(Failure {
            format: Some(format),
            error,
        }) => Err(ReadError::Malformed {
            path: path.to_owned(),
            format,
            error,
        }),
        Err(Failure {
            format: None,
            error,
        }) => Err(ReadError::Unknown {
            path: path.to_owned(),
            problem: error.problem,
        }),
    }
}

/// As [`read`], from the bytes of a file in memory.
///
/// # Errors
/// As [`read`]; the error does not know a path.
pub fn parse(bytes: &[u8], frame: usize) -> Result<(Format, Parsed), ParseError> {
    parse_content(bytes.into(), frame).map_err(|failure| failure.error)
}

/// An error and, where it is known, the format in which it arose.
struct Failure {
    format: Option<&'static str>,
    error: ParseError,
}

fn parse_content(
    content: std::borrow::Cow<'_, [u8]>,
    frame: usize,
) -> Result<(Format, Parsed), Failure> {
    let mut warnings = Vec::new();
    let content = if gzip::detect(&content) {
        let unfolded = gzip::unfold(&content).map_err(|error| Failure {
            format: Some("gzip"),
            error,
        })?;
        warnings.extend(unfolded.warning);
        unfolded.bytes.into()
    } else {
        content
    };
    if let Some(known) = foreign::recognise(&content) {
        let format = known.planned.then_some(known.name);
        return Err(Failure {
            format,
            error: known.error(),
        });
    }
    let format = Format::detect(&content).ok_or_else(|| Failure {
        format: None,
        error: ParseError::new(Place::Whole, foreign::describe(&content)),
    })?;
    let mut parsed = format.parse(&content, frame).map_err(|error| Failure {
        format: Some(format.name()),
        error,
    })?;
    warnings.append(&mut parsed.warnings);
    parsed.warnings = warnings;
    Ok((format, parsed))
}

/// The error for a frame number beyond the end of the file.
fn no_such_frame(frame: usize, frames: usize) -> ParseError {
    ParseError::new(
        Place::Whole,
        format!("holds {frames} frame(s), number {frame} (from 0) was asked for"),
    )
}
