//! How rays change from pixel to pixel and with time, and what mirrors and clear surfaces make of that
//! (Igehy, "Tracing Ray Differentials", SIGGRAPH 1999; time is one more variable).

use super::level_set::{HitChange, LevelSet};
use glam::{DVec3, Vec3};

/// How a ray of unit direction changes by the film's x and y (per pixel) and by time (per second), in
/// world space.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RayDifferential {
    /// Changes of the origin.
    pub origin: [Vec3; 3],
    /// Changes of the direction, at right angles to it.
    pub direction: [Vec3; 3],
}

/// Seconds that pass with each of the variables.
const SECS: [f64; 3] = [0.0, 0.0, 1.0];

impl RayDifferential {
    /// The same rays, seen to start at their parameter `t`.
    #[must_use]
    pub fn advanced(&self, t: f64) -> Self {
        Self {
            origin: [0, 1, 2].map(|k| self.point_change(k, t).as_vec3()),
            direction: self.direction,
        }
    }

    fn point_change(&self, variable: usize, t: f64) -> DVec3 {
        self.origin[variable].as_dvec3() + self.direction[variable].as_dvec3() * t
    }

    /// How the hit at parameter `t` changes by each variable: on the surface for x and y, with the
    /// surface and the ray both moving for time.
    pub fn at_hit(&self, direction: DVec3, t: f64, surface: &LevelSet) -> [HitChange; 3] {
        [0, 1, 2].map(|k| surface.hit_change(direction, self.point_change(k, t), SECS[k]))
    }

    /// Behind a mirror: `normal` is the unit normal on the ray's side, and `hits` are the changes there
    /// with the normals on that side (Igehy 1999, eqs. 15 and 16).
    #[must_use]
    pub fn reflected(&self, direction: DVec3, normal: DVec3, hits: &[HitChange; 3]) -> Self {
        self.turned(hits, |change, hit| {
            let along = direction.dot(normal);
            let along_change = change.dot(normal) + direction.dot(hit.normal);
            change - (hit.normal * along + normal * along_change) * 2.0
        })
    }

    /// Behind the boundary of two clear media; `eta` is the index on the ray's side over that beyond
    /// (Igehy 1999, eqs. 17 to 19). `None` where all is reflected.
    #[must_use]
    pub fn refracted(
        &self,
        direction: DVec3,
        normal: DVec3,
        eta: f64,
        hits: &[HitChange; 3],
    ) -> Option<Self> {
        let along = direction.dot(normal);
        let squared = 1.0 - eta * eta * (1.0 - along * along);
        if squared <= 0.0 {
            return None;
        }
        let beyond = -squared.sqrt();
        let bend = eta * along - beyond;
        let bend_slope = eta - eta * eta * along / beyond;
        Some(self.turned(hits, |change, hit| {
            let along_change = change.dot(normal) + direction.dot(hit.normal);
            change * eta - hit.normal * bend - normal * (bend_slope * along_change)
        }))
    }

    fn turned(&self, hits: &[HitChange; 3], turn: impl Fn(DVec3, &HitChange) -> DVec3) -> Self {
        Self {
            origin: [0, 1, 2].map(|k| hits[k].position.as_vec3()),
            direction: [0, 1, 2].map(|k| turn(self.direction[k].as_dvec3(), &hits[k]).as_vec3()),
        }
    }
}

#[cfg(test)]
mod tests;
