//! The float64 reference: what every engine's answer is compared with.
//!
//! It takes the packed f32 numbers of a [`BlobField`] as exact. Along a ray each blob's q is a parabola
//! between its entry and its exit. Stretches where the sum of each blob's own bounds decides the sign
//! of F − T are settled as they are; what is left is halved at the events in it, until F − T is one
//! polynomial, which goes through as many sampled values as it has coefficients and is bisected in
//! Bernstein form. Nothing of this is shared with the engines.

mod bernstein;
mod index;
pub mod marching;
mod profile;

use crate::tolerance::FIELD;
use bernstein::Interpolation;
use glam::DVec3;
use index::Index;
use meniscus::field::BlobField;
use meniscus::intersect::Crossing;
use meniscus::math::ray::{Ray, Side};
use profile::Profile;

/// Answers any question about one field in float64.
#[derive(Debug)]
pub struct Oracle<'a> {
    field: &'a BlobField,
    time_secs: f64,
    index: Index,
    interpolation: Interpolation,
    middle: DVec3,
    diameter: f64,
    largest_coordinate: f64,
    power_coefficients: &'static [f64],
}

/// The field at a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// F.
    pub value: f64,
    /// Σ|wᵢ|kᵢ.
    pub absolute: f64,
    /// −∇F.
    pub outward: DVec3,
    /// Σ|wᵢ∇kᵢ|.
    pub absolute_slope: f64,
    /// Largest |wᵢ|kᵢ.
    pub strongest: f64,
}

/// A ray in the field's local coordinates, in unit length.
#[derive(Debug, Clone, Copy)]
struct Line {
    o: DVec3,
    d: DVec3,
    shift: f64,
    length: f64,
}

impl Line {
    fn s(&self, t: f64) -> f64 {
        t * self.length - self.shift
    }

    fn t(&self, s: f64) -> f64 {
        (s + self.shift) / self.length
    }
}

impl<'a> Oracle<'a> {
    /// An oracle over `field`.
    pub fn new(field: &'a BlobField) -> Self {
        Self::at(field, 0.0)
    }

    /// An oracle over `field` at a time within its shutter, in seconds relative to the frame. What rays
    /// say of their time does not count.
    pub fn at(field: &'a BlobField, time_secs: f64) -> Self {
        let power_coefficients = field.kernel.coefficients_in_g();
        let bounds = field.bounds();
        let (min, max) = if bounds.is_empty() {
            (DVec3::ZERO, DVec3::ZERO)
        } else {
            (bounds.min.as_dvec3(), bounds.max.as_dvec3())
        };
        Self {
            field,
            time_secs,
            index: Index::build(field, time_secs),
            interpolation: Interpolation::of_degree(2 * (power_coefficients.len() - 1)),
            middle: 0.5 * (min + max),
            diameter: (max - min).length(),
            largest_coordinate: min.abs().max(max.abs()).max_element(),
            power_coefficients,
        }
    }

    /// The field.
    pub fn field(&self) -> &'a BlobField {
        self.field
    }

    /// Diagonal of the box around all supports.
    pub fn diameter(&self) -> f64 {
        self.diameter
    }

    /// Largest local coordinate of that box.
    pub fn largest_coordinate(&self) -> f64 {
        self.largest_coordinate
    }

    fn line(&self, ray: &Ray) -> Line {
        let scale = ray.direction.abs().max_element();
        let short = ray.direction / scale;
        let d = short / short.length();
        let origin = ray.origin - self.field.origin;
        let shift = (self.middle - origin).dot(d);
        Line {
            o: origin + d * shift,
            d,
            shift,
            length: scale * short.length(),
        }
    }

    fn profile(&self, line: &Line, (from, to): (f64, f64), shift: f64) -> Profile<'_> {
        let threshold = f64::from(self.field.threshold) + shift;
        let mut profile = Profile::new(self.field, threshold, &self.interpolation);
        let mut add = |i: u32| {
            let blob = (
                i as usize,
                center_at(self.field, i as usize, self.time_secs),
            );
            profile.add(self.field, blob, (line.o, line.d));
        };
        self.index
            .near_segment((line.o, line.d), (from, to), &mut add);
        profile
    }

    /// Where F − T changes sign in `[from, to]`, at most `count` times, and whether F > T at `from`.
    fn changes(
        &self,
        line: &Line,
        (from, to): (f64, f64),
        count: usize,
        shift: f64,
    ) -> (bool, Vec<Crossing>) {
        let profile = self.profile(line, (from, to), shift);
        let mut above_first = None;
        let mut found = Vec::new();
        profile.signs(from, to, &mut |s, above| {
            if above_first.is_none() {
                above_first = Some(above);
            } else {
                found.push(Crossing {
                    t: line.t(s),
                    entering: above,
                });
            }
            found.len() < count
        });
        (above_first.unwrap_or(false), found)
    }

    /// Every sign change of F − T on the ray, in order, whatever its stated side, and whether F > T at
    /// its start. `None` where the ray is no ray.
    pub fn sign_changes(&self, ray: &Ray) -> Option<(bool, Vec<Crossing>)> {
        ray.is_traceable().then(|| {
            let line = self.line(ray);
            self.changes(
                &line,
                (line.s(ray.t_min), line.s(ray.t_max)),
                usize::MAX,
                0.0,
            )
        })
    }

    /// Every crossing that counts: with a stated side, those after the field has come to that side.
    pub fn crossings(&self, ray: &Ray) -> Vec<Crossing> {
        let Some((above, mut found)) = self.sign_changes(ray) else {
            return Vec::new();
        };
        if differs(ray.side, above) && !found.is_empty() {
            found.remove(0);
        }
        found
    }

    /// The first crossing that counts. `hint` is where to expect it: a guess that only saves time.
    pub fn first(&self, ray: &Ray, hint: Option<f64>) -> Option<Crossing> {
        self.first_at(ray, hint, 0.0)
    }

    /// The band of excuse, where the ray would cross the surface of a threshold that much higher or
    /// lower.
    pub fn nearly_occluded(&self, ray: &Ray) -> Option<f64> {
        let band = FIELD * f64::from(self.field.threshold).max(1.0);
        [-band, band]
            .iter()
            .any(|&shift| self.first_at(ray, None, shift).is_some())
            .then_some(band)
    }

    fn first_at(&self, ray: &Ray, hint: Option<f64>, shift: f64) -> Option<Crossing> {
        if !ray.is_traceable() {
            return None;
        }
        let line = self.line(ray);
        let (from, to) = (line.s(ray.t_min), line.s(ray.t_max));
        let near = hint.map(|t| line.s(t) + 0.01 * f64::from(self.field.spacing));
        for end in near
            .filter(|&near| near > from && near < to)
            .into_iter()
            .chain([to])
        {
            let (above, found) = self.changes(&line, (from, end), 2, shift);
            let rank = usize::from(differs(ray.side, above));
            if let Some(&crossing) = found.get(rank) {
                return Some(crossing);
            }
        }
        None
    }

    /// F − T and the band of excuse at parameter `t` of the ray.
    pub fn excess(&self, ray: &Ray, t: f64) -> (f64, f64) {
        let line = self.line(ray);
        let s = line.s(t);
        let profile = self.profile(&line, (s, s), 0.0);
        (profile.excess(s), profile.band(s))
    }

    /// Whether |F − T| stays in the band of excuse between two parameters of the ray, and the largest
    /// |F − T| that was met.
    pub fn stays_in_band(&self, ray: &Ray, from: f64, to: f64) -> (bool, f64) {
        let line = self.line(ray);
        let (a, b) = (line.s(from), line.s(to));
        let (a, b) = (a.min(b), a.max(b));
        self.profile(&line, (a, b), 0.0).stays_in_band(a, b)
    }

    /// The field at an object-space point.
    pub fn sample(&self, point: DVec3) -> Sample {
        let mut sample = Sample {
            value: 0.0,
            absolute: 0.0,
            outward: DVec3::ZERO,
            absolute_slope: 0.0,
            strongest: 0.0,
        };
        self.each_at(point, |_, w, k, slope| {
            sample.value += w * k;
            sample.absolute += w.abs() * k;
            sample.outward += slope * w;
            sample.absolute_slope += slope.length() * w.abs();
            sample.strongest = sample.strongest.max(w.abs() * k);
        });
        sample
    }

    /// |wᵢ|kᵢ of blob `i` at an object-space point.
    pub fn strength(&self, i: u32, point: DVec3) -> f64 {
        let mut strength = 0.0;
        self.each_at(point, |index, w, k, _| {
            if index == i {
                strength = w.abs() * k;
            }
        });
        strength
    }

    /// Calls `visit(i, wᵢ, kᵢ, −∇kᵢ)` for every blob that reaches the point.
    fn each_at(&self, point: DVec3, mut visit: impl FnMut(u32, f64, f64, DVec3)) {
        let x = point - self.field.origin;
        let coefficients = self.power_coefficients;
        self.index.near_point(x, &mut |index| {
            let i = index as usize;
            let y = self
                .field
                .shapes
                .transform(i, x - center_at(self.field, i, self.time_secs));
            let g = 1.0 - y.length_squared();
            if g > 0.0 {
                let powers = coefficients.iter().enumerate();
                let k = powers.clone().map(|(p, c)| c * g.powi(p as i32)).sum();
                let slope: f64 = powers
                    .skip(1)
                    .map(|(p, c)| c * p as f64 * g.powi(p as i32 - 1))
                    .sum();
                let outward = self.field.shapes.transform_transposed(i, y) * (2.0 * slope);
                visit(index, f64::from(self.field.weights[i]), k, outward);
            }
        });
    }
}

/// Where blob `i` stands at a time, local.
fn center_at(field: &BlobField, i: usize, time_secs: f64) -> DVec3 {
    let [x, y, z] = field.centers[i].map(f64::from);
    let place = DVec3::new(x, y, z);
    let Some(motion) = &field.motion else {
        return place;
    };
    let rate = |rate: [f32; 3]| DVec3::from_array(rate.map(f64::from));
    place
        + rate(motion.velocities[i]) * time_secs
        + rate(motion.half_accelerations[i]) * (time_secs * time_secs)
}

fn differs(side: Side, above: bool) -> bool {
    match side {
        Side::Unknown => false,
        Side::Outside => above,
        Side::Inside => !above,
    }
}

#[cfg(test)]
mod tests;
