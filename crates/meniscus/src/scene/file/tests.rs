use super::*;
use crate::kernel::Kernel;
use crate::scene::{
    Background, CameraSettings, Color, ColorMap, FilmSettings, Ground, Instance, Light, LightKind,
    Material, Matrix, Plane, Surface, Up, Weights,
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
background = "#ff8000"

[integrator]
type = "shaded"
depth = 3

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
material = "wet"

[[surface]]
file = "rest.ply"
support = 0.1
weights = "unit"

[[instance]]
surface = "crown"
matrix = [[0, -1, 0, 5], [1, 0, 0, 6], [0, 0, 2, 7], [0, 0, 0, 1]]
material = "wet"

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

[[light]]
type = "sky"
color = "#fff"

[material.wet]
type = "glossy"
color = "#204060"
specular = 0.8
roughness = 0.1
"##;

fn full() -> Scene {
    Scene {
        camera: CameraSettings {
            eye: Some(DVec3::new(1.0, 2.5, -3.0)),
            target: Some(DVec3::ZERO),
            up: Up(DVec3::NEG_Z),
            fov: 35.0,
        },
        film: FilmSettings {
            width: 640,
            height: 480,
            spp: 64,
            exposure: -0.5,
            background: Some(Background::Color(Color::from_srgb8([255, 128, 0]))),
        },
        integrator: crate::scene::IntegratorSettings {
            depth: 3,
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
                ..Light::default()
            },
            Light {
                kind: LightKind::Sky,
                color: Some(Color::WHITE),
                ..Light::default()
            },
        ],
        materials: [(
            "wet".to_owned(),
            Material::glossy(Color::from_srgb8([32, 64, 96]), 0.8, 0.1),
        )]
        .into(),
        meshes: Vec::new(),
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
fn unknown_keys_are_pointed_at_with_the_nearest_known_one() {
    let cases = [
        (
            "[[surface]]\nfile = \"a\"\ntreshold = 0.5",
            "treshold",
            "threshold",
            (3, 1),
        ),
        (
            "[[surface]]\n  kernal = \"quartic\"",
            "kernal",
            "kernel",
            (2, 3),
        ),
        ("[film]\nwidth = 3\nhight = 4", "hight", "height", (3, 1)),
        ("[cammera]\nfov = 3", "cammera", "camera", (1, 2)),
        ("[[surfaces]]\nfile = \"a\"", "surfaces", "surface", (1, 3)),
        (
            "[material.red]\ncolour = \"#f00\"",
            "colour",
            "color",
            (2, 1),
        ),
        ("[[light]]\ndir = [1, 2, 3]", "dir", "direction", (2, 1)),
        (
            "{\"film\": {\n  \"widht\": 3}}",
            "\"widht\"",
            "width",
            (2, 3),
        ),
        (
            "{\"film\": {\"w\\u0069dht\": 3}}",
            "\"w\\u0069dht\"",
            "width",
            (1, 11),
        ),
        (
            "{\"surface\": [{\"file\": \"a\", \"x\": [1, {\"q\": \"\"}], \"tresh\": 1}]}",
            "\"x\"",
            "keys here are",
            (1, 28),
        ),
    ];
    for (text, pointed_at, help, place) in cases {
        let (error, pointed) = error_of(text);
        assert_eq!(error.kind, SceneErrorKind::Schema, "{error}");
        assert_eq!(pointed, pointed_at, "{error}");
        assert!(error.message.starts_with("unknown key `"), "{error}");
        let given = error.help.clone().unwrap();
        assert!(given.contains(help), "{error}");
        assert_eq!(
            error.excerpt.as_ref().unwrap().line_column(),
            place,
            "{error}"
        );
    }
    let (error, _) = error_of("[[surface]]\nfile = \"a\"\ntreshold = 0.5");
    let start = "scene, line 3, column 1: unknown key `treshold` in `surface` (did you mean \
                 `threshold`? the keys here are: name, type, file";
    assert!(error.to_string().starts_with(start), "{error}");
}

#[test]
fn wrong_types_and_names_are_pointed_at() {
    let cases = [
        (
            "[camera]\nfov = \"wide\"",
            "\"wide\"",
            "`fov`: expected a number, found the text \"wide\"",
        ),
        (
            "[camera]\neye = [1, 2]",
            "[1, 2]",
            "`eye`: expected 3 numbers, found 2",
        ),
        (
            "[camera]\neye = [1, 2, 3, 4]",
            "[1, 2, 3, 4]",
            "expected 3 elements, found 4",
        ),
        (
            "[camera]\neye = [1, \"a\", 3]",
            "\"a\"",
            "`eye`: expected a number, found the text \"a\"",
        ),
        (
            "[camera]\nup = \"w\"",
            "\"w\"",
            "`w` is not a direction; use x, y, z, -x",
        ),
        ("[camera]\nup = 3", "3", "`up`: expected a direction"),
        (
            "[film]\nwidth = -3",
            "-3",
            "`width`: expected a whole number, 0 or more, found -3",
        ),
        (
            "[film]\nspp = 1.5",
            "1.5",
            "`spp`: expected a whole number, 0 or more, found 1.5",
        ),
        (
            "[film]\nbackground = \"blue\"",
            "\"blue\"",
            "use sky, transparent or #rrggbb",
        ),
        ("[film]\nbackground = [1, 2]", "[1, 2]", "a colour"),
        (
            "[[surface]]\nkernel = \"quartik\"",
            "\"quartik\"",
            "`kernel`: there is no `quartik`",
        ),
        (
            "[[surface]]\nkernel = 4",
            "4",
            "expected one of the names quartic, sextic, octic or wyvill",
        ),
        (
            "[[surface]]\ncolor_map = \"jet\"",
            "\"jet\"",
            "`color_map`: there is no `jet`",
        ),
        (
            "[[surface]]\ncolor_range = [1]",
            "[1]",
            "`color_range`: expected 2 numbers, found 1",
        ),
        (
            "[[surface]]\nfile = 2024-01-01",
            "2024-01-01",
            "found the date 2024-01-01",
        ),
        (
            "[[surface]]\nattributes = \"v\"",
            "\"v\"",
            "`attributes`: expected a list",
        ),
        ("surface = 3", "3", "`surface`: expected a list, found 3"),
        (
            "[[instance]]\nmatrix = [1]\nsurface = \"a\"",
            "[1]",
            "a matrix has 16 numbers",
        ),
        (
            "[[instance]]\nsurface = \"a\"\nmatrix = [[1,0,0,0],[0,1,0,0],[0,0,1,0],[1,2,3,1]]",
            "[[1,0,0,0],[0,1,0,0],[0,0,1,0],[1,2,3,1]]",
            "the last row of a matrix must be 0 0 0 1",
        ),
        (
            "{\"film\": {\"width\": true}}",
            "true",
            "`width`: expected a whole number",
        ),
        ("{\"film\": {\"width\": null}}", "null", "found nothing"),
        (
            "{\"camera\": {\"eye\": [1, {}, 3]}}",
            "{}",
            "`eye`: expected a number, found a table",
        ),
        (
            "{\"integrator\": {\"type\": \"shadedd\"}}",
            "\"shadedd\"",
            "there is no `shadedd`",
        ),
    ];
    for (text, pointed_at, message) in cases {
        let (error, pointed) = error_of(text);
        assert_eq!(error.kind, SceneErrorKind::Schema, "{error}");
        assert!(
            error.message.contains(message),
            "{text}\ngave {}",
            error.message
        );
        assert_eq!(pointed, pointed_at, "{text}\ngave {error}");
    }
    let (error, _) = error_of("[[surface]]\nkernel = \"quartik\"");
    assert_eq!(
        error.help.as_deref(),
        Some("did you mean `quartic`? it can be: quartic, sextic, octic or wyvill")
    );
    assert_eq!(error.key, "surface.0.kernel");
    for (text, brackets) in [
        ("[surface]\nfile = \"a\"", "[[…]]"),
        ("[[camera]]\nfov = 3", "[…]"),
    ] {
        let (error, _) = error_of(text);
        assert!(
            error
                .help
                .as_ref()
                .is_some_and(|help| help.contains(brackets)),
            "{error}"
        );
    }
}

#[test]
fn syntax_errors_are_pointed_at() {
    let cases = [
        ("[camera\nfov = 3", (1, 8), "TOML"),
        ("[camera]\nfov = ", (2, 7), "TOML"),
        ("[camera]\nfov = 3\nfov = 4", (3, 1), "TOML"),
        ("{\"camera\": {\"fov\" 3}}", (1, 19), "JSON"),
        ("{\n  \"camera\": {},\n}", (3, 1), "JSON"),
        ("{\"film\": {\"width\": 3, \"width\": 4}}", (1, 23), "JSON"),
        ("{} x", (1, 4), "JSON"),
    ];
    for (text, place, format) in cases {
        let (error, _) = error_of(text);
        assert_eq!(error.kind, SceneErrorKind::Syntax, "{error}");
        assert!(
            error.message.starts_with(&format!("not valid {format}: ")),
            "{error}"
        );
        assert_eq!(
            error.excerpt.as_ref().unwrap().line_column(),
            place,
            "{error}"
        );
    }
    for deep in [
        "[".repeat(100_000),
        format!("{{\"a\":{}", "[".repeat(100_000)),
    ] {
        assert_eq!(
            error_of(&format!("a = {deep}")).0.kind,
            SceneErrorKind::Syntax
        );
        assert_eq!(error_of(&deep).0.kind, SceneErrorKind::Syntax);
    }
    let dotted = format!("{}a = 1", "a.".repeat(100_000));
    assert_eq!(error_of(&dotted).0.kind, SceneErrorKind::Syntax);
}

#[test]
fn senseless_values_are_pointed_at() {
    let cases = [
        (
            "[camera]\nfov = 180",
            "180",
            "`fov` is the vertical angle in degrees",
        ),
        ("[camera]\nfov = nan", "nan", "not NaN"),
        (
            "[camera]\nup = [0, 0, 0]",
            "[0, 0, 0]",
            "`up` must be a direction",
        ),
        (
            "[camera]\neye = [0, inf, 0]",
            "[0, inf, 0]",
            "`eye` must be three finite numbers",
        ),
        (
            "[camera]\neye = [1, 2, 3]\ntarget = [1, 2, 3]",
            "[1, 2, 3]",
            "are the same point",
        ),
        (
            "[camera]\neye = [0, 5, 0]\ntarget = [0, 0, 0]\nup = \"y\"",
            "\"y\"",
            "`up` points along",
        ),
        (
            "[film]\nwidth = 0",
            "0",
            "`width` must be 1 to 65536 pixels, not 0",
        ),
        (
            "[film]\nheight = 65537",
            "65537",
            "`height` must be 1 to 65536 pixels",
        ),
        (
            "[film]\nwidth = 65536\nheight = 65536",
            "65536",
            "is more than 1073741824 pixels",
        ),
        ("[film]\nspp = 0", "0", "`spp` must be"),
        ("[film]\nexposure = inf", "inf", "`exposure` is in stops"),
        ("[film]\nbackground = [-1, 0, 0]", "[-1, 0, 0]", "0 or more"),
        ("[integrator]\ndepth = 0", "0", "`depth` must be at least 1"),
        (
            "[[surface]]\nfile = \"\"",
            "\"\"",
            "the key `file` is missing",
        ),
        (
            "[[surface]]\nfile = \"a\"\nradius = 0",
            "0",
            "`radius` must be a positive number",
        ),
        (
            "[[surface]]\nfile = \"a\"\nthreshold = nan",
            "nan",
            "`threshold` must be a positive",
        ),
        (
            "[[surface]]\nfile = \"a\"\nradius = 1\nsupport = 2",
            "1",
            "no effect beside `support`",
        ),
        (
            "[[surface]]\nfile = \"a\"\ncolor_range = [2, 1]",
            "[2, 1]",
            "the smaller first",
        ),
        (
            "[[surface]]\nfile = \"a\"\nfilter = \"\"",
            "\"\"",
            "`filter` is empty",
        ),
        (
            "[[surface]]\nfile = \"a\"\nmaterial = \"gold\"",
            "\"gold\"",
            "no material `gold`",
        ),
        (
            "[[surface]]\nname = \"a\"\nfile = \"a\"\n[[surface]]\nname = \"a\"\nfile = \"b\"",
            "\"a\"",
            "surface 0 is called `a` already",
        ),
        (
            "[[instance]]\nsurface = \"crown\"",
            "\"crown\"",
            "there is no surface `crown`",
        ),
        (
            "[[plane]]\nnormal = [0, 0, 0]",
            "[0, 0, 0]",
            "`normal` must be a direction",
        ),
        (
            "[[plane]]\npoint = [0, nan, 0]",
            "[0, nan, 0]",
            "three finite numbers",
        ),
        (
            "[ground]\nheight = inf",
            "inf",
            "`height` must be a finite number",
        ),
        (
            "[[light]]\ndirection = [0, 0, 0]",
            "[0, 0, 0]",
            "`direction` must be a direction",
        ),
        (
            "[[light]]\ntype = \"sky\"\ndirection = [0, 1, 0]",
            "[0, 1, 0]",
            "takes no `direction`",
        ),
        (
            "[[light]]\ntype = \"sky\"\nintensity = -1",
            "-1",
            "`intensity` must be 0 or more",
        ),
        (
            "[material.m]\ncolor = [2, 0, 0]",
            "[2, 0, 0]",
            "components from 0 to 1",
        ),
        (
            "[material.m]\nroughness = 2",
            "2",
            "`roughness` must be from 0 to 1",
        ),
        (
            "[material.m]\ntype = \"diffuse\"\nspecular = 1",
            "1",
            "takes no `specular`",
        ),
        ("{\"film\": {\"spp\": 0}}", "0", "`spp` must be"),
        ("{\"camera\": {\"fov\": 1e999}}", "1e999", "not inf"),
    ];
    for (text, pointed_at, message) in cases {
        let (error, pointed) = error_of(text);
        assert_eq!(error.kind, SceneErrorKind::Invalid, "{error}");
        assert!(
            error.message.contains(message),
            "{text}\ngave {}",
            error.message
        );
        assert_eq!(pointed, pointed_at, "{text}\ngave {error}");
    }
    // What is missing is pointed at where it should stand.
    let (error, pointed) = error_of("[film]\nspp = 4\n[[light]]\ntype = \"sun\"\n");
    assert!(
        error.message.contains("the sun has no `direction`"),
        "{error}"
    );
    assert_eq!(pointed, "[[light]]");
    let (error, _) = error_of("");
    assert_eq!(error.message, "the scene shows nothing");
}

#[test]
fn flat_and_mirrored_matrices_are_told_apart() {
    let with = |matrix: &str| {
        let text = format!(
            "[[surface]]\nname = \"a\"\nfile = \"a\"\n[[instance]]\nsurface = \"a\"\nmatrix = {matrix}"
        );
        parse(&text, "scene")
    };
    for flat in [
        "[[1,0,0,0],[0,1,0,0],[0,0,0,0]]",
        "[[1,2,3,0],[2,4,6,0],[0,0,1,0]]",
        "[1,0,0,0, 0,1,0,0, 1,1,0,0]",
        "[nan,0,0,0, 0,1,0,0, 0,0,1,0]",
    ] {
        assert_eq!(
            with(flat).unwrap_err().kind,
            SceneErrorKind::Invalid,
            "{flat}"
        );
    }
    for good in [
        "[[-1,0,0,0],[0,1,0,0],[0,0,1,0]]",
        "[1e-6,0,0,0, 0,1e-6,0,0, 0,0,1e-6,0]",
        "[1,0,0,1e6, 0,1e3,0,0, 0,0,1e-3,0, 0,0,0,1]",
    ] {
        assert!(with(good).is_ok(), "{good}: {}", with(good).unwrap_err());
    }
}

#[test]
fn what_is_announced_but_not_there_yet_says_so() {
    let cases = [
        (
            "[[surface]]\ntype = \"skeleton\"",
            "\"skeleton\"",
            "surface type `skeleton`",
        ),
        (
            "[[surface]]\ntype = \"points\"",
            "\"points\"",
            "surface type `points`",
        ),
        (
            "[integrator]\ntype = \"path\"",
            "\"path\"",
            "integrator `path`",
        ),
        (
            "[[light]]\ntype = \"sphere\"",
            "\"sphere\"",
            "light type `sphere`",
        ),
        (
            "[[light]]\ntype = \"environment\"",
            "\"environment\"",
            "light type `environment`",
        ),
        (
            "[material.m]\ntype = \"glass\"",
            "\"glass\"",
            "material type `glass`",
        ),
        ("[[mesh]]\nfile = \"a.obj\"", "[[mesh]]", "[[mesh]]"),
    ];
    for (text, pointed_at, what) in cases {
        let (error, pointed) = error_of(text);
        assert_eq!(error.kind, SceneErrorKind::Unsupported, "{error}");
        assert_eq!(error.message, format!("{what} is not supported yet"));
        assert!(pointed.contains(pointed_at), "{text}: {pointed}");
        assert!(error.help.is_some());
    }
}

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

#[test]
fn set_changes_one_key_as_the_file_would() {
    let mut scene = parse(FULL, "full.toml").unwrap();
    let mut expected = full();
    let sets = [
        ("surface.0.threshold", "0.5"),
        ("surface.1.kernel", "octic"),
        ("surface.1.name", "7"),
        ("surface.1.attributes", "[\"id\", \"v\"]"),
        ("camera.eye", "1,2,-3"),
        ("camera.up", "x"),
        ("film.background", "transparent"),
        ("material.wet.color", "#000"),
        ("material.dry.type", "diffuse"),
        ("light.0.direction", "[0, 1, 0]"),
        ("plane.1.point", "0, -5, 0"),
        ("surface.0.filter", "id > 3 && x < 2"),
    ];
    for (key, value) in sets {
        scene
            .set(key, value)
            .unwrap_or_else(|error| panic!("{key}: {error}"));
    }
    expected.surfaces[0].threshold = Some(0.5);
    expected.surfaces[0].filter = Some("id > 3 && x < 2".to_owned());
    expected.surfaces[1].kernel = Some(Kernel::Octic);
    expected.surfaces[1].name = Some("7".to_owned());
    expected.surfaces[1].attributes = vec!["id".to_owned(), "v".to_owned()];
    expected.camera.eye = Some(DVec3::new(1.0, 2.0, -3.0));
    expected.camera.up = Up(DVec3::X);
    expected.film.background = Some(Background::Transparent);
    expected.lights[0].direction = Some(DVec3::Y);
    expected.planes.push(Plane {
        point: DVec3::new(0.0, -5.0, 0.0),
        ..Plane::default()
    });
    expected.materials.get_mut("wet").unwrap().color = Color([0.0; 3]);
    expected.materials.insert(
        "dry".to_owned(),
        Material {
            kind: crate::scene::MaterialKind::Diffuse,
            ..Material::default()
        },
    );
    assert_eq!(scene, expected);
}

#[test]
fn set_points_at_its_own_text_and_changes_nothing_on_error() {
    let cases = [
        (
            "surface.0.treshold",
            "1",
            "treshold",
            "did you mean `threshold`",
        ),
        ("surface.0.threshold", "high", "high", "expected a number"),
        (
            "surface.0.kernel",
            "quartik",
            "quartik",
            "did you mean `quartic`",
        ),
        ("surface.9.threshold", "1", "9", "the list has 2"),
        (
            "surface.threshold",
            "1",
            "threshold",
            "must be a number, counted from 0",
        ),
        (
            "camera.eye",
            "[1, \"a\", 2]",
            "[1, \"a\", 2]",
            "expected a number",
        ),
        ("camera.fov.x", "1", "x", "no `x` inside this value"),
        ("surface..radius", "1", "", "empty part"),
        ("", "1", "", "empty part"),
        ("cam.fov", "1", "cam", "unknown key `cam`"),
        (
            "surface.0.threshold",
            "1\nfilm.spp = 3",
            "1\nfilm.spp = 3",
            "expected a number",
        ),
    ];
    for (key, value, pointed, message) in cases {
        let mut scene = full();
        let error = scene.set(key, value).expect_err(key);
        assert!(
            error.to_string().contains(message),
            "{key}={value}: {error}"
        );
        let excerpt = error.excerpt.as_ref().unwrap();
        assert_eq!(excerpt.name, "--set");
        assert_eq!(excerpt.text, format!("{key}={value}"));
        assert_eq!(excerpt.pointed(), pointed, "{error}");
        assert_eq!(scene, full());
    }
    let mut scene = full();
    assert!(scene.set(&"a.".repeat(100_000), "1").is_err());
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
