//! Integrator `ao`: how much of the half space over a surface is open.

use super::{Gathered, Shader};
use crate::intersect::Hit;
use crate::math::ray::Ray;
use crate::math::sampling::{PixelSampler, cosine_hemisphere};
use crate::shade::asking::Ask;
use crate::shade::world::back_from;

impl Shader<'_> {
    /// The base colour times the open part of the half space on the viewer's side, weighted by the
    /// cosine. The rays of one hit are traced together.
    pub(super) async fn ambient_occlusion(
        &self,
        ray: &Ray,
        first: Option<Hit>,
        sampler: &mut PixelSampler,
        ask: &impl Ask,
    ) -> Gathered {
        let world = &self.world;
        let Some(hit) = first else {
            return Gathered::nothing(world.behind(ray.direction));
        };
        let (color, _) = world.look(&hit, &mut ask.scratch());
        let settings = &self.settings.integrator;
        let count = settings.ao_samples(self.settings.spp);
        let reach = settings.distance.unwrap_or(f64::INFINITY);
        let normal = if hit.entering {
            hit.normal
        } else {
            -hit.normal
        };
        let rays = sampler.next_2d_of(count).map(|u| Ray {
            direction: cosine_hemisphere(normal, u),
            t_max: reach,
            ..back_from(ray, &hit)
        });
        let blocked = ask.blocked_of(rays).await;
        ask.scratch().rays.ambient_occlusion += u64::from(count);
        let open = count as usize - blocked;
        let lit = color * (open as f32 / count as f32);
        Gathered::surface(lit, hit, color)
    }
}
