mod places;
mod sense;
mod set;

use super::*;
use crate::kernel::Kernel;
use crate::scene::{
    Background, CameraSettings, Clip, Clipping, Color, ColorMap, CueSettings, FilmSettings, Ground,
    Instance, IntegratorKind, IntegratorSettings, LeafCost, Light, LightKind, Material,
    MaterialKind, Matrix, Mesh, Plane, Sphere, Surface, Up, Weights,
};
use glam::{DAffine3, DMat3, DVec3};
use proptest::prelude::*;

const FULL: &str = r##"
[camera]
eye = [1, 2.5, -3]
target = [0, 0, 0]
up = "-z"
fov = 35

[film]
width = 640
height = 480
spp = 64
exposure = -0.5
white_balance = 5600
noise = 0.02
background = "#ff8000"

[motion]
shutter = 0.5
fps = 24

[cues]
silhouettes = 0.5
depth_shading = 2

[integrator]
type = "path"
depth = 3
glossy_depth = 2
clamp = 10
caustics = false

[engine]
cost = "n"
fit = false
clipping = "kanamori"
builder = "morton"
motion_bounds = "bezier"

[[surface]]
name = "crown"
type = "blobs"
file = "frames/crown_{}.vtk"
radius = 0.02
smoothing = 3.5
kernel = "wyvill"
threshold = 0.4
weights = "density"
filter = "y > 0 && |velocity| < 3"
attributes = ["velocity", "density"]
color_by = "velocity.x"
color_map = "magma"
color_range = [-1, 2]
roughness_by = "wear"
roughness_range = [0, 4]
absorption_by = "dye"
material = "wet"

[[surface]]
file = "rest.ply"
support = 0.1
weights = "unit"

[[instance]]
surface = "crown"
matrix = [[0, -1, 0, 5], [1, 0, 0, 6], [0, 0, 2, 7], [0, 0, 0, 1]]
material = "wet"

[[mesh]]
file = "tank.obj"
matrix = [[1, 0, 0, 2], [0, 1, 0, 0], [0, 0, 1, 0]]
material = "wet"

[[sphere]]
center = [1, 2, 3]
radius = 0.5

[[clip]]
point = [0, 0, 1]
normal = [0, 0, 2]

[[plane]]
point = [0, -1, 0]
normal = [0, 1, 0.1]
material = "wet"

[ground]
height = -2.0

[[light]]
type = "sun"
direction = [1, 1, 1]
color = [1, 0.9, 0.8]
intensity = 2
angle = 0.5

[[light]]
type = "rectangle"
position = [0, 5, 0]
edges = [[1, 0, 0], [0, 0, 1]]

[[light]]
type = "environment"
file = "sky.hdr"
rotation = 90

[[light]]
type = "sky"
color = "#fff"

[material.wet]
type = "glossy"
color = "#204060"
specular = 0.8
roughness = 0.1

[material.tank]
type = "glass"
ior = 1.52
absorption = [0.9, 1, 0.95]
absorption_depth = 0.1
priority = 3

[material.window]
type = "glass"
thin = true
"##;

fn full() -> Scene {
    Scene {
        camera: CameraSettings {
            eye: Some(DVec3::new(1.0, 2.5, -3.0)),
            target: Some(DVec3::ZERO),
            up: Up(DVec3::NEG_Z),
            fov: 35.0,
            keys: Vec::new(),
        },
        film: FilmSettings {
            width: 640,
            height: 480,
            spp: 64,
            exposure: -0.5,
            white_balance: Some(crate::scene::WhiteBalance::Kelvin(5600.0)),
            noise: Some(0.02),
            background: Some(Background::Color(Color::from_srgb8([255, 128, 0]))),
        },
        motion: crate::scene::MotionSettings {
            shutter: 0.5,
            fps: 24.0,
            ..Default::default()
        },
        integrator: IntegratorSettings {
            kind: IntegratorKind::Path,
            depth: 3,
            glossy_depth: Some(2),
            clamp: Some(10.0),
            caustics: false,
            ..Default::default()
        },
        engine: crate::scene::EngineSettings {
            cost: LeafCost::N,
            fit: false,
            clipping: Clipping::Kanamori,
            builder: crate::scene::Builder::Morton,
            motion_bounds: crate::scene::MotionBounds::Bezier,
            ..Default::default()
        },
        surfaces: vec![
            Surface {
                name: Some("crown".to_owned()),
                radius: Some(0.02),
                smoothing: Some(3.5),
                kernel: Some(Kernel::Wyvill),
                threshold: Some(0.4),
                weights: Some(Weights::Column("density".to_owned())),
                filter: Some("y > 0 && |velocity| < 3".to_owned()),
                attributes: vec!["velocity".to_owned(), "density".to_owned()],
                color_by: Some("velocity.x".to_owned()),
                color_map: Some(ColorMap::Magma),
                color_range: Some([-1.0, 2.0]),
                roughness_by: Some("wear".to_owned()),
                roughness_range: Some([0.0, 4.0]),
                absorption_by: Some("dye".to_owned()),
                material: Some("wet".to_owned()),
                ..Surface::from_file("frames/crown_{}.vtk")
            },
            Surface {
                support: Some(0.1),
                weights: Some(Weights::Unit),
                ..Surface::from_file("rest.ply")
            },
        ],
        instances: vec![Instance {
            surface: "crown".to_owned(),
            matrix: Matrix(DAffine3 {
                matrix3: DMat3::from_cols(DVec3::Y, DVec3::NEG_X, DVec3::Z * 2.0),
                translation: DVec3::new(5.0, 6.0, 7.0),
            }),
            material: Some("wet".to_owned()),
            keys: Vec::new(),
        }],
        planes: vec![Plane {
            point: DVec3::NEG_Y,
            normal: Some(DVec3::new(0.0, 1.0, 0.1)),
            material: Some("wet".to_owned()),
        }],
        ground: Some(Ground {
            height: Some(-2.0),
            material: None,
        }),
        lights: vec![
            Light {
                direction: Some(DVec3::ONE),
                color: Some(Color([1.0, 0.9, 0.8])),
                intensity: 2.0,
                angle: Some(0.5),
                ..Light::default()
            },
            Light {
                kind: LightKind::Rectangle,
                position: Some(DVec3::Y * 5.0),
                edges: Some([DVec3::X, DVec3::Z]),
                ..Light::default()
            },
            Light {
                kind: LightKind::Environment,
                file: Some("sky.hdr".into()),
                rotation: Some(90.0),
                ..Light::default()
            },
            Light {
                kind: LightKind::Sky,
                color: Some(Color::WHITE),
                ..Light::default()
            },
        ],
        materials: [
            (
                "wet".to_owned(),
                Material::glossy(Color::from_srgb8([32, 64, 96]), 0.8, 0.1),
            ),
            (
                "tank".to_owned(),
                Material {
                    ior: Some(1.52),
                    absorption: Some(Color([0.9, 1.0, 0.95])),
                    absorption_depth: Some(0.1),
                    priority: Some(3),
                    ..Material::of(MaterialKind::Glass, None)
                },
            ),
            (
                "window".to_owned(),
                Material {
                    thin: Some(true),
                    ..Material::of(MaterialKind::Glass, None)
                },
            ),
        ]
        .into(),
        meshes: vec![Mesh {
            file: "tank.obj".into(),
            matrix: Matrix(DAffine3::from_translation(DVec3::X * 2.0)),
            material: Some("wet".to_owned()),
        }],
        spheres: vec![Sphere {
            center: DVec3::new(1.0, 2.0, 3.0),
            radius: 0.5,
            material: None,
        }],
        cues: CueSettings {
            silhouettes: 0.5,
            depth_shading: 2.0,
            ..CueSettings::default()
        },
        clips: vec![Clip {
            point: DVec3::Z,
            normal: DVec3::Z * 2.0,
        }],
    }
}

#[test]
fn every_key_is_read() {
    assert_eq!(parse(FULL, "full.toml").unwrap(), full());
}

#[test]
fn toml_and_json_carry_the_same_scene() {
    let toml = full().to_toml().unwrap();
    assert_eq!(parse(&toml, "again.toml").unwrap(), full(), "{toml}");
    let json = full().to_json().unwrap();
    assert_eq!(parse(&json, "again.json").unwrap(), full(), "{json}");
    assert_eq!(
        parse(&format!("\u{feff}\n  {json}"), "bom.json").unwrap(),
        full()
    );
    assert!(toml.contains("eye = [1.0, 2.5, -3.0]"), "{toml}");
    assert!(toml.contains("[[surface]]\nname = \"crown\""), "{toml}");
}

#[test]
fn a_bare_surface_has_the_defaults() {
    for text in [
        "surface = [{ file = \"a.vtk\" }]",
        "[[surface]]\nfile = \"a.vtk\"",
        r#"{"surface": [{"file": "a.vtk", "radius": null}]}"#,
    ] {
        let scene = parse(text, "bare").unwrap();
        let expected = Scene {
            surfaces: vec![Surface::from_file("a.vtk")],
            ..Scene::default()
        };
        assert_eq!(scene, expected);
        let film = &scene.film;
        assert_eq!((film.width, film.height, film.spp), (1280, 720, 16));
        assert_eq!((scene.camera.fov, scene.camera.up.0), (40.0, DVec3::Y));
        let settings = scene.surfaces[0].settings(&crate::scene::BlobSettings::default());
        assert_eq!(settings.threshold, 0.6);
        assert_eq!(settings.kernel, Kernel::Sextic);
        assert_eq!(settings.weights, Weights::Volume);
    }
}

/// The error of `text`, with what its excerpt points at.
fn error_of(text: &str) -> (SceneError, String) {
    let error = parse(text, "scene").expect_err(text);
    let pointed = error
        .excerpt
        .as_ref()
        .expect("a place")
        .pointed()
        .to_owned();
    (error, pointed)
}

const SURFACE: &str = "[[surface]]\nfile = \"a.vtk\"\n";

#[test]
fn files_are_relative_to_the_scene_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.cfg");
    std::fs::write(&path, SURFACE).unwrap();
    let scene = load(&path).unwrap();
    assert_eq!(scene.surfaces[0].file, folder.path().join("a.vtk"));

    std::fs::write(&path, "[[surface]]\nfile = \"/far/a.vtk\"\nkernl = 1").unwrap();
    let error = load(&path).unwrap_err();
    let place = format!("{}, line 3, column 1: unknown key", path.display());
    assert!(error.to_string().starts_with(&place), "{error}");

    let missing = load(&folder.path().join("none.toml")).unwrap_err();
    assert_eq!(missing.kind, SceneErrorKind::Io);
    assert!(missing.message.contains("none.toml"), "{missing}");
    std::fs::write(&path, [b'a', 0xff, 0xfe]).unwrap();
    assert!(
        load(&path)
            .unwrap_err()
            .message
            .contains("not UTF-8 text (byte 1)")
    );
    let big = std::fs::File::create(&path).unwrap();
    big.set_len(MAX_BYTES + 1).unwrap();
    assert!(
        load(&path)
            .unwrap_err()
            .message
            .contains("larger than 16 MiB")
    );
}

proptest! {
    #[test]
    fn any_text_is_a_scene_or_an_error(text in "\\PC*") {
        let _ = parse(&text, "any");
    }

    #[test]
    fn any_damage_to_a_scene_is_a_scene_or_an_error_with_a_place(
        start in 0_usize..1500,
        length in 0_usize..12,
        put in "[\\[\\]{}=\",.a0\n-]{0,6}",
        json in any::<bool>(),
    ) {
        let mut text = if json { full().to_json().unwrap() } else { FULL.to_owned() };
        let start = text.floor_char_boundary(start.min(text.len()));
        let end = text.ceil_char_boundary((start + length).min(text.len()));
        text.replace_range(start..end, &put);
        if let Err(error) = parse(&text, "damaged") {
            let excerpt = error.excerpt.as_ref().expect("a place");
            prop_assert!(excerpt.span.end <= text.len());
            prop_assert!(!error.message.is_empty());
            let (line, column) = excerpt.line_column();
            prop_assert!(line >= 1 && column >= 1);
        }
    }

    #[test]
    fn any_set_is_a_change_or_an_error(key in "[a-z.0-9]{0,20}", value in "\\PC{0,12}") {
        let mut scene = full();
        let _ = scene.set(&key, &value);
    }
}
