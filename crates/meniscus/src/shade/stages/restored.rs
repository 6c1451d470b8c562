//! What a device's hit does not say as exactly as surfaces are asked here.

use super::Shader;
use crate::frame::Geometry;
use crate::intersect::Hit;
use crate::mesh::area_direction;

impl Shader<'_> {
    /// A hit with the normal of the plane that cuts, by which caps are known, where it is on one; on a mesh
    /// with that of the face. There a device names the triangle, in the order of the leaves, as a blob.
    pub(super) fn restored(&self, hit: Hit, time_secs: f64) -> Hit {
        let frame = self.world.frame;
        let mut clips = frame.clips.iter().map(|plane| plane.normal);
        if let Some(normal) = clips.find(|normal| normal.as_vec3() == hit.normal.as_vec3()) {
            return Hit {
                normal,
                shading_normal: normal,
                ..hit
            };
        }
        let instance = &frame.instances[hit.surface as usize];
        let Geometry::Mesh(mesh) = &frame.geometries[instance.geometry as usize] else {
            return hit;
        };
        let place = hit
            .blob
            .and_then(|place| mesh.tree.order.get(place as usize));
        let face = place.map(|&triangle| area_direction(mesh.corners(triangle as usize)));
        let matrix = instance.at(time_secs).object_from_world.matrix3.transpose();
        Hit {
            normal: face.map_or(hit.normal, |face| (matrix * face).normalize_or(hit.normal)),
            blob: None,
            ..hit
        }
    }
}
