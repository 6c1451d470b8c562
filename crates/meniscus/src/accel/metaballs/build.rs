//! Grows both trees from the top (Algorithms 1 and 2 of the paper), keeping track of split metaballs.

use super::fit::{Member, Overlap, discard, fitted, surface_reach};
use super::split::{self, Plane, leaf_cost, node_cost};
use super::{Boxes, MAX_DEPTH};
use crate::field::BlobField;
use crate::math::aabb::Aabb;
use crate::primitive::Shapes;
use crate::scene::EngineSettings;

/// Nodes with more metaballs than this are built on several threads; fixed, as all of the build, so
/// that the tree does not depend on their number.
const PARALLEL_MEMBERS: usize = 1024;
/// Split metaballs are only discarded from nodes of at most this many metaballs: the test looks at all
/// pairs, and finds little in larger nodes (§6).
const DISCARD_AT_MOST: usize = 64;
/// Up to this many own metaballs a node's split metaballs are tested against each of them, above
/// against the box around all: the leaves get the same, and large nodes stay linear.
const EXACT_AT_MOST: usize = 32;

/// A part of the tree.
#[derive(Debug)]
pub(super) enum Subtree {
    Inner {
        bounds: Aabb,
        children: Box<[Subtree; 2]>,
    },
    Leaf(Leaf),
}

/// A leaf with the indices of its metaballs.
#[derive(Debug)]
pub(super) struct Leaf {
    pub(super) bounds: Aabb,
    pub(super) own: Vec<u32>,
    pub(super) split: Vec<u32>,
}

impl Subtree {
    pub(super) fn bounds(&self) -> Aabb {
        match self {
            Self::Inner { bounds, .. } => *bounds,
            Self::Leaf(leaf) => leaf.bounds,
        }
    }
}

/// A node to be.
struct Part {
    bounds: Aabb,
    own: Vec<Member>,
    split: Vec<Member>,
}

impl Part {
    fn count(&self) -> usize {
        self.own.len() + self.split.len()
    }

    fn members(&self) -> impl Iterator<Item = &Member> {
        self.own.iter().chain(&self.split)
    }
}

/// What the whole build needs to know.
pub(super) struct Builder<'a> {
    field: &'a BlobField,
    boxes: Boxes,
    settings: EngineSettings,
    overlap: Overlap,
    pad: f32,
}

impl<'a> Builder<'a> {
    pub(super) fn new(
        field: &'a BlobField,
        boxes: Boxes,
        settings: EngineSettings,
        pad: f32,
    ) -> Self {
        Self {
            field,
            boxes,
            settings,
            overlap: Overlap {
                round: matches!(field.shapes, Shapes::Balls(_)),
            },
            pad,
        }
    }

    /// The whole tree; `None` where there is no surface.
    pub(super) fn build(&self) -> Option<Subtree> {
        let root = Part {
            bounds: self.field.bounds(),
            own: (0..self.field.len())
                .map(|i| Member::of(self.field, i))
                .collect(),
            split: Vec::new(),
        };
        self.grow(self.trimmed(root)?, 1)
    }

    fn grow(&self, part: Part, depth: usize) -> Option<Subtree> {
        let children = match self.children(&part) {
            Some(children) if depth < MAX_DEPTH => children,
            _ => return Some(self.leaf(part)),
        };
        let parallel = part.count() > PARALLEL_MEMBERS;
        let bounds = part.bounds;
        drop(part);
        let [first, second] = children;
        let grow = |child: Option<Part>| child.and_then(|child| self.grow(child, depth + 1));
        let (first, second) = if parallel {
            rayon::join(|| grow(first), || grow(second))
        } else {
            (grow(first), grow(second))
        };
        match (first, second) {
            (Some(first), Some(second)) => Some(Subtree::Inner {
                bounds,
                children: Box::new([first, second]),
            }),
            (only, None) | (None, only) => only,
        }
    }

    /// The two children of a node, unless it is cheaper as a leaf; `None` in place of a child that
    /// holds no surface.
    fn children(&self, part: &Part) -> Option<[Option<Part>; 2]> {
        if part.count() < 2 {
            return None;
        }
        let cost = self.settings.cost;
        let worth = leaf_cost(cost, part.count()) - node_cost(cost);
        let at_most = part.bounds.half_area() * worth;
        match self.boxes {
            Boxes::Disjoint => {
                let fit = self.settings.fit;
                let plane = split::disjoint(cost, fit, &part.own, &part.split, part.bounds)
                    .filter(|plane| plane.cost < at_most)?;
                Some(self.cut(part, plane).map(|child| self.trimmed(child)))
            }
            Boxes::Overlapping => {
                let plane = split::overlapping(cost, &part.own)?;
                let children = self.parted(part, plane)?;
                let priced =
                    |child: &Part| child.bounds.half_area() * leaf_cost(cost, child.count());
                (priced(&children[0]) + priced(&children[1]) < at_most).then(|| children.map(Some))
            }
        }
    }

    /// Algorithm 2: both sides of the plane, with what reaches into them.
    fn cut(&self, part: &Part, plane: Plane) -> [Part; 2] {
        let (own, mut parts) = sides(part, plane);
        let [first, second] = &mut parts;
        first.bounds.max[plane.axis] = plane.position;
        second.bounds.min[plane.axis] = plane.position;
        for (child, other) in [(0, 1), (1, 0)] {
            let reached = parts[child].bounds.padded(self.pad);
            parts[child].split = (part.split.iter().chain(&own[other]))
                .filter(|member| self.overlap.reaches(member, 1.0, reached))
                .copied()
                .collect();
        }
        let [first, second] = own;
        (parts[0].own, parts[1].own) = (first, second);
        parts
    }

    /// Algorithm 1: the metaballs on both sides of the plane, with those that their supports meet.
    /// `None` where rounding leaves a side empty.
    fn parted(&self, part: &Part, plane: Plane) -> Option<[Part; 2]> {
        let (own, mut parts) = sides(part, plane);
        for (child, other) in [(0, 1), (1, 0)] {
            let around = own[child].iter().fold(Aabb::EMPTY, |around, member| {
                around.union(member.support_box())
            });
            let exact = own[child].len() <= EXACT_AT_MOST;
            parts[child].bounds = around;
            parts[child].split = (part.split.iter().chain(&own[other]))
                .filter(|member| {
                    self.overlap.reaches(member, 1.0, around)
                        && (!exact
                            || own[child]
                                .iter()
                                .any(|mine| self.overlap.meet(member, mine, 1.0)))
                })
                .copied()
                .collect();
        }
        let [first, second] = own;
        (parts[0].own, parts[1].own) = (first, second);
        (!parts[0].own.is_empty() && !parts[1].own.is_empty()).then_some(parts)
    }

    /// The part fitted to its metaballs, as the switches say; `None` where it holds no surface.
    fn trimmed(&self, mut part: Part) -> Option<Part> {
        if part.count() == 0 {
            return None;
        }
        let EngineSettings {
            fit,
            rmax_boxes,
            discard: may_discard,
            ..
        } = self.settings;
        let bounding = rmax_boxes || (may_discard && part.count() <= DISCARD_AT_MOST);
        let reach = if bounding {
            surface_reach(self.field, part.members())?
        } else {
            1.0
        };
        if fit {
            let scale = if rmax_boxes { reach } else { 1.0 };
            part.bounds = fitted(part.bounds, part.members(), scale);
            if part.bounds.is_empty() {
                return None;
            }
        }
        if may_discard && part.count() <= DISCARD_AT_MOST {
            let near = part.bounds.padded(self.pad);
            discard(self.overlap, &part.own, &mut part.split, near, reach);
        }
        Some(part)
    }

    fn leaf(&self, mut part: Part) -> Subtree {
        match self.boxes {
            Boxes::Disjoint => {
                let reached = part.bounds.padded(self.pad);
                part.split
                    .retain(|member| self.overlap.reaches(member, 1.0, reached));
            }
            Boxes::Overlapping => {
                let own = &part.own;
                part.split
                    .retain(|member| own.iter().any(|mine| self.overlap.meet(member, mine, 1.0)));
            }
        }
        let indices = |members: &[Member]| members.iter().map(|member| member.index).collect();
        Subtree::Leaf(Leaf {
            bounds: part.bounds,
            own: indices(&part.own),
            split: indices(&part.split),
        })
    }
}

/// The node's own metaballs by the side of their centres, and the node twice without metaballs.
fn sides(part: &Part, plane: Plane) -> ([Vec<Member>; 2], [Part; 2]) {
    let (first, second) = (part.own.iter().copied())
        .partition(|member: &Member| member.center[plane.axis] < plane.position);
    let empty = || Part {
        bounds: part.bounds,
        own: Vec::new(),
        split: Vec::new(),
    };
    ([first, second], [empty(), empty()])
}
