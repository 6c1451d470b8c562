//! Smooth ways through keyframes.

use glam::DVec3;

/// Where a time lies among sorted ones: the interval and the part of it that is over. Before the first
/// and after the last it is that end.
///
/// # Panics
/// If there are no times.
pub fn place(times: &[f64], time: f64) -> (usize, f64) {
    let last = times.len() - 1;
    if last == 0 || time <= times[0] {
        return (0, 0.0);
    }
    if time >= times[last] {
        return (last - 1, 1.0);
    }
    let after = times.partition_point(|&key| key <= time).clamp(1, last);
    let (start, end) = (times[after - 1], times[after]);
    (after - 1, (time - start) / (end - start))
}

/// A cubic Hermite curve through points at given times, whose velocity at a point is that between its
/// neighbours (Catmull & Rom 1974, for uneven times): straight and even through two points. It stands
/// still before the first time and after the last.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    times: Vec<f64>,
    points: Vec<DVec3>,
    velocities: Vec<DVec3>,
}

impl Curve {
    /// Through `points` at `times`, which rise.
    ///
    /// # Panics
    /// If there are no points, or not one per time.
    pub fn new(times: &[f64], points: Vec<DVec3>) -> Self {
        assert!(!points.is_empty() && points.len() == times.len());
        let last = points.len() - 1;
        let velocity = |i: usize| {
            let (before, after) = (i.saturating_sub(1), (i + 1).min(last));
            match after - before {
                0 => DVec3::ZERO,
                _ => (points[after] - points[before]) / (times[after] - times[before]),
            }
        };
        Self {
            times: times.to_vec(),
            velocities: (0..=last).map(velocity).collect(),
            points,
        }
    }

    /// The Bézier control points of interval `i`; one point alone is four equal ones.
    fn controls(&self, i: usize) -> [DVec3; 4] {
        let next = (i + 1).min(self.points.len() - 1);
        let third = (self.times[next] - self.times[i]) / 3.0;
        let [start, end] = [self.points[i], self.points[next]];
        [
            start,
            start + self.velocities[i] * third,
            end - self.velocities[next] * third,
            end,
        ]
    }

    /// The point at a time.
    pub fn at(&self, time: f64) -> DVec3 {
        let (i, u) = place(&self.times, time);
        let [a, b, c, d] = self.controls(i);
        let v = 1.0 - u;
        a * (v * v * v) + b * (3.0 * v * v * u) + c * (3.0 * v * u * u) + d * (u * u * u)
    }

    /// The velocity at a time, per second; at the ends that of the curve, not of the rest.
    pub fn velocity(&self, time: f64) -> DVec3 {
        let (i, u) = place(&self.times, time);
        let Some(length) = self.length(i) else {
            return DVec3::ZERO;
        };
        let [a, b, c, d] = self.controls(i);
        let v = 1.0 - u;
        ((b - a) * (v * v) + (c - b) * (2.0 * u * v) + (d - c) * (u * u)) * (3.0 / length)
    }

    /// A bound of the speed from one time to a later one: that of the control points of the intervals.
    pub fn fastest(&self, from: f64, to: f64) -> f64 {
        let [(first, _), (last, _)] = [from, to].map(|time| place(&self.times, time));
        (first..=last).fold(0.0, |fastest, i| {
            let [a, b, c, d] = self.controls(i);
            let step = (b - a).length().max((c - b).length()).max((d - c).length());
            self.length(i)
                .map_or(fastest, |length| f64::max(fastest, 3.0 * step / length))
        })
    }

    /// Seconds that interval `i` takes.
    fn length(&self, i: usize) -> Option<f64> {
        Some(self.times.get(i + 1)? - self.times[i])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TIMES: [f64; 4] = [-1.0, 0.0, 0.5, 3.0];

    fn curve() -> Curve {
        let points = [
            DVec3::ZERO,
            DVec3::new(1.0, 2.0, 0.0),
            DVec3::new(1.0, -1.0, 2.0),
            DVec3::X * 5.0,
        ];
        Curve::new(&TIMES, points.to_vec())
    }

    #[test]
    fn curves_go_through_their_points_smoothly_and_rest_outside() {
        let curve = curve();
        for (time, point) in TIMES.iter().zip(&curve.points) {
            assert!(curve.at(*time).distance(*point) < 1e-12);
            let h = 1e-7;
            let [before, after] = [-h, h].map(|h| curve.velocity(time + h));
            assert!(before.distance(after) < 1e-4 || *time == -1.0 || *time == 3.0);
        }
        assert_eq!(curve.at(-9.0), curve.points[0]);
        assert_eq!(curve.at(9.0), curve.points[3]);
        let h = 1e-6;
        let mut fastest = 0.0_f64;
        for i in 1..400 {
            let time = -1.0 + 0.01 * f64::from(i);
            let difference = (curve.at(time + h) - curve.at(time - h)) / (2.0 * h);
            let velocity = curve.velocity(time);
            assert!(difference.distance(velocity) < 1e-3 * (1.0 + velocity.length()));
            fastest = fastest.max(velocity.length());
        }
        let bound = curve.fastest(-1.0, 3.0);
        assert!(
            fastest <= bound && bound < 4.0 * fastest,
            "{fastest} {bound}"
        );
    }

    #[test]
    fn two_points_are_a_straight_even_way_and_one_is_a_rest() {
        let two = Curve::new(&[0.0, 2.0], vec![DVec3::X, DVec3::new(3.0, 4.0, 0.0)]);
        assert!(two.at(0.5).distance(DVec3::new(1.5, 1.0, 0.0)) < 1e-12);
        assert!(two.velocity(1.3).distance(DVec3::new(1.0, 2.0, 0.0)) < 1e-12);
        let one = Curve::new(&[1.0], vec![DVec3::Y]);
        assert_eq!((one.at(5.0), one.velocity(1.0)), (DVec3::Y, DVec3::ZERO));
        assert_eq!(one.fastest(0.0, 9.0), 0.0);
        assert_eq!(place(&[1.0], 3.0), (0, 0.0));
    }
}
