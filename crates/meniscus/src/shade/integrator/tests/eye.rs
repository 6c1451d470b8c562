//! Media around an eye that moves.

use super::*;
use crate::math::aabb::DAabb;

#[test]
fn media_at_a_moving_eye_are_known_only_where_it_stays_outside() {
    let mut scene = Scene::default();
    named("ball", material(MaterialKind::Glass), &mut scene);
    let water = Material::of(MaterialKind::Water, None);
    scene.materials.insert("sea".to_owned(), water);
    scene.planes.push(Plane {
        point: DVec3::Y * -3.0,
        normal: Some(DVec3::Y),
        material: Some("sea".to_owned()),
    });
    let frame = lit(&scene, vec![ball(1.0)]);
    let at = |from: DVec3, to: DVec3, close: f64| {
        let settings = ShadeSettings {
            eye: from,
            eye_bounds: Some(DAabb { min: from, max: to }),
            shutter_secs: [0.0, close],
            ..ShadeSettings::default()
        };
        Shader::new(&frame, &settings).media
    };
    let outside = Some(MediumStack::default());
    assert_eq!(at(DVec3::splat(2.0), DVec3::splat(9.0), 1.0), outside);
    assert_eq!(at(DVec3::splat(-1.2), DVec3::splat(9.0), 1.0), None);
    let above = DVec3::new(3.0, -2.9, 3.0);
    assert_eq!(at(above, DVec3::splat(9.0), 1.0), outside);
    assert_eq!(at(above - DVec3::Y * 0.2, DVec3::splat(9.0), 1.0), None);
    // Where the shutter is open for no time all is as at the frame's.
    let inside = at(DVec3::ZERO, DVec3::splat(9.0), 0.0);
    assert_eq!(inside.map(|media| media.surfaces().to_vec()), Some(vec![0]));
}
