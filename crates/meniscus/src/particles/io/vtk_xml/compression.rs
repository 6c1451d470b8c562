//! Compressed arrays: a header with the sizes of the blocks, then the blocks.

use super::document::Storage;
use super::source::Source;
use crate::particles::io::bytes::Endian;
use flate2::{Decompress, FlushDecompress};
use liblzma::stream::{Action, Stream};

/// How blocks are compressed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Compressor {
    /// zlib streams.
    ZLib,
    /// LZ4 blocks without frames.
    Lz4,
    /// xz streams.
    Lzma,
}

impl Compressor {
    /// The compressor of that class name.
    pub(super) fn from_name(name: &str) -> Option<Self> {
        match name {
            "vtkZLibDataCompressor" => Some(Self::ZLib),
            "vtkLZ4DataCompressor" => Some(Self::Lz4),
            "vtkLZMADataCompressor" => Some(Self::Lzma),
            _ => None,
        }
    }

    /// No block unfolds to more than this many times its compressed size (and a few bytes): deflate
    /// and LZ4 by their definition, xz by trial with zeros and some room.
    fn greatest_ratio(self) -> usize {
        match self {
            Self::ZLib => 1032,
            Self::Lz4 => 255,
            Self::Lzma => 16_384,
        }
    }
}

/// The dictionary of `xz -9` is 64 MiB; the decoder needs a little more.
const LZMA_MEMORY: u64 = 80 << 20;

/// The number in a header of four or eight bytes.
pub(super) fn number(bytes: &[u8], endian: Endian) -> Result<usize, String> {
    let join = |sum: u64, byte: &u8| sum << 8 | u64::from(*byte);
    let value = match endian {
        Endian::Big => bytes.iter().fold(0, join),
        Endian::Little => bytes.iter().rev().fold(0, join),
    };
    usize::try_from(value).map_err(|_| format!("{value} bytes do not fit into memory"))
}

/// The `needed` bytes of a compressed array: block count, block size, size of the last block where
/// it is shorter (else 0), the compressed sizes, and the blocks.
pub(super) fn unfold(
    source: &mut Source,
    storage: &Storage,
    compressor: Compressor,
    needed: usize,
) -> Result<Vec<u8>, String> {
    let width = storage.header_width;
    let blocks = source.take_number(width, storage.endian)?;
    let block_size = source.take_number(width, storage.endian)?;
    let last_size = source.take_number(width, storage.endian)?;
    let full = if last_size > 0 {
        blocks.saturating_sub(1)
    } else {
        blocks
    };
    let total = full
        .checked_mul(block_size)
        .and_then(|size| size.checked_add(if blocks > 0 { last_size } else { 0 }));
    if total != Some(needed) {
        return Err(format!(
            "{needed} bytes are needed, {blocks} blocks of {block_size} bytes (the last of \
             {last_size}) are announced"
        ));
    }
    let header = blocks
        .checked_mul(width)
        .ok_or_else(|| format!("{blocks} blocks cannot be in a file"))?;
    let compressed_sizes = source.take(header)?;
    let compressed_sizes: Vec<usize> = compressed_sizes
        .chunks_exact(width)
        .map(|size| number(size, storage.endian))
        .collect::<Result<_, _>>()?;
    let size_of_block = |block: usize| if block < full { block_size } else { last_size };
    for (block, &compressed) in compressed_sizes.iter().enumerate() {
        let size = size_of_block(block);
        if size / compressor.greatest_ratio() > compressed.saturating_add(64) {
            return Err(format!(
                "block {block} cannot unfold from {compressed} to {size} bytes"
            ));
        }
    }
    let enough: usize = compressed_sizes
        .iter()
        .fold(0, |sum, &size| sum.saturating_add(size));
    if enough > source.at_most() {
        return Err(format!(
            "{enough} bytes of blocks are announced, but only {} follow",
            source.at_most()
        ));
    }
    let mut decoder = Decoder::new(compressor);
    let mut unfolded = vec![0; needed];
    let mut rest = unfolded.as_mut_slice();
    for (block, &compressed) in compressed_sizes.iter().enumerate() {
        let (target, behind) = rest.split_at_mut(size_of_block(block));
        rest = behind;
        let input = source.take(compressed)?;
        decoder
            .decode(&input, target)
            .map_err(|problem| format!("block {block}: {problem}"))?;
    }
    Ok(unfolded)
}

enum Decoder {
    ZLib(Decompress),
    Lz4,
    Lzma,
}

impl Decoder {
    fn new(compressor: Compressor) -> Self {
        match compressor {
            Compressor::ZLib => Self::ZLib(Decompress::new(true)),
            Compressor::Lz4 => Self::Lz4,
            Compressor::Lzma => Self::Lzma,
        }
    }

    /// Decompresses one block, which must fill `target`.
    fn decode(&mut self, input: &[u8], target: &mut [u8]) -> Result<(), String> {
        let size = target.len();
        let found = match self {
            Self::ZLib(state) => {
                state.reset(true);
                state
                    .decompress(input, target, FlushDecompress::Finish)
                    .map_err(|error| format!("damaged zlib data ({error})"))?;
                state.total_out()
            }
            Self::Lz4 => lz4_flex::block::decompress_into(input, target)
                .map_err(|error| format!("damaged LZ4 data ({error})"))?
                as u64,
            Self::Lzma => {
                let damaged = |error| format!("damaged xz data ({error})");
                let mut state = Stream::new_stream_decoder(LZMA_MEMORY, 0).map_err(damaged)?;
                state
                    .process(input, target, Action::Finish)
                    .map_err(damaged)?;
                state.total_out()
            }
        };
        if found != size as u64 {
            return Err(format!("unfolds to {found} bytes, {size} were expected"));
        }
        Ok(())
    }
}
