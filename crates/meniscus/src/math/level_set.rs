//! A level set F(x, t) = T around one of its points: how it is curved, how it moves, and what that does
//! to the hit of a ray.
//!
//! The outward normal is n = −∇F/|∇F|. Formulas: Goldman, "Curvature formulas for implicit curves and
//! surfaces" (2005), eqs. 4.1 and 4.2; Ray Tracing Gems II, §35.2; the rest follows from dF = 0.

use glam::{DAffine3, DMat3, DVec3};

/// The derivatives of F at a point of the level set: to second order in space, to first in time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LevelSet {
    /// ∇F, in 1/length.
    pub gradient: DVec3,
    /// ∇∇F, symmetric, in 1/length².
    pub hessian: DMat3,
    /// ∂F/∂t where the point stays, in 1/second.
    pub rate: f64,
    /// ∂∇F/∂t where the point stays, in 1/(length · second).
    pub gradient_rate: DVec3,
}

/// How a place changes together with the normal there.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct HitChange {
    /// Change of the position.
    pub position: DVec3,
    /// Change of the unit outward normal; at right angles to it.
    pub normal: DVec3,
}

impl LevelSet {
    /// A plane at rest with this outward normal.
    pub fn flat(normal: DVec3) -> Self {
        Self {
            gradient: -normal,
            hessian: DMat3::ZERO,
            rate: 0.0,
            gradient_rate: DVec3::ZERO,
        }
    }

    /// Unit outward normal; 0 where the gradient is 0, and so are all derivatives there.
    pub fn normal(&self) -> DVec3 {
        -self.gradient.normalize_or_zero()
    }

    /// The change of −∇F/|∇F| with a change of ∇F.
    fn normal_change(&self, gradient_change: DVec3) -> DVec3 {
        let steepness = self.gradient.length();
        if steepness == 0.0 {
            return DVec3::ZERO;
        }
        let n = self.normal();
        (n * n.dot(gradient_change) - gradient_change) / steepness
    }

    /// Shape operator S in 1/length: the normal changes by S·d along a small tangent step d. Symmetric,
    /// 0 along the normal; its other two eigenvalues are the principal curvatures, positive where the
    /// surface bulges outwards.
    pub fn shape_operator(&self) -> DMat3 {
        let n = self.normal();
        let outer = DMat3::from_cols(n * n.x, n * n.y, n * n.z);
        let tangent = DMat3::IDENTITY - outer;
        let steepness = self.gradient.length();
        if steepness == 0.0 {
            return DMat3::ZERO;
        }
        tangent * self.hessian * tangent * (-1.0 / steepness)
    }

    /// Mean of the two principal curvatures, in 1/length: 1/r on a ball.
    pub fn mean_curvature(&self) -> f64 {
        let steepness = self.gradient.length();
        if steepness == 0.0 {
            return 0.0;
        }
        let n = self.normal();
        let hessian = &self.hessian;
        let trace = hessian.x_axis.x + hessian.y_axis.y + hessian.z_axis.z;
        -0.5 * (trace - n.dot(*hessian * n)) / steepness
    }

    /// Product of the two principal curvatures, in 1/length²: 1/r² on a ball.
    pub fn gaussian_curvature(&self) -> f64 {
        let steepness = self.gradient.length();
        if steepness == 0.0 {
            return 0.0;
        }
        let n = self.normal();
        // The adjugate of a symmetric matrix has the cross products of its columns for rows.
        let [a, b, c] = [
            self.hessian.x_axis,
            self.hessian.y_axis,
            self.hessian.z_axis,
        ];
        let adjugate_n = b.cross(c) * n.x + c.cross(a) * n.y + a.cross(b) * n.z;
        n.dot(adjugate_n) / (steepness * steepness)
    }

    /// Speed of the surface along its outward normal, in lengths per second.
    pub fn normal_speed(&self) -> f64 {
        let steepness = self.gradient.length();
        if steepness == 0.0 {
            0.0
        } else {
            self.rate / steepness
        }
    }

    /// ∂n/∂t where the point stays, in 1/second.
    pub fn normal_rate(&self) -> DVec3 {
        self.normal_change(self.gradient_rate)
    }

    /// ∂t/∂time of the hit of a ray that stays, in units of t (lengths of `direction`) per second; 0
    /// where the ray touches the surface.
    pub fn hit_rate(&self, direction: DVec3) -> f64 {
        let along = self.gradient.dot(direction);
        if along == 0.0 {
            0.0
        } else {
            -self.rate / along
        }
    }

    /// How the hit of a ray of this direction changes when the ray's point at the same t moves by
    /// `point_change` and `secs` pass, to first order: with (0, 1) it is the change per second at a ray
    /// that stays. 0 where the ray touches the surface.
    pub fn hit_change(&self, direction: DVec3, point_change: DVec3, secs: f64) -> HitChange {
        let along = self.gradient.dot(direction);
        if along == 0.0 {
            return HitChange::default();
        }
        let t_change = -(self.gradient.dot(point_change) + self.rate * secs) / along;
        let position = point_change + direction * t_change;
        HitChange {
            position,
            normal: self.normal_change(self.hessian * position + self.gradient_rate * secs),
        }
    }

    /// The level set of F(M(t)·x, t) for an affine map M, whose change per second is `rate`, at the point
    /// x: from an object's space to the world's, where `map` is object from world.
    #[must_use]
    pub fn seen_through(&self, map: &DAffine3, rate: &DAffine3, x: DVec3) -> Self {
        let m = map.matrix3;
        let covector = m.transpose();
        let drift = rate.transform_point3(x);
        Self {
            gradient: covector * self.gradient,
            hessian: covector * self.hessian * m,
            rate: self.rate + self.gradient.dot(drift),
            gradient_rate: covector * (self.gradient_rate + self.hessian * drift)
                + rate.matrix3.transpose() * self.gradient,
        }
    }
}

/// The change per second of an affine map that does not change.
pub const AT_REST: DAffine3 = DAffine3 {
    matrix3: DMat3::ZERO,
    translation: DVec3::ZERO,
};

#[cfg(test)]
mod tests {
    use super::*;

    fn still(gradient: DVec3, hessian: DMat3) -> LevelSet {
        LevelSet {
            gradient,
            hessian,
            rate: 0.0,
            gradient_rate: DVec3::ZERO,
        }
    }

    #[test]
    fn ball_cylinder_and_saddle() {
        let near = |found: &LevelSet, mean: f64, gaussian: f64| {
            let off = (found.mean_curvature() - mean).abs()
                + (found.gaussian_curvature() - gaussian).abs();
            assert!(off < 1e-12, "{found:?} instead of {mean}, {gaussian}");
            // The shape operator has trace 2H and principal minors that sum to K.
            let s = found.shape_operator();
            let trace = s.x_axis.x + s.y_axis.y + s.z_axis.z;
            let square = s * s;
            let trace_of_square = square.x_axis.x + square.y_axis.y + square.z_axis.z;
            let minors = 0.5 * (trace * trace - trace_of_square);
            assert!((trace - 2.0 * mean).abs() + (minors - gaussian).abs() < 1e-12);
            assert!((s * found.normal()).length() < 1e-12);
        };
        let x = DVec3::new(0.6, -1.2, 1.3);
        let r = x.length();
        // F = −|x|⁴: another function with the same level sets as −|x|².
        let outer = DMat3::from_cols(x * x.x, x * x.y, x * x.z);
        let hessian = (DMat3::IDENTITY * x.length_squared() + outer * 2.0) * -4.0;
        let ball = still(x * (-4.0 * x.length_squared()), hessian);
        near(&ball, 1.0 / r, 1.0 / (r * r));
        let round = DMat3::from_diagonal(DVec3::new(-2.0, -2.0, 0.0));
        let cylinder = still(DVec3::new(-2.0 * 0.25, 0.0, 0.0), round);
        near(&cylinder, 0.5 / 0.25, 0.0);
        // z = (a x² + b y²)/2 seen from above, F = that − z.
        let saddle = DMat3::from_diagonal(DVec3::new(3.0, -2.0, 0.0));
        near(&still(DVec3::NEG_Z, saddle), -0.5, -6.0);
        near(&LevelSet::flat(DVec3::Y), 0.0, 0.0);
    }

    #[test]
    fn nothing_changes_where_there_is_no_gradient_or_no_crossing() {
        let nowhere = still(DVec3::ZERO, DMat3::IDENTITY);
        assert_eq!(nowhere.shape_operator(), DMat3::ZERO);
        assert_eq!(nowhere.normal(), DVec3::ZERO);
        assert_eq!(nowhere.normal_rate(), DVec3::ZERO);
        assert_eq!(
            (nowhere.mean_curvature(), nowhere.normal_speed()),
            (0.0, 0.0)
        );
        let floor = LevelSet {
            rate: 1.0,
            ..LevelSet::flat(DVec3::Y)
        };
        assert_eq!(floor.hit_rate(DVec3::X), 0.0);
        assert_eq!(
            floor.hit_change(DVec3::X, DVec3::Z, 1.0),
            HitChange::default()
        );
    }

    #[test]
    fn a_rising_floor_is_met_earlier() {
        // F = speed·t − y: y = speed·t.
        let floor = LevelSet {
            rate: 3.0,
            ..LevelSet::flat(DVec3::Y)
        };
        assert_eq!(floor.normal_speed(), 3.0);
        assert_eq!(floor.hit_rate(DVec3::NEG_Y * 2.0), -1.5);
        let change = floor.hit_change(DVec3::NEG_Y * 2.0, DVec3::X, 1.0);
        assert_eq!(change.position, DVec3::new(1.0, 3.0, 0.0));
        assert_eq!(change.normal, DVec3::ZERO);
    }
}
