//! The packed arrays of `cells`: eight-wide nodes and leaf blocks, both addressed by 32-bit index.
//!
//! A leaf is one header block followed by chunks of [`LANES`] blobs in structure-of-arrays form:
//! x, y, z relative to the leaf's centre, the shape's columns, the weight, the blob's index. Without
//! the re-centring f32 is too coarse for a million particles. Columns that are the same for all blobs
//! of the field ([`Columns`]) are not stored. With [`Leaves::Indices`] chunks hold the indices alone.
//! Nodes and leaves of blobs that move say where everything is within the shutter.

use crate::field::BlobField;
use crate::math::aabb::Aabb;
use crate::primitive::Primitive;
#[cfg(doc)]
use crate::scene::Leaves;

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

/// Marks a child reference as a leaf; the rest is the index of its header block, or in the tree of
/// coarse cells that of a coarse cell.
pub const LEAF: u32 = 1 << 31;

/// Marks a leaf reference as one to a cell that is refined when a ray comes; the rest is its index.
pub const DEEP: u32 = 1 << 30;

/// Eight children: their boxes axis by axis, where they are, and in which order rays meet them.
///
/// Where blobs move the boxes are those when the shutter opens, and each node is followed by another
/// whose boxes are those when it closes; a face is in between in proportion to the time.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C, align(64))]
pub struct Node {
    /// `bounds[axis]`: lower faces of the eight boxes, `bounds[3 + axis]`: upper faces. A child that
    /// does not exist has an empty box.
    pub bounds: [[f32; 8]; 6],
    /// Index of a node, or [`LEAF`] | index of a leaf's header block.
    pub children: [u32; 8],
    /// The children are parted by planes, so the signs of a ray's direction alone say which of two
    /// comes first. Bit j of `before[o][i]`: child j comes before child i for directions with
    /// positive z, negative x if o & 1, negative y if o & 2; the reverse for the opposite direction.
    pub before: [[u8; 8]; 4],
}

impl Node {
    /// A node without children. Its boxes are finite, so that there are numbers between two of them.
    pub const EMPTY: Self = Self {
        bounds: [
            [f32::MAX; 8],
            [f32::MAX; 8],
            [f32::MAX; 8],
            [f32::MIN; 8],
            [f32::MIN; 8],
            [f32::MIN; 8],
        ],
        children: [0; 8],
        before: [[0; 8]; 4],
    };
}

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

/// Which columns of blobs vary, and the values of those that do not.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Columns {
    /// The shape of every blob, if they are all alike.
    pub shape: Option<[f32; 6]>,
    /// The weight of every blob, if they are all alike.
    pub weight: Option<f32>,
    /// x of lanes without a blob: beyond everything, so that nothing reaches them.
    pub nowhere: f32,
    /// Columns of motion behind the weight: 0 where nothing moves; 3 of velocities; 6 with halves of
    /// accelerations. Half the shutter is the unit of time, and x, y, z and velocities are those in its
    /// middle.
    pub motion: usize,
}

impl Columns {
    /// Every column is stored.
    pub const ALL: Self = Self {
        shape: None,
        weight: None,
        nowhere: 0.0,
        motion: 0,
    };

    /// The first of the shape's columns, behind x, y and z.
    pub const SHAPE: usize = 3;

    /// Whether blobs move while the shutter is open.
    #[inline(always)]
    pub fn moves(&self) -> bool {
        self.motion > 0
    }

    /// Whether they are accelerated.
    #[inline(always)]
    pub fn is_accelerated(&self) -> bool {
        self.motion > 3
    }

    /// Those of a field of at least one blob, all within `bounds`.
    pub fn of<P: Primitive>(field: &BlobField, bounds: &Aabb) -> Self {
        let mut shape = [0.0; 6];
        P::pack(&field.shapes, 0, &mut shape[..P::COLUMNS]);
        let weight = field.weights[0];
        let weights_are_alike = field.weights.iter().all(|&other| other == weight);
        Self {
            shape: field.shapes.are_alike().then_some(shape),
            weight: weights_are_alike.then_some(weight),
            nowhere: 4.0 * bounds.min.abs().max(bounds.max.abs()).max_element(),
            motion: match &field.motion {
                None => 0,
                Some(motion) if motion.is_accelerated() => 6,
                Some(_) => 3,
            },
        }
    }

    /// The weights' column, or where it would be.
    #[inline(always)]
    pub fn weight_at<P: Primitive>(&self) -> usize {
        Self::SHAPE + if self.shape.is_none() { P::COLUMNS } else { 0 }
    }

    /// The first column of motion, or where it would be.
    #[inline(always)]
    pub fn motion_at<P: Primitive>(&self) -> usize {
        self.weight_at::<P>() + usize::from(self.weight.is_none())
    }

    /// Stored columns without the index: x, y, z, shape, weight, motion.
    #[inline(always)]
    pub fn count<P: Primitive>(&self) -> usize {
        self.motion_at::<P>() + self.motion
    }

    /// Column `k` of lanes without a blob: values that no box reaches.
    #[inline(always)]
    pub fn absent<P: Primitive>(&self, k: usize) -> f32 {
        let is_width = self.shape.is_none() && P::DIAGONAL.iter().any(|d| Self::SHAPE + d == k);
        match k {
            0 => self.nowhere,
            _ if is_width => 8.0 / self.nowhere,
            _ => 0.0,
        }
    }

    /// Blocks per chunk: one per column and one of indices, the last.
    #[inline(always)]
    pub fn blocks_per_chunk<P: Primitive>(&self) -> usize {
        self.count::<P>() + 1
    }
}

/// Cuts a packed array into pieces of at most [`PIECE_BYTES`]; element `i` is element
/// `i % per_piece` of piece `i / per_piece`.
pub fn pieces<T>(array: &[T]) -> std::slice::Chunks<'_, T> {
    array.chunks((PIECE_BYTES / size_of::<T>()).max(1))
}
