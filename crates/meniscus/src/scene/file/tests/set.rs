//! `Scene::set`.

use super::*;

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
        ("engine.cost", "n2"),
        ("engine.discard", "false"),
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
    expected.engine.cost = LeafCost::N2;
    expected.engine.discard = false;
    expected.lights[0].direction = Some(DVec3::Y);
    expected.planes.push(Plane {
        point: DVec3::new(0.0, -5.0, 0.0),
        ..Plane::default()
    });
    expected.materials.get_mut("wet").unwrap().color = Some(Color([0.0; 3]));
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
        ("engine.cost", "n3", "n3", "n or n2"),
        (
            "engine.clipping",
            "newton",
            "newton",
            "own, nishita or kanamori",
        ),
        ("engine.fitt", "true", "fitt", "did you mean `fit`"),
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
