//! One eye and its film, as seen from a field's own space.

use glam::{DAffine3, DMat3, DVec3};
use meniscus::math::ray::Ray;
use meniscus::scene::camera::Camera;

/// A pinhole camera in the space of an object.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// Where it stands.
    pub(super) eye: DVec3,
    /// Takes a direction to (x, y, 1) times its depth, x and y being pixels from the film's top left
    /// corner.
    pub(super) film_from_direction: DMat3,
}

impl View {
    /// What `camera` is for an object placed by the inverse of `object_from_world`; any invertible
    /// placement will do.
    pub fn new(camera: &Camera, object_from_world: &DAffine3) -> Self {
        let [width, height] = camera.size.map(f64::from);
        let half_height = (0.5 * camera.fov).tan();
        let pixel = 2.0 * half_height / height;
        let across = camera.right * pixel;
        let down = -camera.up * pixel;
        let corner = camera.forward - 0.5 * width * across - 0.5 * height * down;
        let direction_from_film =
            object_from_world.matrix3 * DMat3::from_cols(across, down, corner);
        Self {
            eye: object_from_world.transform_point3(camera.eye),
            film_from_direction: direction_from_film.inverse(),
        }
    }

    /// Where an object-space ray meets the film, in pixels from the top left corner; `None` for rays that
    /// are not this eye's.
    pub(super) fn film_position(&self, ray: &Ray) -> Option<[f64; 2]> {
        if ray.origin != self.eye || ray.t_min != 0.0 {
            return None;
        }
        let seen = self.film_from_direction * ray.direction;
        let position = [seen.x / seen.z, seen.y / seen.z];
        let is_on_film = |p: f64| p.abs() < FARTHEST;
        (seen.z > 0.0 && position.into_iter().all(is_on_film)).then_some(position)
    }
}

/// Pixels beyond which a film position is none.
const FARTHEST: f64 = 1e8;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn film_positions_are_the_camera_s() {
        let camera = Camera::new(
            DVec3::new(3.0, 1.0, -2.0),
            DVec3::new(0.2, 0.1, 0.4),
            DVec3::Z,
            0.7,
            [640, 480],
        )
        .expect("a camera");
        let placed = DAffine3::from_scale(DVec3::new(2.0, 0.5, 3.0))
            * DAffine3::from_rotation_y(0.4)
            * DAffine3::from_translation(DVec3::new(1.0, 2.0, 3.0));
        let view = View::new(&camera, &placed);
        for film in [[0.5, 0.5], [320.0, 240.0], [600.3, 471.9], [-1.2, 481.0]] {
            let ray = camera.ray(film);
            let moved = Ray {
                origin: placed.transform_point3(ray.origin),
                direction: placed.transform_vector3(ray.direction),
                ..ray
            };
            let found = view.film_position(&moved).expect("it is the eye's");
            for axis in 0..2 {
                assert!((found[axis] - film[axis]).abs() < 1e-9, "{found:?}");
            }
            assert_eq!(view.film_position(&moved.with_range(0.1, 9.0)), None);
            assert_eq!(
                view.film_position(&Ray::new(moved.origin + DVec3::X, moved.direction)),
                None
            );
            let back = Ray::new(moved.origin, -moved.direction);
            assert_eq!(view.film_position(&back), None);
        }
    }
}
