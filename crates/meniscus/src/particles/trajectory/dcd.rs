//! DCD of CHARMM, NAMD and X-PLOR: Fortran records of f32, ångström. Each record stands between two
//! marks with its length, of 4 or 8 bytes, in the byte order of the machine that wrote it.

use super::source::{Source, Trouble};
use super::{Index, Layout, ParseError, Span, TrajectoryFrame, wrong};
use glam::DVec3;

/// Bytes of the first record: `CORD` and twenty integers.
const HEADER_BYTES: u64 = 84;
/// Places of the integers that we use.
const FIXED_ATOMS: usize = 8;
const HAS_CELL: usize = 10;
const HAS_FOURTH: usize = 11;
const CHARMM_VERSION: usize = 19;

/// How the file writes lengths.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Marks {
    is_wide: bool,
    is_little: bool,
}

impl Marks {
    fn of(head: &[u8]) -> Option<Self> {
        let starts = |mark: &[u8]| {
            let rest = head.strip_prefix(mark);
            rest.is_some_and(|rest| rest.starts_with(b"CORD"))
        };
        let marks = |is_wide, is_little| Self { is_wide, is_little };
        if starts(&(HEADER_BYTES as u32).to_le_bytes()) {
            Some(marks(false, true))
        } else if starts(&(HEADER_BYTES as u32).to_be_bytes()) {
            Some(marks(false, false))
        } else if starts(&HEADER_BYTES.to_le_bytes()) {
            Some(marks(true, true))
        } else if starts(&HEADER_BYTES.to_be_bytes()) {
            Some(marks(true, false))
        } else {
            None
        }
    }

    fn bytes(self) -> u64 {
        if self.is_wide { 8 } else { 4 }
    }

    fn u32(self, bytes: [u8; 4]) -> u32 {
        if self.is_little {
            u32::from_le_bytes(bytes)
        } else {
            u32::from_be_bytes(bytes)
        }
    }

    fn f32(self, bytes: [u8; 4]) -> f32 {
        f32::from_bits(self.u32(bytes))
    }

    /// The length that the mark at the start of `bytes` states.
    fn length(self, bytes: &[u8]) -> Option<u64> {
        if !self.is_wide {
            return bytes.first_chunk().map(|&mark| u64::from(self.u32(mark)));
        }
        let mark = *bytes.first_chunk()?;
        Some(if self.is_little {
            u64::from_le_bytes(mark)
        } else {
            u64::from_be_bytes(mark)
        })
    }
}

/// What the records of a frame hold.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Records {
    marks: Marks,
    has_cell: bool,
    has_fourth: bool,
    /// Where some atoms do not move: the others, from 0. Frames after the first hold these alone.
    free: Option<Vec<u32>>,
}

impl Records {
    /// The frame that holds the atoms which do not move, if there are any.
    pub(super) fn fixed_from(&self, first: Span) -> Option<Span> {
        self.free.is_some().then_some(first)
    }

    /// Bytes of a frame whose coordinates are of `atoms` atoms.
    fn frame_bytes(&self, atoms: u64) -> u64 {
        let record = |bytes: u64| bytes + 2 * self.marks.bytes();
        let axes = if self.has_fourth { 4 } else { 3 };
        let cell = if self.has_cell { record(CELL_BYTES) } else { 0 };
        cell + axes * record(4 * atoms)
    }
}

/// Six doubles.
const CELL_BYTES: u64 = 48;

pub(super) fn detect(head: &[u8]) -> bool {
    Marks::of(head).is_some()
}

/// The records of a file, one after the other.
struct Reader<'a> {
    source: &'a mut Source,
    marks: Marks,
    at: u64,
}

impl Reader<'_> {
    /// The next record, which the file must hold as a whole.
    fn record(&mut self, what: &str) -> Result<Vec<u8>, Trouble> {
        let start = self.at;
        let mark = self.marks.bytes();
        let ends = || wrong(start, format!("the file ends within {what}"));
        let room = self.source.length().saturating_sub(start);
        if room < 2 * mark {
            return Err(ends().into());
        }
        let head = self.source.bytes(Span { start, bytes: mark })?;
        let length = self.marks.length(&head).unwrap_or(0);
        if length > room - 2 * mark {
            return Err(ends().into());
        }
        let content = self.source.bytes(Span {
            start: start + mark,
            bytes: length + mark,
        })?;
        let (content, tail) = content.split_at(length as usize);
        if self.marks.length(tail) != Some(length) {
            let problem = format!("{what}: the record's two lengths differ");
            return Err(wrong(start, problem).into());
        }
        self.at = start + length + 2 * mark;
        Ok(content.to_vec())
    }
}

pub(super) fn index(source: &mut Source) -> Result<Index, Trouble> {
    let head = source.head(super::HEAD_BYTES)?;
    let marks = Marks::of(&head).ok_or_else(|| wrong(0, "expected a record of 84 bytes: CORD"))?;
    let mut reader = Reader {
        source,
        marks,
        at: 0,
    };
    let header = reader.record("the header")?;
    let numbers: Vec<u32> = header[4..]
        .as_chunks()
        .0
        .iter()
        .map(|&bytes| marks.u32(bytes))
        .collect();
    reader.record("the title")?;
    let at = reader.at;
    let count = reader.record("the number of atoms")?;
    let atoms = count.first_chunk().map_or(0, |&bytes| marks.u32(bytes));
    let number = |place: usize| numbers.get(place).copied().unwrap_or(0);
    if atoms == 0 || atoms > i32::MAX as u32 {
        return Err(wrong(at, format!("frames of {atoms} atoms")).into());
    }
    let is_charmm = number(CHARMM_VERSION) != 0;
    let fixed = number(FIXED_ATOMS);
    let free = match fixed {
        0 => None,
        fixed if fixed < atoms => {
            let at = reader.at;
            let list = reader.record("the list of atoms that move")?;
            let free: Vec<u32> = list
                .as_chunks()
                .0
                .iter()
                .map(|&bytes| marks.u32(bytes).wrapping_sub(1))
                .collect();
            if free.len() as u32 != atoms - fixed || free.iter().any(|&atom| atom >= atoms) {
                let problem = format!("expected {} atoms that move", atoms - fixed);
                return Err(wrong(at, problem).into());
            }
            Some(free)
        }
        _ => return Err(wrong(0, format!("{fixed} of {atoms} atoms do not move")).into()),
    };
    let records = Records {
        marks,
        has_cell: is_charmm && number(HAS_CELL) != 0,
        has_fourth: is_charmm && number(HAS_FOURTH) != 0,
        free,
    };
    let start = reader.at;
    // The header's own count is of no use: it stays 0 when the run was stopped.
    let first = records.frame_bytes(u64::from(atoms));
    let later = match &records.free {
        Some(free) => records.frame_bytes(free.len() as u64),
        None => first,
    };
    let mut frames = Vec::new();
    let mut at = start;
    loop {
        let bytes = if frames.is_empty() { first } else { later };
        if source.length() - at < bytes {
            break;
        }
        frames.push(Span { start: at, bytes });
        at += bytes;
    }
    Ok(Index {
        atoms: atoms as usize,
        frames,
        rest: source.length() - at,
        layout: Layout::Dcd(records),
    })
}

/// `fixed` is the first frame, where this one does not hold all atoms.
pub(super) fn decode(
    bytes: &[u8],
    atoms: usize,
    records: &Records,
    fixed: Option<&[u8]>,
) -> Result<TrajectoryFrame, ParseError> {
    let positions = match (fixed, &records.free) {
        (Some(fixed), Some(free)) => {
            let mut positions = coordinates(fixed, atoms, records)?;
            let moved = coordinates(bytes, free.len(), records)?;
            for (&atom, position) in free.iter().zip(moved) {
                positions[atom as usize] = position;
            }
            positions
        }
        _ => coordinates(bytes, atoms, records)?,
    };
    Ok(TrajectoryFrame {
        positions,
        ..TrajectoryFrame::default()
    })
}

fn coordinates(bytes: &[u8], atoms: usize, records: &Records) -> Result<Vec<DVec3>, ParseError> {
    let marks = records.marks;
    let mark = marks.bytes() as usize;
    let mut at = 0;
    let mut record = |length: usize, what: &str| -> Result<&[u8], ParseError> {
        let found = bytes.get(at..).and_then(|rest| marks.length(rest));
        if found != Some(length as u64) {
            let found = found.map_or_else(|| "the end".to_owned(), |bytes| bytes.to_string());
            let problem = format!("expected a record of {length} bytes ({what}), found {found}");
            return Err(wrong(at as u64, problem));
        }
        let start = at + mark;
        at = start + length + mark;
        let ends = || wrong(start as u64, format!("the frame ends within {what}"));
        bytes.get(start..start + length).ok_or_else(ends)
    };
    if records.has_cell {
        record(CELL_BYTES as usize, "the unit cell")?;
    }
    let mut axes = [[].as_slice(); 3];
    for (axis, name) in axes.iter_mut().zip(["x", "y", "z"]) {
        *axis = record(4 * atoms, name)?.as_chunks::<4>().0;
    }
    let [x, y, z] = axes;
    let number = |bytes: &[u8; 4]| f64::from(marks.f32(*bytes));
    Ok((0..atoms)
        .map(|atom| DVec3::new(number(&x[atom]), number(&y[atom]), number(&z[atom])))
        .collect())
}
