use super::*;
use crate::field::{FieldAttribute, Search};
use crate::kernel::Kernel;
use crate::math::aabb::DAabb;
use crate::primitive::Shapes;
use crate::scene::attribute::Component;
use crate::scene::{self, Color, Ground, Matrix, Scene, Surface};

/// Unit balls of support 2 at `centers`: quartic, T = 0.25, so a lone one has radius √2.
fn field(centers: Vec<[f32; 3]>) -> BlobField {
    let count = centers.len();
    BlobField {
        kernel: Kernel::Quartic,
        threshold: 0.25,
        origin: DVec3::new(100.0, 0.0, 0.0),
        shapes: Shapes::Balls(vec![2.0; count]),
        weights: vec![1.0; count],
        rows: (0..count as u32).collect(),
        motion: None,
        attributes: vec![FieldAttribute {
            name: "velocity".to_owned(),
            components: 3,
            data: (0..count).flat_map(|i| [i as f32, -3.0, 4.0]).collect(),
        }],
        spacing: 1.0,
        search: Search::default(),
        centers,
    }
}

fn scene_of(surfaces: Vec<Surface>) -> Scene {
    Scene {
        surfaces,
        ..Scene::default()
    }
}

fn build(scene: &Scene, fields: Vec<BlobField>) -> Result<Frame, FrameError> {
    let settings = FrameSettings {
        engine: Engine::Sweep,
        ..FrameSettings::default()
    };
    Frame::build(scene, fields, &settings)
}

#[test]
fn a_surface_without_instances_stands_once_and_instances_replace_it() {
    let mut scene = scene_of(vec![
        Surface {
            name: Some("drop".to_owned()),
            ..Surface::default()
        },
        Surface::default(),
    ]);
    let fields = || vec![field(vec![[0.0; 3]]), field(vec![[1.0; 3]])];
    let frame = build(&scene, fields()).unwrap();
    let geometries: Vec<_> = frame.instances.iter().map(|i| i.geometry).collect();
    assert_eq!(geometries, [0, 1]);

    scene.materials.insert(
        "red".to_owned(),
        scene::Material::diffuse(Color([0.5, 0.0, 0.0])),
    );
    let shift = |x: f64| Matrix(DAffine3::from_translation(DVec3::X * x));
    scene.instances = vec![
        scene::Instance {
            surface: "drop".to_owned(),
            matrix: shift(1.0),
            material: None,
            keys: Vec::new(),
        },
        scene::Instance {
            surface: "drop".to_owned(),
            matrix: shift(2.0),
            material: Some("red".to_owned()),
            keys: Vec::new(),
        },
    ];
    scene.planes = vec![scene::Plane::default()];
    let frame = build(&scene, fields()).unwrap();
    let geometries: Vec<_> = frame.instances.iter().map(|i| i.geometry).collect();
    assert_eq!(geometries, [0, 0, 1, 2]);
    assert_eq!(frame.instances[1].world_from_object, shift(2.0).0);
    let base = |instance: usize| &frame.materials[frame.instances[instance].material as usize];
    assert_eq!(base(1).base, BaseColor::Constant([0.5, 0.0, 0.0]));
    assert_eq!((base(1).specular, base(0).specular), (0.0, 1.0));
    let Geometry::Plane(plane) = &frame.geometries[2] else {
        panic!("the plane comes last");
    };
    assert_eq!((plane.point, plane.normal), (DVec3::ZERO, DVec3::Y));
}

#[test]
fn names_that_are_missing_are_reported() {
    let mut scene = scene_of(vec![Surface {
        material: Some("steel".to_owned()),
        ..Surface::default()
    }]);
    let error = build(&scene, vec![field(vec![[0.0; 3]])]).unwrap_err();
    assert_eq!(error.to_string(), "the scene defines no material `steel`");
    scene.surfaces[0].material = None;
    scene.instances.push(scene::Instance {
        surface: "drop".to_owned(),
        matrix: Matrix::default(),
        material: None,
        keys: Vec::new(),
    });
    let error = build(&scene, vec![field(vec![[0.0; 3]])]).unwrap_err();
    assert_eq!(error.to_string(), "the scene defines no surface `drop`");
    let error = build(&scene, Vec::new()).unwrap_err();
    assert_eq!(
        error.to_string(),
        "the scene has 1 surfaces, but 0 fields were given"
    );
}

#[test]
fn colour_by_attribute_takes_magnitude_component_and_fixed_range() {
    let colored = |color_by: &str, color_range| {
        let scene = scene_of(vec![Surface {
            color_by: Some(color_by.to_owned()),
            color_range,
            ..Surface::default()
        }]);
        build(&scene, vec![field(vec![[0.0; 3], [1.0; 3], [2.0; 3]])]).map(|frame| {
            match &frame.materials[0].base {
                BaseColor::Attribute(coloring) => (**coloring).clone(),
                other => panic!("not by a map: {other:?}"),
            }
        })
    };
    let magnitude = colored("velocity", None).unwrap();
    assert_eq!(magnitude.component, Component::Magnitude);
    assert_eq!(magnitude.range, [5.0, 29_f32.sqrt()]);
    let x = colored("velocity.x", None).unwrap();
    assert_eq!(x.range, [0.0, 2.0]);
    assert_eq!(x.color(&[1.0, 0.0, 0.0]), x.table.at(0.5));
    let fixed = colored("velocity.x", Some([-1.0, 7.0])).unwrap();
    assert_eq!(fixed.color(&[1.0, 0.0, 0.0]), fixed.table.at(0.25));
    let constant = colored("velocity.y", None).unwrap();
    assert_eq!(constant.color(&[0.0, -3.0, 0.0]), constant.table.at(0.5));
    let error = colored("density", None).unwrap_err().to_string();
    assert_eq!(
        error,
        "there is no attribute `density` to colour by; there are: velocity"
    );
    let error = colored("velocity[3]", None).unwrap_err().to_string();
    assert!(error.contains("has 3 components"), "{error}");
}

#[test]
fn strays_do_not_stretch_the_automatic_colour_range() {
    let scene = scene_of(vec![Surface {
        color_by: Some("speed".to_owned()),
        ..Surface::default()
    }]);
    let mut blobs = field((0..301).map(|i| [i as f32, 0.0, 0.0]).collect());
    let mut data: Vec<f32> = (0..301).map(|i| i as f32).collect();
    (data[7], data[11]) = (1e6, -1e6);
    blobs.attributes = vec![FieldAttribute {
        name: "speed".to_owned(),
        components: 1,
        data,
    }];
    let frame = build(&scene, vec![blobs]).unwrap();
    let BaseColor::Attribute(coloring) = &frame.materials[0].base else {
        panic!("not coloured");
    };
    assert_eq!(coloring.range, [2.0, 298.0]);
}

#[test]
fn lights_default_to_a_sun_and_a_sky_and_are_unit_vectors() {
    let mut scene = Scene::default();
    for up in ["y", "z", "-x"] {
        scene.camera.up = up.parse().unwrap();
        let frame = build(&scene, Vec::new()).unwrap();
        let [Light::Sun { towards, .. }, Light::Sky { .. }] = frame.lights[..] else {
            panic!("{:?}", frame.lights);
        };
        assert!((towards.length() - 1.0).abs() < 1e-12);
        assert!(
            towards.dot(frame.up) > 0.3,
            "the sun of up = {up} is above the horizon"
        );
    }
    scene.lights = vec![scene::Light {
        intensity: 3.0,
        color: Some(Color([1.0, 0.5, 0.0])),
        direction: Some(DVec3::new(0.0, 0.0, 10.0)),
        angle: Some(90.0),
        ..scene::Light::default()
    }];
    assert_eq!(
        build(&scene, Vec::new()).unwrap().lights,
        [Light::Sun {
            towards: DVec3::Z,
            radiance: [3.0, 1.5, 0.0],
            half_angle: std::f64::consts::FRAC_PI_4,
        }]
    );
}

/// 20 × 20 × 20 centres with unit steps, and `strays`.
fn block(strays: &[[f32; 3]]) -> BlobField {
    let axis = 0..20_i16;
    let centers = axis
        .clone()
        .flat_map(|x| {
            axis.clone()
                .flat_map(move |y| (0..20_i16).map(move |z| (x, y, z)))
        })
        .map(|(x, y, z)| [x, y, z].map(f32::from))
        .chain(strays.iter().copied());
    field(centers.collect())
}

fn assert_near(found: DAabb, min: [f64; 3], max: [f64; 3]) {
    let apart = found.min.distance(DVec3::from_array(min)) + found.max.distance(max.into());
    assert!(apart < 1e-4, "{found:?}");
}

#[test]
fn framing_ignores_strays_and_nothing_else() {
    let reach = 2_f64.sqrt();
    let frame_of = |strays: &[[f32; 3]]| {
        build(&scene_of(vec![Surface::default()]), vec![block(strays)]).unwrap()
    };
    let low = [100.0 - reach, -reach, -reach];
    let high = [119.0 + reach, 19.0 + reach, 19.0 + reach];
    assert_near(frame_of(&[]).framing_bounds(), low, high);
    let strays = [[900.0, 3.0, 3.0], [3.0, -500.0, 3.0], [-400.0, 0.0, 700.0]];
    assert_near(frame_of(&strays).framing_bounds(), low, high);
    // A splash that leaves the block by less than half its width belongs to the object.
    let near = [[25.0, 3.0, 3.0]];
    let wider = [125.0 + reach, high[1], high[2]];
    assert_near(frame_of(&near).framing_bounds(), low, wider);
    // All supports count in the full bounds.
    let all = frame_of(&strays).bounds([0.0, 0.0]);
    assert_near(all, [-302.0, -502.0, -2.0], [1002.0, 21.0, 702.0]);
}

#[test]
fn framing_of_few_or_no_particles_is_their_box() {
    let frame_of = |centers: Vec<[f32; 3]>| {
        build(&scene_of(vec![Surface::default()]), vec![field(centers)]).unwrap()
    };
    let reach = 2_f64.sqrt();
    assert!(frame_of(Vec::new()).framing_bounds().is_empty());
    let one = frame_of(vec![[1.0, 2.0, 3.0]]).framing_bounds();
    assert_near(
        one,
        [101.0 - reach, 2.0 - reach, 3.0 - reach],
        [101.0 + reach, 2.0 + reach, 3.0 + reach],
    );
    let two = frame_of(vec![[0.0; 3], [1000.0, 0.0, 0.0]]).framing_bounds();
    assert_near(
        two,
        [100.0 - reach, -reach, -reach],
        [1100.0 + reach, reach, reach],
    );
}

#[test]
fn instances_move_and_turn_the_bounds() {
    let mut scene = scene_of(vec![Surface {
        name: Some("drop".to_owned()),
        ..Surface::default()
    }]);
    scene.instances.push(scene::Instance {
        surface: "drop".to_owned(),
        matrix: Matrix(
            DAffine3::from_rotation_z(90_f64.to_radians())
                * DAffine3::from_scale(DVec3::new(2.0, 1.0, 1.0)),
        ),
        material: None,
        keys: Vec::new(),
    });
    let frame = build(&scene, vec![field(vec![[0.0; 3]])]).unwrap();
    // x of [98, 102], doubled and turned into y.
    assert_near(
        frame.bounds([0.0, 0.0]),
        [-2.0, 196.0, -2.0],
        [2.0, 204.0, 2.0],
    );
}

#[test]
fn the_ground_touches_the_lowest_point_along_up() {
    let reach = 2_f64.sqrt();
    let cases = [
        ("y", -reach),
        ("z", -reach),
        ("-x", -(119.0 + reach)),
        ("-y", -(19.0 + reach)),
    ];
    for (up, height) in cases {
        let mut scene = scene_of(vec![Surface::default()]);
        scene.camera.up = up.parse().unwrap();
        scene.ground = Some(Ground::default());
        let frame = build(&scene, vec![block(&[[3.0, 3.0, -900.0]])]).unwrap();
        let ground = frame.ground.unwrap();
        assert_eq!(ground.surface, 1);
        let Geometry::Plane(plane) = &frame.geometries[1] else {
            panic!("the ground is a plane");
        };
        assert_eq!(plane.normal, frame.up);
        let found = plane.point.dot(frame.up);
        assert!((found - height).abs() < 1e-4, "up {up}: {found}");
        assert_eq!(ground.opacity(ground.center), 1.0);
        let side = scene::Light::defaults(frame.up)[0]
            .direction
            .unwrap()
            .cross(frame.up);
        let far = ground.center + side.normalize() * ground.radius * 5.0;
        assert_eq!(ground.opacity(far), 0.0);
    }
    let scene = Scene {
        ground: Some(Ground {
            height: Some(-3.0),
            material: None,
        }),
        ..Scene::default()
    };
    let frame = build(&scene, Vec::new()).unwrap();
    assert_eq!(frame.ground.unwrap().center, DVec3::new(0.0, -3.0, 0.0));
}
