//! Boxes that follow blobs while the shutter is open: straight, or along the curves that a Bézier
//! polynomial of boxes draws (Ray Tracing Gems II, §35.3).
//!
//! With the boxes B₀ and B₂ at the shutter's ends and the control box B₁ between them, the faces at the
//! part u of the shutter are (1 − u)²B₀ + 2u(1 − u)B₁ + u²B₂, which is B₀ + (B₂ − B₀)u + E·u(1 − u) with
//! E = 2B₁ − B₀ − B₂. So a curve costs one product more than a straight way.

use super::layout::{Faces, Node};
use crate::field::MotionBoxes;
use crate::math::aabb::Aabb;
use crate::math::number::Number;
use crate::scene::MotionBounds;
use rayon::prelude::*;

/// Curves pay where they make the boxes of the leaves smaller than this against straight ways.
const CURVES_PAY: f64 = 0.97;

/// Where areas are compared, in parts of the shutter.
const SEEN_AT: [f32; 3] = [1.0 / 6.0, 0.5, 5.0 / 6.0];

/// Rounding of the curve in f32, in parts of the largest coordinate of its control boxes: sixteen
/// halves of an ulp.
const CURVE_ROUNDING: f32 = 1e-6;

/// How the boxes of all nodes move.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Way {
    Straight,
    Curved,
}

impl Way {
    /// The one that `asked` means for these leaves.
    pub(super) fn of(asked: MotionBounds, leaves: &[MotionBoxes]) -> Self {
        match asked {
            MotionBounds::Linear => Self::Straight,
            MotionBounds::Bezier => Self::Curved,
            MotionBounds::Auto => {
                let area = |bounds: Aabb| f64::from(bounds.half_area());
                let (mut straight, mut curved) = (0.0, 0.0);
                for MotionBoxes { ends, curve } in leaves {
                    for elapsed in SEEN_AT {
                        straight += area(between(ends[0], ends[1], elapsed));
                        let [a, b, c] = *curve;
                        let (first, second) = (between(a, b, elapsed), between(b, c, elapsed));
                        curved += area(between(first, second, elapsed));
                    }
                }
                if curved < CURVES_PAY * straight {
                    Self::Curved
                } else {
                    Self::Straight
                }
            }
        }
    }
}

fn between(a: Aabb, b: Aabb, elapsed: f32) -> Aabb {
    Aabb {
        min: a.min.lerp(b.min, elapsed),
        max: a.max.lerp(b.max, elapsed),
    }
}

/// How much wider than their leaves' boxes control boxes have to be, so that the curve's rounding leaves
/// nothing out.
pub(super) fn curve_pad(leaves: &[MotionBoxes]) -> f32 {
    let largest = leaves
        .par_iter()
        .map(|boxes| {
            let largest = |bounds: &Aabb| bounds.min.abs().max(bounds.max.abs()).max_element();
            boxes.curve.iter().map(largest).fold(0.0, f32::max)
        })
        .reduce(|| 0.0, f32::max);
    CURVE_ROUNDING * largest
}

/// E = 2B₁ − B₀ − B₂ of a node, rounded outwards; 0 for children that do not exist.
pub(super) fn bulge([open, control, close]: [&Faces; 3]) -> Faces {
    let mut bulge = [[0.0; 8]; 6];
    for row in 0..6 {
        for slot in 0..8 {
            if control[row][slot].abs() == Node::FAR[0][0] {
                continue;
            }
            let ends = f64::from(open[row][slot]) + f64::from(close[row][slot]);
            let exact = 2.0 * f64::from(control[row][slot]) - ends;
            let nearest = exact as f32;
            bulge[row][slot] = if row < 3 {
                nearest.next_down()
            } else {
                nearest.next_up()
            };
        }
    }
    bulge
}

/// How a node's boxes move.
#[derive(Debug, Clone, Copy)]
pub struct MovingFaces<'a> {
    /// When the shutter opens.
    pub open: &'a Faces,
    /// When it closes; `None` where nothing moves.
    pub close: Option<&'a Faces>,
    /// How far the way bulges out between; `None` where it is straight.
    pub bulge: Option<&'a Faces>,
}

/// A part of the shutter that is over, as boxes count it.
#[derive(Debug, Clone, Copy)]
pub struct Elapsed<N> {
    /// The part u, from 0 to 1.
    part: N,
    /// u(1 − u).
    bent: N,
}

impl<N: Number> Elapsed<N> {
    /// `part` and one less it.
    #[inline(always)]
    pub fn new(part: N, rest: N) -> Self {
        Self {
            part,
            bent: part * rest,
        }
    }

    /// A face on the straight way between where it is when the shutter opens and when it closes.
    #[inline(always)]
    pub fn straight(&self, open: N, close: N) -> N {
        Number::mul_add(close - open, self.part, open)
    }

    /// The same on a curve that bulges out from there.
    #[inline(always)]
    pub fn bent(&self, straight: N, bulge: N) -> N {
        Number::mul_add(bulge, self.bent, straight)
    }
}

impl MovingFaces<'_> {
    /// Straight ways that hold the boxes at all times: faces when the shutter opens and when it closes.
    pub fn straightened(&self) -> [Faces; 2] {
        let close = self.close.unwrap_or(self.open);
        let mut ends = [*self.open, *close];
        let Some(bulge) = self.bulge else {
            return ends;
        };
        for end in &mut ends {
            for row in 0..6 {
                for slot in 0..8 {
                    // u(1 − u) is at most a quarter.
                    let most = 0.25 * bulge[row][slot];
                    end[row][slot] = if row < 3 {
                        (end[row][slot] + most.min(0.0)).next_down()
                    } else {
                        (end[row][slot] + most.max(0.0)).next_up()
                    };
                }
            }
        }
        ends
    }
}
