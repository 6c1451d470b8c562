//! Which clear media a ray is in: a stack with priorities (Schmidt & Budge, "Simple Nested Dielectrics
//! in Ray Traced Images", Journal of Graphics Tools 7(2), 2002).

use crate::frame::Frame;
use crate::intersect::Scratch;
use crate::math::ray::Side;
use glam::DVec3;

/// Media that one stack holds; a ray in more of them forgets the last ones.
const CAPACITY: usize = 8;

/// The clear surfaces that a point lies in, in the order of entering.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct MediumStack {
    surfaces: [u32; CAPACITY],
    count: u8,
}

impl MediumStack {
    /// The stack at a world point at a time (seconds relative to the frame), by asking every clear
    /// surface.
    pub(super) fn at(frame: &Frame, point: DVec3, secs: f64) -> Self {
        let mut stack = Self::default();
        let mut scratch = Scratch::default();
        for (surface, instance) in frame.instances.iter().enumerate() {
            let surface = surface as u32;
            let is_medium = frame.materials[instance.material as usize].is_medium();
            if is_medium && frame.side(surface, point, secs, &mut scratch) == Side::Inside {
                stack.enter(surface);
            }
        }
        stack
    }

    pub(super) fn surfaces(&self) -> &[u32] {
        &self.surfaces[..usize::from(self.count)]
    }

    fn enter(&mut self, surface: u32) {
        let count = usize::from(self.count);
        if count < CAPACITY && !self.surfaces().contains(&surface) {
            self.surfaces[count] = surface;
            self.count += 1;
        }
    }

    fn leave(&mut self, surface: u32) {
        if let Some(at) = self.surfaces().iter().position(|&s| s == surface) {
            self.surfaces
                .copy_within(at + 1..usize::from(self.count), at);
            self.count -= 1;
        }
    }

    /// The stack behind clear surface `surface`.
    pub(super) fn crossed(mut self, surface: u32, entering: bool) -> Self {
        if entering {
            self.enter(surface);
        } else {
            self.leave(surface);
        }
        self
    }

    /// The surface whose medium fills the place: of the largest priority, of equals the first.
    pub(super) fn filling(&self, frame: &Frame) -> Option<u32> {
        let priority = |surface: u32| {
            let material = frame.instances[surface as usize].material;
            frame.materials[material as usize].priority
        };
        let mut best: Option<u32> = None;
        for &surface in self.surfaces() {
            if best.is_none_or(|best| priority(surface) > priority(best)) {
                best = Some(surface);
            }
        }
        best
    }

    /// Index of refraction at the place.
    pub(super) fn ior(&self, frame: &Frame) -> f64 {
        self.filling(frame).map_or(1.0, |surface| {
            let material = frame.instances[surface as usize].material;
            frame.materials[material as usize].ior
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Instance;
    use crate::scene::{Material, MaterialKind, Plane, Scene};
    use glam::DAffine3;

    /// Two clear half spaces, glass (priority 10) and water (0), and an opaque one.
    fn frame() -> Frame {
        let mut scene = Scene::default();
        for (name, kind) in [
            ("glass", MaterialKind::Glass),
            ("water", MaterialKind::Water),
            ("clay", MaterialKind::Diffuse),
        ] {
            let material = Material::of(kind, None);
            scene.materials.insert(name.to_owned(), material);
            scene.planes.push(Plane {
                material: Some(name.to_owned()),
                ..Plane::default()
            });
        }
        Frame::build(&scene, Vec::new(), &Default::default()).unwrap()
    }

    #[test]
    fn glass_displaces_water_and_water_fills_what_glass_leaves() {
        let frame = frame();
        let stack = MediumStack::default();
        assert_eq!(stack.ior(&frame), 1.0);
        let water = stack.crossed(1, true);
        assert_eq!((water.filling(&frame), water.ior(&frame)), (Some(1), 1.333));
        let both = water.crossed(0, true);
        assert_eq!((both.filling(&frame), both.ior(&frame)), (Some(0), 1.517));
        // Leaving the water within the glass changes nothing; leaving the glass then leads to air.
        let glass = both.crossed(1, false);
        assert_eq!(glass.filling(&frame), Some(0));
        assert_eq!(glass.crossed(0, false), MediumStack::default());
        assert_eq!(both.crossed(0, false).filling(&frame), Some(1));
    }

    #[test]
    fn the_stack_at_a_point_holds_the_clear_surfaces_around_it() {
        let frame = frame();
        let below = MediumStack::at(&frame, DVec3::NEG_Y, 0.0);
        assert_eq!(below.surfaces(), [0, 1]);
        assert_eq!(
            MediumStack::at(&frame, DVec3::Y, 0.0),
            MediumStack::default()
        );
    }

    #[test]
    fn too_many_media_and_unexpected_exits_do_no_harm() {
        let mut frame = frame();
        let clear = frame.instances[0].clone();
        for _ in 0..20 {
            let copy = Instance::new(clear.geometry, DAffine3::IDENTITY, clear.material);
            frame.instances.push(copy);
        }
        let stack = MediumStack::at(&frame, DVec3::NEG_Y, 0.0);
        assert_eq!(stack.surfaces().len(), CAPACITY);
        assert_eq!(stack.crossed(21, false), stack);
        assert_eq!(stack.crossed(0, true), stack);
    }
}
