//! The shape of a tree whose leaves and nodes are full: known from the number of blobs alone, so that
//! every level is built by one dispatch and nothing is counted or linked.

use meniscus::accel::cells::layout::{LANES, LEAF};

/// Children of a node.
const WIDTH: u32 = 8;

/// Leaves, and how many nodes each level has.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Levels {
    pub(crate) leaves: u32,
    /// From the lowest to the root.
    nodes: Vec<u32>,
}

/// One level of nodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Level {
    pub(crate) count: u32,
    /// Number of the first.
    pub(crate) first: u32,
    /// What they hold.
    pub(crate) below: u32,
    /// Reference of the first thing below.
    pub(crate) below_reference: u32,
    /// Number of the box of the first thing below.
    pub(crate) below_boxes: u32,
    /// Number of the first's box.
    pub(crate) boxes_at: u32,
}

impl Levels {
    /// Those over some blobs.
    pub(crate) fn over(blobs: u32) -> Self {
        let leaves = blobs.div_ceil(LANES as u32);
        let mut nodes = Vec::new();
        let mut below = leaves;
        while below > 1 || nodes.is_empty() {
            below = below.div_ceil(WIDTH);
            nodes.push(below);
        }
        Self { leaves, nodes }
    }

    /// All nodes.
    pub(crate) fn nodes(&self) -> u32 {
        self.nodes.iter().sum()
    }

    /// Boxes of leaves and nodes; the root's is the last.
    pub(crate) fn boxes(&self) -> u32 {
        self.leaves + self.nodes()
    }

    /// Level by level, the root last. Nodes are numbered from the root downwards, boxes from the leaves
    /// upwards.
    pub(crate) fn iter(&self) -> impl Iterator<Item = Level> + '_ {
        let mut above = self.nodes();
        let mut below = self.leaves;
        let mut below_reference = LEAF;
        let mut below_boxes = 0;
        self.nodes.iter().map(move |&count| {
            above -= count;
            let level = Level {
                count,
                first: above,
                below,
                below_reference,
                below_boxes,
                boxes_at: below_boxes + below,
            };
            (below, below_reference, below_boxes) = (count, above, level.boxes_at);
            level
        })
    }

    /// Most references that wait while a ray is in any leaf.
    pub(crate) fn most_waiting(&self) -> u32 {
        self.nodes.len() as u32 * (WIDTH - 1) + 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_item_has_one_parent() {
        for blobs in [1, 16, 17, 128, 129, 1025, 300_000] {
            let levels = Levels::over(blobs);
            assert_eq!(levels.leaves, blobs.div_ceil(16));
            let mut below = levels.leaves;
            for level in levels.iter() {
                assert_eq!(level.below, below);
                assert!(level.count * WIDTH >= below && (level.count - 1) * WIDTH < below);
                below = level.count;
            }
            assert_eq!(below, 1, "there is one root");
            let root = levels.iter().last().expect("there is a root");
            assert_eq!(root.first, 0);
            assert_eq!(root.boxes_at + 1, levels.boxes());
        }
    }

    #[test]
    fn levels_lie_behind_each_other() {
        let levels: Vec<Level> = Levels::over(5000).iter().collect();
        assert_eq!(levels[0].below_reference, LEAF);
        for pair in levels.windows(2) {
            assert_eq!(pair[1].below_reference, pair[0].first);
            assert_eq!(pair[1].first + pair[1].count, pair[0].first);
            assert_eq!(pair[1].below_boxes, pair[0].boxes_at);
        }
    }
}
