//! Leaves as packed arrays, shared by the engines that copy blobs into their leaves.
//!
//! A leaf is one header block followed by chunks of [`LANES`] blobs in structure-of-arrays form:
//! x, y, z relative to the leaf's centre, the shape's columns, the weight, the blob's index. Without
//! the re-centring f32 is too coarse for a million particles.

/// Blobs per chunk, and numbers per block.
pub const LANES: usize = 16;

/// Largest piece that GPU bindings take; [`pieces`] cuts the arrays at this size.
pub const PIECE_BYTES: usize = 128 << 20;

/// 64 bytes of f32 (or of u32 in the bits of f32), aligned to a cache line.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C, align(64))]
pub struct Block(pub [f32; LANES]);

impl Block {
    /// All zero.
    pub const ZERO: Self = Self([0.0; LANES]);
}

/// Marks a child reference as a leaf; the rest is the index of its header block.
pub const LEAF: u32 = 1 << 31;

/// What a leaf's header block says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeafHeader {
    /// Number of blobs.
    pub count: usize,
    /// Local position that the blobs' coordinates are relative to.
    pub center: [f32; 3],
    /// Blobs of at least this steepness along a ray (β, 1/length²) are too small for f32 in this
    /// leaf's coordinates; infinite in almost all leaves.
    pub fine_beta: f32,
}

impl LeafHeader {
    /// The header as a block.
    pub fn to_block(self) -> Block {
        let mut block = Block::ZERO;
        block.0[0] = f32::from_bits(self.count as u32);
        block.0[1..4].copy_from_slice(&self.center);
        block.0[4] = self.fine_beta;
        block
    }

    /// The header in a block.
    #[inline(always)]
    pub fn from_block(block: &Block) -> Self {
        Self {
            count: block.0[0].to_bits() as usize,
            center: [block.0[1], block.0[2], block.0[3]],
            fine_beta: block.0[4],
        }
    }
}

/// Blocks per chunk of blobs whose shape takes `shape_columns` columns.
pub const fn blocks_per_chunk(shape_columns: usize) -> usize {
    3 + shape_columns + 2
}

/// Cuts a packed array into pieces of at most [`PIECE_BYTES`]; element `i` is element
/// `i % per_piece` of piece `i / per_piece`.
pub fn pieces<T>(array: &[T]) -> std::slice::Chunks<'_, T> {
    array.chunks((PIECE_BYTES / size_of::<T>()).max(1))
}

/// Supports below the leaf's size over this are left to float64.
const FINEST_PART: f32 = 64.0;

/// So many rounding margins count as size of a leaf: boxes are entered and rays start no more exactly.
const MARGIN_PARTS: f32 = 512.0;

/// The steepness (β, 1/length²) from which blobs are too small for f32 in a leaf of this size whose
/// box is padded by `pad`. A coordinate's rounding, 2⁻²⁴ of the leaf's size, moves q by twice itself
/// times √β, which is to stay near 10⁻⁵.
pub fn fine_limit(size: f32, pad: f32) -> f32 {
    (FINEST_PART / size.max(MARGIN_PARTS * pad)).powi(2)
}
