//! Mesh files. The format is told by content, never by the file's ending.
//!
//! To add a format: a file beside these with `fn detect(bytes) -> bool` and
//! `fn read(bytes, folder) -> Result<Parts, Problem>`, and a line in the [`MeshFormat`] table.

mod gltf;
mod obj;
mod ply;
#[cfg(test)]
mod tests;

use super::{MeshProblem, TriangleMesh};
use glam::{DVec3, Vec3};
use std::path::{Path, PathBuf};

/// What a reader found.
#[derive(Debug, Default)]
struct Parts {
    positions: Vec<DVec3>,
    /// One per position, or none.
    normals: Vec<Vec3>,
    /// Corners of all polygons, one after the other.
    corners: Vec<u64>,
    /// Number of corners of each polygon.
    sizes: Vec<u32>,
    warnings: Vec<String>,
}

/// What is wrong with the bytes of a file, and what to do.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Problem {
    text: String,
    help: Option<&'static str>,
}

impl Problem {
    fn new(text: impl Into<String>) -> Self {
        Self {
            text: text.into(),
            help: None,
        }
    }

    fn with_help(mut self, help: &'static str) -> Self {
        self.help = Some(help);
        self
    }
}

/// A mesh as a file gives it.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshFile {
    /// The triangles.
    pub mesh: TriangleMesh,
    /// What the content turned out to be.
    pub format: MeshFormat,
    /// What a user should know, one sentence each.
    pub warnings: Vec<String>,
}

/// A mesh file that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum MeshError {
    /// The file cannot be opened or read.
    #[error("cannot read {path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// The content is of no format that we read.
    #[error("{path} is no mesh that we know; read are {known}")]
    Unknown {
        /// The file.
        path: PathBuf,
        /// The formats.
        known: String,
    },
    /// The content is damaged, or not what we can use.
    #[error("{path}: {format} mesh: {problem}{}", help.map(|help| format!(" ({help})")).unwrap_or_default())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// The format's name.
        format: &'static str,
        /// What is wrong.
        problem: String,
        /// What to do.
        help: Option<&'static str>,
    },
}

macro_rules! formats {
    ($($variant:ident $module:ident $name:literal $description:literal;)*) => {
        /// The mesh formats that we read, in the order in which detection asks them.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        pub enum MeshFormat {
            $(#[doc = $description] $variant,)*
        }

        impl MeshFormat {
            /// Every format, in the order of detection.
            pub const ALL: &'static [Self] = &[$(Self::$variant,)*];

            /// Short name.
            pub fn name(self) -> &'static str {
                match self { $(Self::$variant => $name,)* }
            }

            /// The format of some content.
            pub fn detect(bytes: &[u8]) -> Option<Self> {
                $(if $module::detect(bytes) {
                    return Some(Self::$variant);
                })*
                None
            }

            fn read(self, bytes: &[u8], folder: &Path) -> Result<Parts, Problem> {
                match self { $(Self::$variant => $module::read(bytes, folder),)* }
            }
        }
    };
}
formats! {
    Ply ply "ply" "Polygon File Format, Stanford PLY with faces, ascii or binary (.ply)";
    Gltf gltf "gltf" "glTF 2.0, binary or JSON (.glb, .gltf)";
    Obj obj "obj" "Wavefront OBJ (.obj)";
}

/// Reads a mesh file. Materials, colours and textures in it are ignored.
///
/// # Errors
/// When the file cannot be read, is of no known format, is damaged, or holds no usable triangle.
pub fn read(path: &Path) -> Result<MeshFile, MeshError> {
    let bytes = std::fs::read(path).map_err(|source| MeshError::Io {
        path: path.to_owned(),
        source,
    })?;
    let Some(format) = MeshFormat::detect(&bytes) else {
        let names: Vec<&str> = MeshFormat::ALL.iter().map(|format| format.name()).collect();
        return Err(MeshError::Unknown {
            path: path.to_owned(),
            known: names.join(", "),
        });
    };
    let folder = path.parent().unwrap_or(Path::new(""));
    parse(format, &bytes, folder).map_err(|problem| MeshError::Malformed {
        path: path.to_owned(),
        format: format.name(),
        problem: problem.text,
        help: problem.help,
    })
}

fn parse(format: MeshFormat, bytes: &[u8], folder: &Path) -> Result<MeshFile, Problem> {
    let Parts {
        positions,
        normals,
        corners,
        sizes,
        mut warnings,
    } = format.read(bytes, folder)?;
    let mut rest = &corners[..];
    let polygons = sizes.iter().map(|&size| {
        let (polygon, after) = rest.split_at((size as usize).min(rest.len()));
        rest = after;
        polygon
    });
    let (mesh, degenerate) =
        TriangleMesh::from_polygons(positions, normals, polygons).map_err(|problem| {
            let help = match &problem {
                MeshProblem::Empty { .. } => Some("a cloud of points belongs into a [[surface]]"),
                MeshProblem::Index { .. } | MeshProblem::NotFinite { .. } => {
                    Some("the file is damaged; export it again")
                }
                MeshProblem::TooLarge { .. } | MeshProblem::Degenerate { .. } => None,
            };
            Problem {
                text: problem.to_string(),
                help,
            }
        })?;
    if degenerate > 0 {
        warnings.push(format!(
            "{degenerate} degenerate triangles were left out (two corners in one point, or all on a \
             line)"
        ));
    }
    Ok(MeshFile {
        mesh,
        format,
        warnings,
    })
}
