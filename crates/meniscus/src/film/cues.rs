//! Depth cues over a finished film: silhouettes and unsharp masking of the depth.

use super::{Film, PlaneData};
use crate::scene::CueSettings;
use crate::scene::camera::Camera;
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// How many natural units of light one unit of spatial importance is worth at strength 1.
const DEPTH_GAIN: f32 = 3.0;
/// Depth steps, as a part of the depth range, at which a silhouette begins and is complete.
const STEP: [f32; 2] = [0.01, 0.04];
/// 1 − N·N′ of neighbouring pixels at which a crease begins and is complete.
const CREASE: [f32; 2] = [0.25, 0.6];
/// How unevenly a slanted plane may seem to fall because samples lie anywhere in their pixels.
const JITTER: f32 = 3.0;
/// Pixels over which the depth of a pixel itself is smoothed, so that edges do not fray.
const OWN_SIGMA: f32 = 0.7;
/// |N·V| above which nothing counts as turning away, and below which everything does.
const TURNING: [f32; 2] = [0.3, 0.1];

impl Film {
    /// Puts depth cues over the colour channels. It needs the depth and, for silhouettes, the channel
    /// `normal`; without them nothing happens. `depth_range` holds the depths between which the
    /// objects lie. Within a region only its own pixels are looked at.
    pub fn apply_cues(&mut self, cues: &CueSettings, camera: &Camera, depth_range: [f64; 2]) {
        let Some(PlaneData::F32(depth)) = self.plane_named("Z") else {
            return;
        };
        let region = self.region();
        let size = [region.width as usize, region.height as usize];
        let [near, far] = depth_range.map(|depth| depth as f32);
        let range = if far > near { far - near } else { 1.0 };
        if cues.depth_shading > 0.0 {
            let relative: Vec<f32> = depth
                .iter()
                .map(|&z| ((z - near) / range).clamp(0.0, 1.0))
                .collect();
            let [width, height] = self.size().map(f64::from);
            let sigma = (cues.depth_reach * width.hypot(height)) as f32;
            let smooth = blurred(&relative, size, sigma);
            let own = blurred(&relative, size, OWN_SIGMA);
            let gain = DEPTH_GAIN * cues.depth_shading as f32;
            for (pixel, (smooth, own)) in smooth.iter().zip(&own).enumerate() {
                self.scale_color(pixel, (gain * (smooth - own)).exp());
            }
        }
        if cues.silhouettes > 0.0 {
            let planes = ["N.X", "N.Y", "N.Z"].map(|name| self.plane_named(name));
            let [
                Some(PlaneData::F32(x)),
                Some(PlaneData::F32(y)),
                Some(PlaneData::F32(z)),
            ] = planes
            else {
                return;
            };
            let normals: Vec<Vec3> = (0..depth.len())
                .map(|i| Vec3::new(x[i], y[i], z[i]))
                .collect();
            let view = |pixel: usize| -> Vec3 {
                let x = f64::from(region.x) + (pixel % size[0]) as f64 + 0.5;
                let y = f64::from(region.y) + (pixel / size[0]) as f64 + 0.5;
                let direction: DVec3 = camera.ray([x, y]).direction;
                (direction / direction.dot(camera.forward)).as_vec3()
            };
            let views: Vec<Vec3> = (0..depth.len()).map(view).collect();
            let lines = Lines {
                depth: &depth,
                normals: &normals,
                views: &views,
                size,
                range,
                pixel: (2.0 * (0.5 * camera.fov).tan() / f64::from(self.size()[1])) as f32,
            };
            for pixel in 0..depth.len() {
                let line = lines.at(pixel);
                self.scale_color(pixel, 1.0 - cues.silhouettes as f32 * line);
            }
        }
    }
}

/// Where lines are drawn.
struct Lines<'a> {
    depth: &'a [f32],
    normals: &'a [Vec3],
    /// Directions from the eye, of length 1 along the view axis.
    views: &'a [Vec3],
    size: [usize; 2],
    range: f32,
    /// Height of a pixel at depth 1.
    pixel: f32,
}

impl Lines<'_> {
    /// How dark the line at a pixel is, 0 to 1. Lines lie on the nearer of two things.
    fn at(&self, pixel: usize) -> f32 {
        let z = self.depth[pixel];
        if !z.is_finite() {
            return 0.0;
        }
        let [width, height] = self.size;
        let (x, y) = (pixel % width, pixel / width);
        let pairs = [
            (x > 0 && x + 1 < width).then(|| [pixel - 1, pixel + 1]),
            (y > 0 && y + 1 < height).then(|| [pixel - width, pixel + width]),
        ];
        let (mut step, mut bend) = (0.0_f32, 0.0_f32);
        for pair in pairs.into_iter().flatten() {
            let drops = pair.map(|i| match self.are_on_one_plane(pixel, i) {
                true => 0.0,
                false => 1.0 / z - 1.0 / self.depth[i],
            });
            step = step.max(isolated(drops) * z * z);
            for neighbour in pair.into_iter().filter(|&i| self.depth[i].is_finite()) {
                bend = bend.max(1.0 - self.normals[pixel].dot(self.normals[neighbour]));
            }
        }
        let turning = if bend > 1e-4 {
            let view = self.views[pixel].normalize();
            smoothstep(TURNING, self.normals[pixel].dot(view).abs())
        } else {
            // A plane, which is seen at the same angle far and wide.
            0.0
        };
        smoothstep(STEP, step / self.range)
            .max(smoothstep(CREASE, bend))
            .max(turning)
    }

    /// Whether what two pixels show lies in one plane, as far as samples that lie anywhere in their
    /// pixels can tell.
    fn are_on_one_plane(&self, a: usize, b: usize) -> bool {
        let normal = self.normals[a];
        let height = normal.dot(self.views[a] * self.depth[a] - self.views[b] * self.depth[b]);
        let rounding = JITTER * self.pixel * self.depth[a].max(self.depth[b]);
        1.0 - normal.dot(self.normals[b]) < 1e-5 && height.abs() <= rounding
    }
}

/// How much 1/Z falls on one side of a pixel or both, beyond what goes on evenly: 1/Z is linear over
/// the picture of a plane, so it falls on one side as it rises on the other, but for where in their
/// pixels the samples lie.
fn isolated([before, after]: [f32; 2]) -> f32 {
    let (least, most) = (before.min(after), before.max(after));
    if least > 0.0 {
        most
    } else {
        (most - JITTER * least.abs()).max(0.0)
    }
}

/// 0 at the first value and 1 at the second, smooth in between.
fn smoothstep([from, to]: [f32; 2], value: f32) -> f32 {
    let t = ((value - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// A Gaussian of standard deviation `sigma` pixels over a picture; beyond its edges the outermost
/// pixels go on.
fn blurred(values: &[f32], [width, height]: [usize; 2], sigma: f32) -> Vec<f32> {
    let reach = (3.0 * sigma).ceil().max(1.0) as usize;
    let weights: Vec<f32> = (0..=reach)
        .map(|k| (-0.5 * (k as f32 / sigma.max(0.1)).powi(2)).exp())
        .collect();
    let sum = weights[0] + 2.0 * weights[1..].iter().sum::<f32>();
    let along = |line: &[f32], i: usize| {
        let last = line.len() - 1;
        let pairs = weights
            .iter()
            .enumerate()
            .skip(1)
            .map(|(k, weight)| weight * (line[i.saturating_sub(k)] + line[(i + k).min(last)]));
        (weights[0] * line[i] + pairs.sum::<f32>()) / sum
    };
    let pass = |values: &[f32], length: usize| -> Vec<f32> {
        values
            .par_chunks(length)
            .flat_map_iter(|line| (0..line.len()).map(move |i| along(line, i)))
            .collect()
    };
    let turned = |values: &[f32], width: usize, height: usize| -> Vec<f32> {
        let columns = (0..width).flat_map(|x| (0..height).map(move |y| y * width + x));
        columns.map(|i| values[i]).collect()
    };
    let rows = pass(values, width);
    let columns = pass(&turned(&rows, width, height), height);
    turned(&columns, height, width)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::{ChannelSet, PixelSample, Region, SurfaceSample};
    use crate::scene::Background;
    use std::sync::Arc;

    const SIZE: usize = 64;

    /// A picture of a near square before a far wall before nothing; gray everywhere.
    fn film() -> (Film, Camera) {
        let camera =
            Camera::new(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, 0.5, [SIZE as u32; 2]).unwrap();
        let channels = Arc::new(ChannelSet::new(&["normal"], &[]).unwrap());
        let region = Region::full(SIZE as u32, SIZE as u32);
        let mut film = Film::new([SIZE as u32; 2], region, channels, Background::Sky).unwrap();
        for y in 0..SIZE as u32 {
            for x in 0..SIZE as u32 {
                let is_in =
                    |low: u32, high: u32| (low..high).contains(&x) && (low..high).contains(&y);
                let depth = if is_in(24, 40) {
                    Some(10.0)
                } else {
                    is_in(8, 56).then_some(14.0)
                };
                let surface = depth.map(|depth| SurfaceSample {
                    depth,
                    position: [0.0; 3],
                    normal: [0.0, 0.0, 1.0],
                    motion: [0.0; 2],
                    curvature: [0.0; 2],
                    id: 0,
                    surface: 0,
                });
                let sample = PixelSample {
                    radiance: [0.5; 3],
                    coverage: 1.0,
                    backdrop: 0.0,
                    albedo: [0.5; 3],
                    denoising_albedo: [0.0; 3],
                    surface,
                    attributes: &[],
                };
                film.add(x, y, 0, [0.0, 0.0], &sample);
            }
        }
        (film, camera)
    }

    fn light(film: &Film, x: usize, y: usize) -> f32 {
        film.rgba(y * SIZE + x)[0]
    }

    #[test]
    fn lines_lie_on_the_nearer_side_of_a_step() {
        let (mut film, camera) = film();
        let cues = CueSettings {
            silhouettes: 1.0,
            ..CueSettings::default()
        };
        film.apply_cues(&cues, &camera, [9.0, 15.0]);
        for (x, expected) in [
            (24, 0.0),
            (23, 0.5),
            (32, 0.5),
            (39, 0.0),
            (8, 0.0),
            (7, 0.5),
            (12, 0.5),
        ] {
            assert!(
                (light(&film, x, 32) - expected).abs() < 1e-3,
                "{x}: {}",
                light(&film, x, 32)
            );
        }
    }

    #[test]
    fn depth_shading_darkens_behind_and_lifts_before_an_edge() {
        let (mut film, camera) = film();
        let cues = CueSettings {
            depth_shading: 1.0,
            ..CueSettings::default()
        };
        film.apply_cues(&cues, &camera, [9.0, 15.0]);
        let (behind, before) = (light(&film, 23, 32), light(&film, 24, 32));
        assert!(behind < 0.4 && before > 0.6, "{behind} {before}");
        assert!(
            light(&film, 20, 32) > behind,
            "the dark fades with distance"
        );
        let symmetric = light(&film, 40, 32);
        assert!((symmetric - behind).abs() < 1e-4);
    }

    #[test]
    fn slanted_planes_have_no_lines_however_samples_lie() {
        for jitter in [[0.0, 0.0, 0.0], [0.2, -0.2, 0.2], [-0.2, 0.2, 0.1]] {
            let fall = |k: usize| 0.01 * (k as f32 + jitter[k]);
            let drops = [fall(1) - fall(0), fall(1) - fall(2)];
            assert_eq!(isolated(drops), 0.0, "{jitter:?}");
        }
        assert_eq!(isolated([0.0, 0.5]), 0.5);
        assert_eq!(isolated([0.3, 0.5]), 0.5);
        assert_eq!(isolated([-0.5, -0.1]), 0.0);
    }

    #[test]
    fn a_blur_keeps_what_is_constant() {
        let values = vec![0.7; 12];
        for value in blurred(&values, [4, 3], 2.5) {
            assert!((value - 0.7).abs() < 1e-6);
        }
        let mut spot = vec![0.0; 81];
        spot[40] = 1.0;
        let blurred = blurred(&spot, [9, 9], 1.0);
        let sum: f32 = blurred.iter().sum();
        assert!((sum - 1.0).abs() < 1e-3 && (blurred[39] - blurred[31]).abs() < 1e-6);
    }
}
