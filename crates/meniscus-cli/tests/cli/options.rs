//! Options: values that begin with '-', overriding of scenes, what help says.

use crate::run::Folder;

#[test]
fn values_may_begin_with_a_minus() {
    let folder = Folder::with_water();
    let small = "--size 16x9 --spp 1";
    for flags in [
        "--light -1,2,3",
        "--up -y",
        "--up -x",
        "--up -1,0.5,0",
        "--camera-eye -1,-2,-3",
        "--camera-target -0.5,-0.5,0 --camera-eye 3,3,3",
        "--color-by x --color-range -1,1",
        "--filter '-x < 0.5'",
        "--set 'camera.eye=[-1,-2,-3]'",
    ] {
        folder.done(&format!("render water.vtk -o out.png {small} {flags}"));
    }
    // Understood as a value, and refused as one.
    folder.fails(
        "render water.vtk -o no.png -t -1",
        2,
        &["`threshold` must be a positive number, not -1"],
    );
    folder.fails(
        "render water.vtk -o no.png --threshold -1",
        2,
        &["`threshold` must be a positive number, not -1"],
    );
}

#[test]
fn options_override_the_scene() {
    let folder = Folder::with_water();
    let small = "--size 16x9 --stats s.json";
    folder.done(&format!("render water.toml -o out.png {small}"));
    let from_scene = folder.json("s.json");
    assert_eq!(from_scene["kernel"], "quartic");
    assert_eq!(from_scene["weights"], "unit");
    folder.done(&format!(
        "render water.toml -o out.png {small} --kernel octic -t 0.4 --weights volume --spp 2"
    ));
    let overridden = folder.json("s.json");
    assert_eq!(overridden["kernel"], "octic");
    assert_eq!(overridden["weights"], "volume");
    assert_eq!(overridden["threshold"], 0.4);
    assert_eq!(overridden["image"]["spp"], 2);
    folder.done(&format!(
        "render water.toml -o out.png {small} --set surface.0.threshold=0.7"
    ));
    assert_eq!(folder.json("s.json")["threshold"], 0.7);
    folder.done(&format!(
        "render water.toml -o out.png {small} --filter 'x < 0.5'"
    ));
    let half = folder.json("s.json")["particles"].as_u64().unwrap();
    assert!(half > 50 && half < 250, "{half}");
}

#[test]
fn json_scenes_mean_the_same_and_are_told_by_content() {
    let folder = Folder::with_water();
    let toml = String::from_utf8(folder.read("water.toml")).unwrap();
    let scene: meniscus::scene::Scene = meniscus::scene::file::parse(&toml, "water.toml").unwrap();
    folder.write("water.json", scene.to_json().unwrap());
    folder.write("scene.txt", &toml);
    let small = "--size 32x18 --spp 1";
    for (name, out) in [
        ("water.toml", "a.png"),
        ("water.json", "b.png"),
        ("scene.txt", "c.png"),
    ] {
        folder.done(&format!("render {name} -o {out} {small}"));
    }
    assert_eq!(folder.read("a.png"), folder.read("b.png"));
    assert_eq!(folder.read("a.png"), folder.read("c.png"));
}

#[test]
fn help_teaches() {
    let folder = Folder::new();
    for command in ["", "render", "info", "generate", "trace", "bench"] {
        let help = folder.done(&format!("{command} --help")).stdout;
        assert!(help.contains("Examples:\n  meniscus "), "{command}: {help}");
    }
    let help = folder.done("render --help").stdout;
    for part in [
        "Surface:",
        "Camera and light:",
        "Engine:",
        "[default: 1280x720]",
        "--filter",
    ] {
        assert!(help.contains(part), "{part} in {help}");
    }
    assert!(folder.done("--version").stdout.starts_with("meniscus "));
}
