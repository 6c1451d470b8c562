//! What several readers need: numbers in either byte order, columns from tables of bytes.

use super::{ParseError, Place};
use crate::particles::{Column, ColumnData, Particles};
use glam::DVec3;
use rayon::prelude::*;

/// Numbers that one thread decodes at least.
pub(super) const PARALLEL: usize = 1 << 14;

/// The number types that files store.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

/// Byte order of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Endian {
    Little,
    Big,
}

/// Runs `$body` with `$type` bound to the Rust type of a [`Scalar`].
macro_rules! with_scalar {
    ($scalar:expr, $type:ident => $body:expr) => {
        match $scalar {
            $crate::particles::io::bytes::Scalar::I8 => {
                type $type = i8;
                $body
            }
            $crate::particles::io::bytes::Scalar::U8 => {
                type $type = u8;
                $body
            }
            $crate::particles::io::bytes::Scalar::I16 => {
                type $type = i16;
                $body
            }
            $crate::particles::io::bytes::Scalar::U16 => {
                type $type = u16;
                $body
            }
            $crate::particles::io::bytes::Scalar::I32 => {
                type $type = i32;
                $body
            }
            $crate::particles::io::bytes::Scalar::U32 => {
                type $type = u32;
                $body
            }
            $crate::particles::io::bytes::Scalar::I64 => {
                type $type = i64;
                $body
            }
            $crate::particles::io::bytes::Scalar::U64 => {
                type $type = u64;
                $body
            }
            $crate::particles::io::bytes::Scalar::F32 => {
                type $type = f32;
                $body
            }
            $crate::particles::io::bytes::Scalar::F64 => {
                type $type = f64;
                $body
            }
        }
    };
}

/// An empty column of `scalar` values with room for `capacity` of them.
pub(super) fn empty_data(scalar: Scalar, capacity: usize) -> ColumnData {
    with_scalar!(scalar, T => Vec::<T>::with_capacity(capacity).into())
}

pub(super) use with_scalar;

impl Scalar {
    /// Size in bytes.
    pub(super) fn size(self) -> usize {
        with_scalar!(self, T => std::mem::size_of::<T>())
    }

    /// Decodes `components` neighbouring numbers at `offset` of each record of `stride` bytes.
    ///
    /// `records` must hold whole records, and `offset + components · size ≤ stride`.
    pub(super) fn gather(
        self,
        records: &[u8],
        stride: usize,
        offset: usize,
        components: usize,
        endian: Endian,
    ) -> ColumnData {
        with_scalar!(self, T => {
            const SIZE: usize = std::mem::size_of::<T>();
            let decode = match endian {
                Endian::Little => T::from_le_bytes,
                Endian::Big => T::from_be_bytes,
            };
            if stride == components * SIZE {
                let (numbers, _) = records.as_chunks::<SIZE>();
                let all = numbers.par_iter().with_min_len(PARALLEL);
                return all.map(|&number| decode(number)).collect::<Vec<_>>().into();
            }
            let mut values = Vec::with_capacity(records.len() / stride * components);
            for record in records.chunks_exact(stride) {
                let field = &record[offset..offset + components * SIZE];
                let (numbers, _) = field.as_chunks::<SIZE>();
                values.extend(numbers.iter().map(|&number| decode(number)));
            }
            values.into()
        })
    }

    /// Decodes one number as f64.
    #[allow(
        clippy::unnecessary_cast,
        reason = "one of the ten types is f64 itself"
    )]
    pub(super) fn decode(self, bytes: &[u8], endian: Endian) -> Option<f64> {
        with_scalar!(self, T => {
            let number = *bytes.first_chunk::<{ std::mem::size_of::<T>() }>()?;
            Some(match endian {
                Endian::Little => T::from_le_bytes(number),
                Endian::Big => T::from_be_bytes(number),
            } as f64)
        })
    }
}

#[allow(
    clippy::unnecessary_cast,
    reason = "one of the ten types is f64 itself"
)]
/// Positions from three numbers at `axes` (type and offset) of each record of `stride` bytes.
pub(super) fn gather_positions(
    records: &[u8],
    stride: usize,
    axes: [(Scalar, usize); 3],
    endian: Endian,
) -> Vec<DVec3> {
    let one_type = axes.iter().all(|axis| axis.0 == axes[0].0);
    if !one_type {
        let at = |record: &[u8], (scalar, offset): (Scalar, usize)| {
            scalar.decode(&record[offset..], endian).unwrap_or(f64::NAN)
        };
        return records
            .par_chunks_exact(stride)
            .map(|record| DVec3::from_array(axes.map(|axis| at(record, axis))))
            .collect();
    }
    let offsets = axes.map(|axis| axis.1);
    with_scalar!(axes[0].0, T => {
        const SIZE: usize = std::mem::size_of::<T>();
        let decode = match endian {
            Endian::Little => T::from_le_bytes,
            Endian::Big => T::from_be_bytes,
        };
        records
            .par_chunks_exact(stride)
            .map(|record| {
                DVec3::from_array(offsets.map(|offset| {
                    let mut number = [0; SIZE];
                    number.copy_from_slice(&record[offset..offset + SIZE]);
                    decode(number) as f64
                }))
            })
            .collect()
    })
}

/// Particles from positions and columns that have as many rows; the row numbers are u32.
pub(super) fn assemble(
    positions: Vec<DVec3>,
    columns: Vec<Column>,
) -> Result<Particles, ParseError> {
    if u32::try_from(positions.len()).is_err() {
        return Err(ParseError::new(
            Place::Whole,
            format!("{} particles are more than 2³² − 1", positions.len()),
        )
        .with_help("split the file"));
    }
    debug_assert!(
        columns
            .iter()
            .all(|column| column.rows() == positions.len())
    );
    let mut particles = Particles::from_positions(positions);
    particles.columns = columns;
    Ok(particles)
}
