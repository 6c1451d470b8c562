//! Trajectories: files with the positions of the same atoms at many moments and nothing else about
//! them. A molecule file, the topology, says what the atoms are.
//!
//! A file is indexed when it is opened, by its frames' headers alone; a frame is read when it is asked
//! for. Lengths are ångström and times picoseconds here, whatever the file has.
//!
//! To add a format: a file beside these with `detect`, `index` and `decode`, and a row in
//! [`TrajectoryFormat`].

mod dcd;
mod source;
#[cfg(test)]
mod tests;
mod trr;
mod xtc;

use super::io::{Format, ParseError, ParticleFile, Place, ReadError};
use super::{Column, Particles};
use glam::DVec3;
use source::{Source, Trouble};
use std::path::{Path, PathBuf};

/// Ångströms in a nanometre.
const ANGSTROM_PER_NM: f64 = 10.0;
/// Bytes that tell what a file is.
const HEAD_BYTES: usize = 16;

/// The trajectory formats that we read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum TrajectoryFormat {
    /// GROMACS, compressed.
    Xtc,
    /// GROMACS, full precision, with velocities where they were written.
    Trr,
    /// CHARMM, NAMD and X-PLOR, either byte order.
    Dcd,
}

impl TrajectoryFormat {
    /// Every format.
    pub const ALL: [Self; 3] = [Self::Xtc, Self::Trr, Self::Dcd];

    /// Short name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Xtc => "xtc",
            Self::Trr => "trr",
            Self::Dcd => "dcd",
        }
    }

    /// The format of a file that starts with `head`.
    pub fn detect(head: &[u8]) -> Option<Self> {
        Self::ALL.into_iter().find(|format| match format {
            Self::Xtc => xtc::detect(head),
            Self::Trr => trr::detect(head),
            Self::Dcd => dcd::detect(head),
        })
    }
}

/// Where a frame lies in its file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Span {
    start: u64,
    bytes: u64,
}

/// What the headers of a file say.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Index {
    atoms: usize,
    frames: Vec<Span>,
    /// Bytes after the last whole frame, which a run that was stopped leaves behind.
    rest: u64,
    layout: Layout,
}

/// What a format needs to know to decode a frame.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Layout {
    Xtc,
    Trr,
    Dcd(dcd::Records),
}

/// The atoms at one moment.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct TrajectoryFrame {
    /// Positions in ångström, in the order of the topology.
    pub positions: Vec<DVec3>,
    /// Velocities in ångström per picosecond, where the file has them.
    pub velocities: Option<Vec<DVec3>>,
    /// The moment in picoseconds, where the file says.
    pub time_ps: Option<f64>,
}

/// An indexed trajectory file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Trajectory {
    path: PathBuf,
    format: TrajectoryFormat,
    index: Index,
}

impl Trajectory {
    /// The format of the file at `path`, if it is a trajectory.
    ///
    /// # Errors
    /// When the file cannot be read.
    pub fn detect(path: &Path) -> Result<Option<TrajectoryFormat>, ReadError> {
        let head = Source::open(path)
            .and_then(|mut source| source.head(HEAD_BYTES))
            .map_err(|source| ReadError::Io {
                path: path.to_owned(),
                source,
            })?;
        Ok(TrajectoryFormat::detect(&head))
    }

    /// Finds the frames of a file.
    ///
    /// # Errors
    /// When the file cannot be read, is of no known format, is damaged, changes its number of atoms,
    /// or has no whole frame.
    pub fn open(path: &Path) -> Result<Self, ReadError> {
        let unknown = || ReadError::Unknown {
            path: path.to_owned(),
            problem: "is no trajectory: neither XTC nor TRR nor DCD".to_owned(),
        };
        let format = Self::detect(path)?.ok_or_else(unknown)?;
        let failed = |trouble| failure(path, format, trouble);
        let mut source = Source::open(path).map_err(|error| failed(Trouble::Io(error)))?;
        let index = match format {
            TrajectoryFormat::Xtc => xtc::index(&mut source),
            TrajectoryFormat::Trr => trr::index(&mut source),
            TrajectoryFormat::Dcd => dcd::index(&mut source),
        };
        let index = index.map_err(failed)?;
        if index.frames.is_empty() {
            let problem = "holds no whole frame";
            return Err(failed(ParseError::new(Place::Whole, problem).into()));
        }
        Ok(Self {
            path: path.to_owned(),
            format,
            index,
        })
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Its format.
    pub fn format(&self) -> TrajectoryFormat {
        self.format
    }

    /// Atoms in every frame.
    pub fn atoms(&self) -> usize {
        self.index.atoms
    }

    /// How many frames there are; never 0.
    #[allow(
        clippy::len_without_is_empty,
        reason = "an open trajectory has a frame"
    )]
    pub fn len(&self) -> usize {
        self.index.frames.len()
    }

    /// What a user should know, a sentence each.
    pub fn warnings(&self) -> Vec<String> {
        let rest = self.index.rest;
        let is_cut = (rest > 0).then(|| {
            format!(
                "the last {rest} bytes are no whole frame and are left out; there are {} frames before",
                self.len()
            )
        });
        is_cut.into_iter().collect()
    }

    /// Reads frame `frame`, counted from 0.
    ///
    /// # Errors
    /// When the file cannot be read, the frame is damaged, or there is no such frame.
    pub fn read(&self, frame: usize) -> Result<TrajectoryFrame, ReadError> {
        let failed = |trouble| failure(&self.path, self.format, trouble);
        let span = *self.index.frames.get(frame).ok_or_else(|| {
            let problem = format!("holds {} frames, number {frame} was asked for", self.len());
            failed(ParseError::new(Place::Whole, problem).into())
        })?;
        let read = || -> Result<TrajectoryFrame, Trouble> {
            let mut source = Source::open(&self.path)?;
            let bytes = source.bytes(span)?;
            let atoms = self.index.atoms;
            let decoded = match &self.index.layout {
                Layout::Xtc => xtc::decode(&bytes, atoms),
                Layout::Trr => trr::decode(&bytes, atoms),
                Layout::Dcd(records) => {
                    let first = self.index.frames[0];
                    let fixed = match frame {
                        0 => None,
                        _ => records.fixed_from(first).map(|span| source.bytes(span)),
                    };
                    let fixed = fixed.transpose()?;
                    dcd::decode(&bytes, atoms, records, fixed.as_deref())
                }
            };
            decoded.map_err(|error| after(error, span.start).into())
        };
        read().map_err(failed)
    }

    /// Frame `frame` as particles: the columns of `topology`, the positions and velocities of the
    /// frame, both in the unit of the topology: nanometres over a GRO file, ångström over any other
    /// (and per picosecond). Columns `velocity` of the topology itself are left out: they belong to
    /// another moment.
    ///
    /// # Errors
    /// As [`Trajectory::read`], and when the numbers of atoms differ.
    pub fn over(
        &self,
        topology: &ParticleFile,
        frame: usize,
    ) -> Result<(Particles, Option<f64>), ReadError> {
        self.check(topology)?;
        let read = self.read(frame)?;
        let unit = match topology.format {
            Format::Gro => 1.0 / ANGSTROM_PER_NM,
            _ => 1.0,
        };
        let rows = topology.particles.rows.iter().map(|&row| row as usize);
        let mut particles = topology.particles.clone();
        particles.positions = rows.clone().map(|row| read.positions[row] * unit).collect();
        particles.columns.retain(|column| column.name != VELOCITY);
        if let Some(velocities) = &read.velocities {
            let values: Vec<f32> = rows
                .flat_map(|row| (velocities[row] * unit).as_vec3().to_array())
                .collect();
            particles.columns.push(Column::new(VELOCITY, 3, values));
        }
        Ok((particles, read.time_ps))
    }

    /// Whether the trajectory is about the atoms of `topology`.
    ///
    /// # Errors
    /// When the numbers of atoms differ.
    pub fn check(&self, topology: &ParticleFile) -> Result<(), ReadError> {
        let wanted = topology.particles.len() + topology.left_out;
        let rows = topology.particles.rows.iter();
        let fits = rows.max().is_none_or(|&row| (row as usize) < self.atoms());
        if wanted == self.atoms() && fits {
            return Ok(());
        }
        let problem = format!(
            "holds {} atoms in every frame, but the topology has {wanted}",
            self.atoms()
        );
        let error = ParseError::new(Place::Whole, problem)
            .with_help("give the file that the simulation started from, or one written with the same selection of atoms");
        Err(failure(&self.path, self.format, error.into()))
    }
}

/// The column of velocities.
const VELOCITY: &str = "velocity";

fn failure(path: &Path, format: TrajectoryFormat, trouble: Trouble) -> ReadError {
    let path = path.to_owned();
    match trouble {
        Trouble::Io(source) => ReadError::Io { path, source },
        Trouble::Parse(error) => ReadError::Malformed {
            path,
            format: format.name(),
            error,
        },
    }
}

/// An error within a frame that starts at `start`.
fn after(mut error: ParseError, start: u64) -> ParseError {
    if let Place::Byte(at) = &mut error.place {
        *at += start;
    }
    error
}

/// An error at a byte.
fn wrong(at: u64, problem: impl Into<String>) -> ParseError {
    ParseError::new(Place::Byte(at), problem)
}

/// The number of atoms of a frame against that of the frames before.
fn same_atoms(atoms: &mut Option<usize>, found: i32, at: u64) -> Result<usize, ParseError> {
    let count = usize::try_from(found)
        .ok()
        .filter(|&count| count > 0)
        .ok_or_else(|| wrong(at, format!("a frame of {found} atoms")))?;
    let before = *atoms.get_or_insert(count);
    if before != count {
        let problem = format!("a frame of {count} atoms after frames of {before}");
        return Err(wrong(at, problem).with_help("all frames must hold the same atoms"));
    }
    Ok(count)
}
