//! The nodes of `particles`: eight-wide, children behind their parents; and its leaves, which are those
//! of [`cells`](crate::accel::cells::layout) with one chunk each and columns for what moves.

use crate::field::BlobField;
use crate::primitive::Primitive;

/// Boxes of a node's children, axis by axis: lower faces of the eight, then upper faces.
pub type Faces = [[f32; 8]; 6];

/// Eight children: their boxes axis by axis, and where they are.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C, align(32))]
pub struct Node {
    /// `bounds[axis]`: lower faces of the eight boxes, `bounds[3 + axis]`: upper faces. A child that
    /// does not exist has an empty box.
    pub bounds: Faces,
    /// Index of a node, or [`LEAF`](crate::accel::cells::layout::LEAF) | number of a leaf.
    pub children: [u32; 8],
}

impl Node {
    /// The faces of boxes that nothing reaches, though numbers can be interpolated between them.
    pub const FAR: Faces = [
        [FAR_AWAY; 8],
        [FAR_AWAY; 8],
        [FAR_AWAY; 8],
        [-FAR_AWAY; 8],
        [-FAR_AWAY; 8],
        [-FAR_AWAY; 8],
    ];

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
        children: [Self::NONE; 8],
    };

    /// In `children`: there is none.
    pub const NONE: u32 = u32::MAX;
}

/// Beyond all coordinates, and small enough for sums and for products with inverse directions.
const FAR_AWAY: f32 = 1e30;

/// Columns of a blob: x, y, z, the shape's columns, the weight and the index.
pub const fn columns<P: Primitive>() -> usize {
    3 + P::COLUMNS + 2
}

/// Columns of a blob that moves, behind the others: its velocity in the middle of the shutter, where
/// x, y and z are taken too, and half its acceleration.
pub const MOTION_COLUMNS: usize = 6;

/// Columns of a blob that turns and stretches, behind those: its velocity gradient, row by row.
pub const TURN_COLUMNS: usize = 9;

/// Columns that a blob of `field` has for its motion.
pub fn motion_columns(field: &BlobField) -> usize {
    match &field.motion {
        None => 0,
        Some(motion) if motion.turns() => MOTION_COLUMNS + TURN_COLUMNS,
        Some(_) => MOTION_COLUMNS,
    }
}

/// Blocks of a leaf: its header and the columns.
pub const fn leaf_blocks<P: Primitive>(motion_columns: usize) -> usize {
    1 + columns::<P>() + motion_columns
}
