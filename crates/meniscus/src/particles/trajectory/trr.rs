//! TRR of GROMACS: XDR numbers in full precision, nm and nm/ps. A frame is a header with the sizes of
//! its parts and the parts: box, virial, pressure, positions, velocities, forces.

use super::source::{Source, Trouble, Xdr};
use super::{ANGSTROM_PER_NM, Index, Layout, ParseError, Span, TrajectoryFrame, same_atoms, wrong};
use glam::DVec3;

const MAGIC: i32 = 1993;
/// Longest header: magic, two lengths, the version's name, thirteen integers, two doubles.
const HEADER_BYTES: usize = 128;
/// Longest name of a version.
const LONGEST_NAME: i32 = 40;

pub(super) fn detect(head: &[u8]) -> bool {
    head.starts_with(&MAGIC.to_be_bytes())
}

struct Header {
    atoms: i32,
    is_double: bool,
    time_ps: f64,
    /// Bytes of the header and of what stands before the positions.
    before_positions: usize,
    positions: usize,
    velocities: usize,
    /// Bytes of the whole frame.
    total: u64,
}

/// The header at the start of `bytes`; `None` where they end within it.
fn header(bytes: &[u8]) -> Result<Option<Header>, ParseError> {
    let mut xdr = Xdr::new(bytes);
    let Some(magic) = xdr.i32() else {
        return Ok(None);
    };
    if magic != MAGIC {
        return Err(wrong(
            0,
            format!("expected a frame's number {MAGIC}, found {magic}"),
        ));
    }
    let (Some(_), Some(name)) = (xdr.i32(), xdr.i32()) else {
        return Ok(None);
    };
    if !(0..=LONGEST_NAME).contains(&name) {
        return Err(wrong(8, format!("a version's name of {name} bytes")));
    }
    xdr.skip((name as usize).next_multiple_of(4));
    let sizes_at = xdr.at();
    let mut numbers = [0; 13];
    for number in &mut numbers {
        match xdr.i32() {
            Some(found) => *number = found,
            None => return Ok(None),
        }
    }
    let (sizes, atoms) = (&numbers[..10], numbers[10]);
    if let Some(size) = sizes.iter().find(|&&size| size < 0) {
        return Err(wrong(sizes_at, format!("a part of {size} bytes")));
    }
    let [positions, velocities, forces] = [7, 8, 9].map(|part| sizes[part] as u64);
    let coordinates = 3 * u64::try_from(atoms).unwrap_or(0);
    // The precision is told by the size of any part.
    let real_bytes = match (sizes[2], positions.max(velocities).max(forces)) {
        (box_bytes, _) if box_bytes > 0 => box_bytes as u64 / 9,
        (_, bytes) => bytes.checked_div(coordinates).unwrap_or(0),
    };
    let is_double = match real_bytes {
        4 => false,
        8 => true,
        other => return Err(wrong(sizes_at, format!("numbers of {other} bytes"))),
    };
    let wanted = coordinates * real_bytes;
    if let Some(bytes) = [positions, velocities]
        .into_iter()
        .find(|&b| b != 0 && b != wanted)
    {
        let problem = format!("{atoms} atoms cannot have {bytes} bytes of coordinates");
        return Err(wrong(sizes_at, problem));
    }
    let Some(time_ps) = xdr.real(is_double) else {
        return Ok(None);
    };
    xdr.skip(real_bytes as usize);
    let before: u64 = sizes[..7].iter().map(|&size| size as u64).sum();
    let all: u64 = sizes.iter().map(|&size| size as u64).sum();
    Ok(Some(Header {
        atoms,
        is_double,
        time_ps,
        before_positions: (xdr.at() + before) as usize,
        positions: positions as usize,
        velocities: velocities as usize,
        total: xdr.at() + all,
    }))
}

pub(super) fn index(source: &mut Source) -> Result<Index, Trouble> {
    let mut atoms = None;
    let mut frames = Vec::new();
    let mut start = 0;
    while start < source.length() {
        let bytes = HEADER_BYTES.min((source.length() - start) as usize) as u64;
        let head = source.bytes(Span { start, bytes })?;
        let Some(header) = header(&head).map_err(|error| super::after(error, start))? else {
            break;
        };
        if source.length() - start < header.total {
            break;
        }
        // Frames may hold velocities or forces alone.
        if header.positions > 0 {
            same_atoms(&mut atoms, header.atoms, start)?;
            frames.push(Span {
                start,
                bytes: header.total,
            });
        }
        start += header.total;
    }
    Ok(Index {
        atoms: atoms.unwrap_or(0),
        frames,
        rest: source.length() - start,
        layout: Layout::Trr,
    })
}

pub(super) fn decode(bytes: &[u8], atoms: usize) -> Result<TrajectoryFrame, ParseError> {
    let header = header(bytes)?.ok_or_else(|| wrong(0, "the frame ends within its header"))?;
    let vectors = |start: usize| -> Option<Vec<DVec3>> {
        let mut xdr = Xdr::new(bytes);
        xdr.skip(start);
        let mut real = || Some(xdr.real(header.is_double)? * ANGSTROM_PER_NM);
        (0..atoms)
            .map(|_| Some(DVec3::new(real()?, real()?, real()?)))
            .collect()
    };
    let ends = || wrong(bytes.len() as u64, "the frame ends within its coordinates");
    let positions = vectors(header.before_positions).ok_or_else(ends)?;
    let velocities = (header.velocities > 0)
        .then(|| vectors(header.before_positions + header.positions).ok_or_else(ends))
        .transpose()?;
    Ok(TrajectoryFrame {
        positions,
        velocities,
        time_ps: Some(header.time_ps),
    })
}
