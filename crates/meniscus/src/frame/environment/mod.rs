//! An image of everything around the scene, by latitude and longitude, that light comes from.

mod read;

pub use read::{EnvironmentError, MAX_TEXELS};

use crate::math::sampling::Distribution;
use glam::{DQuat, DVec3, Vec3};
use std::f64::consts::{PI, TAU};

/// Radiance from every direction, and how to draw bright directions from it.
#[derive(Debug, Clone, PartialEq)]
pub struct Environment {
    width: usize,
    height: usize,
    /// Row by row from the zenith down.
    texels: Vec<[f32; 3]>,
    /// Directions of the image's right, the zenith, and the image's middle.
    axes: [DVec3; 3],
    /// Of rows, by the light that comes from them.
    rows: Distribution,
    /// Of the texels in each row.
    columns: Vec<Distribution>,
    /// Mean radiance over the sphere.
    mean: Vec3,
}

impl Environment {
    /// The environment of `texels`, row by row from the zenith down, each row once around the
    /// horizon. With no `rotation` (radians, around `up`) the middle of a row lies in direction
    /// `forward`, and columns to the right of it to the right of who looks there.
    ///
    /// # Panics
    /// If the number of texels is not `width` times a height of at least 1.
    pub fn new(
        width: usize,
        texels: Vec<[f32; 3]>,
        [right, up, forward]: [DVec3; 3],
        rotation: f64,
    ) -> Self {
        assert!(
            width > 0 && !texels.is_empty() && texels.len().is_multiple_of(width),
            "whole rows"
        );
        let height = texels.len() / width;
        let texels: Vec<[f32; 3]> = texels
            .into_iter()
            .map(|texel| texel.map(|c| if c.is_finite() { c.max(0.0) } else { 0.0 }))
            .collect();
        let turn = DQuat::from_axis_angle(up, rotation);
        let mut mean = Vec3::ZERO;
        let mut columns = Vec::with_capacity(height);
        let mut row_weights = Vec::with_capacity(height);
        for y in 0..height {
            // Solid angle of a row: between its two circles of latitude.
            let [top, bottom] = [y, y + 1].map(|y| (PI * y as f64 / height as f64).cos());
            let solid = (top - bottom) / 2.0;
            // Between texels light is interpolated: a texel is as important as its neighbourhood.
            let weights = (0..width).map(|x| {
                let near = |dx: usize, dy: usize| {
                    let row = (y + dy).saturating_sub(1).min(height - 1);
                    luminance(Vec3::from_array(
                        texels[row * width + (x + width + dx - 1) % width],
                    ))
                };
                let own = near(1, 1);
                let all: f64 = (0..9).map(|i| near(i % 3, i / 3)).sum();
                0.5 * own + all / 18.0
            });
            let row = Distribution::new(weights);
            row_weights.push(row.total() / width as f64 * solid);
            columns.push(row);
            let sum: Vec3 = texels[y * width..(y + 1) * width]
                .iter()
                .map(|&texel| Vec3::from_array(texel))
                .sum();
            mean += sum * (solid / width as f64) as f32;
        }
        Self {
            width,
            height,
            texels,
            axes: [turn * right, up, turn * forward],
            rows: Distribution::new(row_weights.into_iter()),
            columns,
            mean,
        }
    }

    /// Mean radiance over all directions.
    pub fn mean(&self) -> Vec3 {
        self.mean
    }

    /// Columns and rows.
    pub fn size(&self) -> [usize; 2] {
        [self.width, self.height]
    }

    /// The image, row by row from the zenith down.
    pub fn texels(&self) -> &[[f32; 3]] {
        &self.texels
    }

    /// Directions of the image's right, the zenith, and the image's middle.
    pub fn axes(&self) -> [DVec3; 3] {
        self.axes
    }

    /// How rows are drawn, and the texels of each row.
    pub fn distributions(&self) -> (&Distribution, &[Distribution]) {
        (&self.rows, &self.columns)
    }

    /// Place of a unit direction in the image: column and row, as parts of width and height.
    fn place(&self, direction: DVec3) -> [f64; 2] {
        let [right, up, forward] = self.axes.map(|axis| axis.dot(direction));
        let u = 0.5 + right.atan2(forward) / TAU;
        let v = up.clamp(-1.0, 1.0).acos() / PI;
        [u, v]
    }

    /// Radiance from a unit direction, interpolated between texels.
    pub fn radiance(&self, direction: DVec3) -> Vec3 {
        let [u, v] = self.place(direction);
        let x = u * self.width as f64 - 0.5;
        let y = (v * self.height as f64 - 0.5).clamp(0.0, (self.height - 1) as f64);
        let left = x.floor();
        let above = y.floor();
        let [fx, fy] = [(x - left) as f32, (y - above) as f32];
        let column = |dx: i64| (left as i64 + dx).rem_euclid(self.width as i64) as usize;
        let row = |dy: usize| (above as usize + dy).min(self.height - 1);
        let texel =
            |dx: i64, dy: usize| Vec3::from_array(self.texels[row(dy) * self.width + column(dx)]);
        let upper = texel(0, 0).lerp(texel(1, 0), fx);
        let lower = texel(0, 1).lerp(texel(1, 1), fx);
        upper.lerp(lower, fy)
    }

    /// Draws a unit direction by brightness; its density per solid angle. `None` if all is dark.
    pub fn sample(&self, u: [f64; 2]) -> Option<(DVec3, f64)> {
        let (row, v, row_part) = self.rows.sample(u[1])?;
        let (column, h, column_part) = self.columns[row].sample(u[0])?;
        let [top, bottom] = [row, row + 1].map(|y| (PI * y as f64 / self.height as f64).cos());
        let cosine = top + (bottom - top) * v;
        let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
        let azimuth = ((column as f64 + h) / self.width as f64 - 0.5) * TAU;
        let [right, up, forward] = self.axes;
        let direction = (right * azimuth.sin() + forward * azimuth.cos()) * sine + up * cosine;
        let solid = (top - bottom) * TAU / self.width as f64;
        Some((direction.normalize(), row_part * column_part / solid))
    }

    /// Density with which [`Environment::sample`] draws a direction.
    pub fn density(&self, direction: DVec3) -> f64 {
        let [u, v] = self.place(direction);
        let row = ((v * self.height as f64) as usize).min(self.height - 1);
        let column = ((u * self.width as f64) as usize).min(self.width - 1);
        let [top, bottom] = [row, row + 1].map(|y| (PI * y as f64 / self.height as f64).cos());
        let solid = (top - bottom) * TAU / self.width as f64;
        self.rows.part(row) * self.columns[row].part(column) / solid
    }
}

/// Relative luminance of linear Rec. 709.
pub fn luminance(color: Vec3) -> f64 {
    f64::from(color.dot(Vec3::new(0.2126, 0.7152, 0.0722)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::sampling::{PixelSampler, uniform_sphere};

    const AXES: [DVec3; 3] = [DVec3::X, DVec3::Y, DVec3::NEG_Z];

    fn dim_with_a_lamp() -> Environment {
        let mut texels = vec![[0.1, 0.2, 0.3]; 32 * 16];
        texels[4 * 32 + 20] = [500.0, 400.0, 300.0];
        texels[9 * 32] = [f32::NAN, -3.0, 1.0];
        Environment::new(32, texels, AXES, 0.4)
    }

    #[test]
    fn directions_of_the_image_are_those_stated() {
        let mut texels = vec![[0.0; 3]; 8 * 4];
        texels[8 + 3] = [1.0; 3]; // left of the middle, above the horizon
        texels[8 + 4] = [1.0; 3];
        let environment = Environment::new(8, texels.clone(), AXES, 0.0);
        let up_ahead = DVec3::new(0.0, 0.38, -0.92).normalize();
        assert!(environment.radiance(up_ahead).x > 0.99);
        assert!(environment.radiance(-up_ahead).x < 0.01);
        // A quarter turn counterclockwise takes what was ahead (−Z) to the left (−X).
        let turned = Environment::new(8, texels, AXES, PI / 2.0);
        assert!(turned.radiance(DVec3::new(-0.92, 0.38, 0.0).normalize()).x > 0.99);
    }

    #[test]
    fn sampling_has_the_density_it_states_and_finds_the_mean() {
        let environment = dim_with_a_lamp();
        let (mut light, mut solid, mut mean) = (Vec3::ZERO, 0.0, Vec3::ZERO);
        let count = 8192;
        for i in 0..count {
            let mut sampler = PixelSampler::new([0, 0], i, 0);
            let (direction, density) = environment.sample(sampler.next_2d()).unwrap();
            assert!((direction.length() - 1.0).abs() < 1e-12);
            let again = environment.density(direction);
            assert!(
                (again / density - 1.0).abs() < 1e-6,
                "{again} for {density}"
            );
            light += environment.radiance(direction) / density as f32;
            solid += 1.0 / density;
            let uniform = uniform_sphere(sampler.next_2d());
            mean += environment.radiance(uniform) * (4.0 * PI) as f32;
        }
        let count = count as f32;
        // Every direction can be drawn, so 1/density integrates the sphere.
        assert!(
            (solid / f64::from(count) / (4.0 * PI) - 1.0).abs() < 0.03,
            "{solid}"
        );
        let [light, mean] = [light / count, mean / count];
        assert!(
            (light / mean - 1.0).abs().max_element() < 0.15,
            "{light} {mean}"
        );
        let stated = environment.mean() * (4.0 * PI) as f32;
        assert!(
            (light / stated - 1.0).abs().max_element() < 0.03,
            "{light} {stated}"
        );
    }
}
