//! Metaballs against boxes and each other, and how far their surface can reach (§5.1.2, §5.3).
//!
//! Where n metaballs of weight 1 sum to T, one of them has at least T/n. So some contributor i of every
//! surface point has wᵢk(qᵢ) ≥ T·wᵢ/Σw there: qᵢ ≤ k⁻¹(T/Σw). The paper's r_max is R_K·√q for the
//! largest R_K; Rᵢ·√q is the same for equal radii, no larger otherwise, and holds for ellipsoids too.

use crate::field::BlobField;
use crate::math::aabb::Aabb;
use glam::Vec3;

/// Part of T and of a reach left for rounding.
const SLACK: f64 = 1e-4;

/// One metaball while the tree is built.
#[derive(Debug, Clone, Copy)]
pub(super) struct Member {
    pub(super) center: Vec3,
    /// Half extents of the support.
    pub(super) half: Vec3,
    pub(super) index: u32,
}

impl Member {
    pub(super) fn of(field: &BlobField, i: usize) -> Self {
        Self {
            center: field.center(i),
            half: Vec3::from_array(field.shapes.half_extents(i)),
            index: i as u32,
        }
    }

    /// Box around the support scaled by `scale`.
    pub(super) fn scaled_box(&self, scale: f32) -> Aabb {
        Aabb {
            min: self.center - self.half * scale,
            max: self.center + self.half * scale,
        }
    }

    pub(super) fn support_box(&self) -> Aabb {
        self.scaled_box(1.0)
    }
}

/// Whether supports meet: exact for balls, by their boxes for ellipsoids.
#[derive(Debug, Clone, Copy)]
pub(super) struct Overlap {
    pub(super) round: bool,
}

impl Overlap {
    /// Whether the support scaled by `scale` reaches into a box.
    pub(super) fn reaches(self, member: &Member, scale: f32, bounds: Aabb) -> bool {
        let nearest = member.center.clamp(bounds.min, bounds.max);
        let off = nearest - member.center;
        let half = member.half * scale;
        if self.round {
            off.length_squared() <= half.x * half.x
        } else {
            off.abs().cmple(half).all()
        }
    }

    /// Whether two supports, the second scaled by `scale`, meet.
    pub(super) fn meet(self, a: &Member, b: &Member, scale: f32) -> bool {
        let off = a.center - b.center;
        let half = a.half + b.half * scale;
        if self.round {
            off.length_squared() <= half.x * half.x
        } else {
            off.abs().cmple(half).all()
        }
    }
}

/// How far a surface can reach from the metaballs that make it, in parts of their supports; `None`
/// where their weights cannot sum to T at all. Weights must not be negative.
pub(super) fn surface_reach<'a>(
    field: &BlobField,
    members: impl Iterator<Item = &'a Member>,
) -> Option<f32> {
    let total: f64 = members
        .map(|member| f64::from(field.weights[member.index as usize]))
        .sum();
    let share = f64::from(field.threshold) * (1.0 - SLACK) / total;
    let q = field.kernel.q_at(share)?;
    Some((q.sqrt() * (1.0 + SLACK)).min(1.0) as f32)
}

/// `bounds` cut to what the members' supports, scaled by `scale`, reach.
pub(super) fn fitted<'a>(
    bounds: Aabb,
    members: impl Iterator<Item = &'a Member>,
    scale: f32,
) -> Aabb {
    let around = members.fold(Aabb::EMPTY, |around, member| {
        around.union(member.scaled_box(scale))
    });
    Aabb {
        min: bounds.min.max(around.min),
        max: bounds.max.min(around.max),
    }
}

/// Removes the split metaballs that no surface in `bounds` feels (§5.3.2): neither can one of them be
/// the contributor of the argument above within the box, nor does its support meet the reach of any
/// other metaball that can.
pub(super) fn discard(
    overlap: Overlap,
    own: &[Member],
    split: &mut Vec<Member>,
    bounds: Aabb,
    reach: f32,
) {
    let all: Vec<Member> = own.iter().chain(&*split).copied().collect();
    split.retain(|member| {
        overlap.reaches(member, reach, bounds)
            || all
                .iter()
                .any(|other| other.index != member.index && overlap.meet(member, other, reach))
    });
}
