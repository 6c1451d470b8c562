//! Integrator `ao`: how much of the half space over a surface is open.

use super::{Gathered, Shader};
use crate::math::ray::Ray;
use crate::math::sampling::{PixelSampler, cosine_hemisphere};
use crate::shade::ShadeScratch;
use crate::shade::world::back_from;

impl Shader<'_> {
    /// The base colour times the open part of the half space on the viewer's side, weighted by the
    /// cosine. The rays of one hit are traced together.
    pub(super) fn ambient_occlusion(
        &self,
        ray: &Ray,
        sampler: &mut PixelSampler,
        scratch: &mut ShadeScratch,
    ) -> Gathered {
        let world = &self.world;
        let Some(hit) = world.frame.closest_hit(ray, &mut scratch.trace) else {
            return Gathered::nothing(world.behind(ray.direction));
        };
        let (color, _) = world.look(&hit, scratch);
        let settings = &self.settings.integrator;
        let count = settings.ao_samples(self.settings.spp);
        let reach = settings.distance.unwrap_or(f64::INFINITY);
        let normal = if hit.entering {
            hit.normal
        } else {
            -hit.normal
        };
        let mut bundle = std::mem::take(&mut scratch.bundle);
        bundle.rays.clear();
        bundle.rays.extend(sampler.next_2d_of(count).map(|u| Ray {
            direction: cosine_hemisphere(normal, u),
            t_max: reach,
            ..back_from(ray, &hit)
        }));
        bundle.hits.clear();
        bundle.hits.resize(bundle.rays.len(), false);
        world
            .frame
            .any_hits(&bundle.rays, &mut bundle.hits, &mut scratch.trace);
        scratch.rays.ambient_occlusion += u64::from(count);
        let open = bundle
            .hits
            .iter()
            .filter(|&&is_blocked| !is_blocked)
            .count();
        scratch.bundle = bundle;
        let lit = color * (open as f32 / count as f32);
        Gathered::surface(lit, hit, color)
    }
}
