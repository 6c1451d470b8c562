//! The nodes of `cells`: eight-wide, addressed by 32-bit index, as the leaf blocks are.

pub use crate::accel::blocks::{Block, LANES, LEAF, LeafHeader, blocks_per_chunk, pieces};

/// Eight children: their boxes axis by axis, where they are, and in which order rays meet them.
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
    /// A node without children.
    pub const EMPTY: Self = Self {
        bounds: [
            [f32::INFINITY; 8],
            [f32::INFINITY; 8],
            [f32::INFINITY; 8],
            [f32::NEG_INFINITY; 8],
            [f32::NEG_INFINITY; 8],
            [f32::NEG_INFINITY; 8],
        ],
        children: [0; 8],
        before: [[0; 8]; 4],
    };
}
