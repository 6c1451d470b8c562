//! XTC of GROMACS: positions in nm, rounded to multiples of 1/precision and packed into as few bits as
//! their range and the distances of neighbours in the file take ("3dfcoord" of the xdrf library by
//! F. van Hoesel). Written anew: the readers that there are panic on damaged files.

use super::source::{Source, Trouble, Xdr};
use super::{ANGSTROM_PER_NM, Index, Layout, ParseError, Span, TrajectoryFrame, same_atoms, wrong};
use glam::DVec3;

/// First number of a frame; the second kind has 64-bit lengths, for more than 300 million atoms.
const MAGICS: [i32; 2] = [1995, 2023];
/// Magic, atoms, step, time, box, atoms once more.
const HEADER_BYTES: usize = 56;
/// Up to this many atoms are stored as they are.
const MOST_UNPACKED: usize = 9;
/// Precision, least and greatest integers, and the first index of [`RANGES`].
const PRELUDE_BYTES: usize = 32;

/// Sizes of small boxes around the atom before, about 2^(i/3) each.
const RANGES: [u32; 73] = [
    0, 0, 0, 0, 0, 0, 0, 0, 0, 8, 10, 12, 16, 20, 25, 32, 40, 50, 64, 80, 101, 128, 161, 203, 256,
    322, 406, 512, 645, 812, 1024, 1290, 1625, 2048, 2580, 3250, 4096, 5060, 6501, 8192, 10321,
    13003, 16384, 20642, 26007, 32768, 41285, 52015, 65536, 82570, 104031, 131072, 165140, 208063,
    262144, 330280, 416127, 524287, 660561, 832255, 1048576, 1321122, 1664510, 2097152, 2642245,
    3329021, 4194304, 5284491, 6658042, 8388607, 10568983, 13316085, 16777216,
];
/// The first of them that is a size.
const FIRST_RANGE: usize = 9;
/// Ranges beyond this are stored axis by axis.
const LARGEST_PRODUCT_RANGE: u64 = 0x00ff_ffff;

pub(super) fn detect(head: &[u8]) -> bool {
    MAGICS
        .iter()
        .any(|magic| head.starts_with(&magic.to_be_bytes()))
}

pub(super) fn index(source: &mut Source) -> Result<Index, Trouble> {
    let mut atoms = None;
    let mut frames = Vec::new();
    let mut start = 0;
    while start < source.length() {
        let Some(head) = source.array::<HEADER_BYTES>(start)? else {
            break;
        };
        let mut xdr = Xdr::new(&head);
        let magic = xdr.i32().unwrap_or(0);
        if !MAGICS.contains(&magic) {
            let problem = format!("expected a frame's number 1995 or 2023, found {magic}");
            return Err(wrong(start, problem).into());
        }
        let count = same_atoms(&mut atoms, xdr.i32().unwrap_or(0), start)?;
        let body = start + HEADER_BYTES as u64;
        let bytes = if count <= MOST_UNPACKED {
            HEADER_BYTES as u64 + 12 * count as u64
        } else {
            let length_at = body + PRELUDE_BYTES as u64;
            let Some((length, length_bytes)) = packed_length(source, magic, length_at)? else {
                break;
            };
            let padded = length.checked_next_multiple_of(4);
            let padded =
                padded.ok_or_else(|| wrong(length_at, "a packed length beyond all files"))?;
            (HEADER_BYTES + PRELUDE_BYTES) as u64 + length_bytes + padded.min(u64::MAX / 2)
        };
        if source.length() - start < bytes {
            break;
        }
        frames.push(Span { start, bytes });
        start += bytes;
    }
    Ok(Index {
        atoms: atoms.unwrap_or(0),
        frames,
        rest: source.length() - start,
        layout: Layout::Xtc,
    })
}

/// How many packed bytes follow the number at `at`, and the bytes of that number itself.
fn packed_length(source: &mut Source, magic: i32, at: u64) -> Result<Option<(u64, u64)>, Trouble> {
    Ok(if magic == MAGICS[1] {
        source
            .array(at)?
            .map(|bytes| (u64::from_be_bytes(bytes), 8))
    } else {
        let bytes = source.array(at)?;
        bytes.map(|bytes| (u64::from(u32::from_be_bytes(bytes)), 4))
    })
}

pub(super) fn decode(bytes: &[u8], atoms: usize) -> Result<TrajectoryFrame, ParseError> {
    let mut xdr = Xdr::new(bytes);
    let ends = || wrong(bytes.len() as u64, "the frame ends early");
    let magic = xdr.i32().ok_or_else(ends)?;
    xdr.skip(8);
    let time_ps = xdr.f32().map(f64::from);
    xdr.skip(HEADER_BYTES - 16);
    let positions = if atoms <= MOST_UNPACKED {
        let mut real = || Some(xdr.real(false)? * ANGSTROM_PER_NM);
        let position = |_| Some(DVec3::new(real()?, real()?, real()?));
        (0..atoms)
            .map(position)
            .collect::<Option<_>>()
            .ok_or_else(ends)?
    } else {
        let precision = xdr.f32().ok_or_else(ends)?;
        if !(precision > 0.0 && precision.is_finite()) {
            return Err(wrong(
                HEADER_BYTES as u64,
                format!("a precision of {precision}"),
            ));
        }
        let mut three = || Some([xdr.i32()?, xdr.i32()?, xdr.i32()?].map(i64::from));
        let (Some(least), Some(greatest)) = (three(), three()) else {
            return Err(ends());
        };
        let range = xdr.i32().ok_or_else(ends)?;
        xdr.skip(if magic == MAGICS[1] { 8 } else { 4 });
        let start = xdr.at();
        let unit = ANGSTROM_PER_NM / f64::from(precision);
        let steps = Unpacker::new(xdr.rest(), least, greatest, range)
            .and_then(|unpacker| unpacker.positions(atoms))
            .map_err(|problem| wrong(start, problem))?;
        let position = |[x, y, z]: [i64; 3]| DVec3::new(x as f64, y as f64, z as f64) * unit;
        steps.into_iter().map(position).collect()
    };
    Ok(TrajectoryFrame {
        positions,
        velocities: None,
        time_ps,
    })
}

/// Bits of a number, the highest first.
struct Bits<'a> {
    bytes: &'a [u8],
    /// Bits read so far.
    at: usize,
}

impl Bits<'_> {
    /// The next `count` bits, at most 32.
    fn take(&mut self, count: u32) -> Result<u64, &'static str> {
        let mut value = 0;
        let mut left = count as usize;
        while left > 0 {
            let byte = *self.bytes.get(self.at / 8).ok_or(ENDS)?;
            let free = 8 - self.at % 8;
            let used = left.min(free);
            let part = (u32::from(byte) >> (free - used)) & ((1 << used) - 1);
            value = value << used | u64::from(part);
            self.at += used;
            left -= used;
        }
        Ok(value)
    }

    /// Three numbers below `sizes`, packed into one of `bits` bits as digits of a mixed base, whose
    /// bytes come lowest first.
    fn three(&mut self, bits: u32, sizes: [u64; 3]) -> Result<[i64; 3], &'static str> {
        let mut packed = 0_u128;
        let mut shift = 0;
        while shift < bits {
            let part = self.take((bits - shift).min(8))?;
            packed |= u128::from(part) << shift;
            shift += 8;
        }
        let [_, y_size, z_size] = sizes.map(u128::from);
        let z = packed % z_size;
        let y = packed / z_size % y_size;
        let x = packed / z_size / y_size;
        // In a damaged file the highest digit may be beyond its size.
        Ok([i64::try_from(x).map_err(|_| BEYOND)?, y as i64, z as i64])
    }
}

const ENDS: &str = "the packed coordinates end early";
const BEYOND: &str = "packed coordinates beyond their range";

/// The bits that a number up to `size` takes.
fn bits_for(size: u128) -> u32 {
    u128::BITS - size.leading_zeros()
}

struct Unpacker<'a> {
    bits: Bits<'a>,
    least: [i64; 3],
    sizes: [u64; 3],
    /// Bits of a whole position; `None` where each axis has its own.
    whole: Option<u32>,
    range: usize,
}

impl<'a> Unpacker<'a> {
    fn new(
        bytes: &'a [u8],
        least: [i64; 3],
        greatest: [i64; 3],
        range: i32,
    ) -> Result<Self, &'static str> {
        let range = usize::try_from(range)
            .ok()
            .filter(|&range| range < RANGES.len());
        let range = range.ok_or("an unknown packing range")?;
        let mut sizes = [0; 3];
        for axis in 0..3 {
            let size = u64::try_from(greatest[axis] - least[axis] + 1).ok();
            sizes[axis] = size
                .filter(|&size| size > 0)
                .ok_or("bounds that are upside down")?;
        }
        let is_large = sizes.iter().any(|&size| size > LARGEST_PRODUCT_RANGE);
        let whole = (!is_large).then(|| bits_for(sizes.map(u128::from).iter().product()));
        Ok(Self {
            bits: Bits { bytes, at: 0 },
            least,
            sizes,
            whole,
            range,
        })
    }

    /// A position stored by itself.
    fn whole_position(&mut self) -> Result<[i64; 3], &'static str> {
        let offset = match self.whole {
            Some(bits) => self.bits.three(bits, self.sizes)?,
            None => {
                let mut offset = [0; 3];
                for (axis, offset) in offset.iter_mut().enumerate() {
                    let bits = bits_for(u128::from(self.sizes[axis])).min(32);
                    *offset = self.bits.take(bits)? as i64;
                }
                offset
            }
        };
        Ok([0, 1, 2].map(|axis| self.least[axis] + offset[axis]))
    }

    /// Atoms come as one position stored by itself and a run of small steps, each from the atom before.
    /// A flag says whether the run's length or the steps' range changes. The first step of a run is
    /// stored before the position that it starts from: of water the oxygen comes first, but as the
    /// second atom it is near both hydrogens.
    fn positions(mut self, atoms: usize) -> Result<Vec<[i64; 3]>, &'static str> {
        // Every atom takes more than a bit, so the count cannot ask for more than is there.
        if atoms > 8 * self.bits.bytes.len() {
            return Err(ENDS);
        }
        let mut positions = Vec::with_capacity(atoms.min(self.bits.bytes.len()));
        let mut run = 0;
        while positions.len() < atoms {
            let mut before = self.whole_position()?;
            let mut change = 0;
            if self.bits.take(1)? == 1 {
                let code = self.bits.take(5)?;
                run = code / 3;
                change = code as i32 % 3 - 1;
            }
            if run == 0 {
                positions.push(before);
            }
            let size = RANGES[self.range];
            for step in 0..run {
                if size == 0 {
                    return Err("steps of no size");
                }
                // The index is the number of bits, too.
                let offset = self.bits.three(self.range as u32, [u64::from(size); 3])?;
                let half = i64::from(size / 2);
                let here = [0, 1, 2].map(|axis| before[axis] + offset[axis] - half);
                if step == 0 {
                    positions.push(here);
                    positions.push(before);
                } else {
                    positions.push(here);
                }
                before = here;
            }
            self.range = self
                .range
                .checked_add_signed(change as isize)
                .filter(|range| (FIRST_RANGE..RANGES.len()).contains(range) || change == 0)
                .ok_or("a packing range beyond the table")?;
        }
        if positions.len() > atoms {
            return Err("more packed atoms than the frame has");
        }
        Ok(positions)
    }
}
