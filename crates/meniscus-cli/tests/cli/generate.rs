//! `meniscus generate`.

use crate::run::Folder;

#[test]
fn every_generator_writes_particles_and_a_scene_that_renders() {
    for name in [
        "scattered",
        "pool",
        "tornado",
        "molecule",
        "fountain",
        "splash",
    ] {
        let folder = Folder::new();
        folder.done(&format!("generate {name} -o set.vtk --count 200"));
        assert_eq!(folder.names(), ["set.toml", "set.vtk"]);
        let info = folder.done("info set.toml --json").stdout;
        let info: serde_json::Value = serde_json::from_str(&info).unwrap();
        assert_eq!(info["particles"], 200, "{name}");
        assert_eq!(info["warnings"], serde_json::json!([]), "{name}");
        folder.done("render set.toml -o set.png --size 32x18 --spp 1 --stats s.json");
        assert_eq!(folder.json("s.json")["particles"], 200, "{name}");
    }
}

#[test]
fn the_same_seed_gives_the_same_bytes() {
    let folder = Folder::new();
    folder.done("generate splash -o a.vtk --count 500 --seed 7");
    folder.done("generate splash -o b.vtk --count 500 --seed 7");
    folder.done("generate splash -o c.vtk --count 500 --seed 8");
    assert_eq!(folder.read("a.vtk"), folder.read("b.vtk"));
    assert_ne!(folder.read("a.vtk"), folder.read("c.vtk"));
}

#[test]
fn frames_fly_and_render_from_the_scene() {
    let folder = Folder::new();
    folder.done("generate fountain -o 'f_{}.vtk' --count 200 --frames 10");
    let names = folder.names();
    assert_eq!(names.len(), 11);
    assert!(names.contains(&"f_01.vtk".to_owned()) && names.contains(&"f_10.vtk".to_owned()));
    assert!(names.contains(&"f.toml".to_owned()));
    folder.done("render f.toml -o 'p_{}.png' --size 16x9 --spp 1 --frames 1-10x3");
    let pictures: Vec<String> = folder
        .names()
        .into_iter()
        .filter(|n| n.starts_with('p'))
        .collect();
    assert_eq!(pictures, ["p_01.png", "p_04.png", "p_07.png", "p_10.png"]);
}

#[test]
fn every_format_holds_the_same_particles() {
    let folder = Folder::new();
    for ending in ["vtk", "ply", "bgeo", "csv", "npz"] {
        folder.done(&format!("generate splash -o s.{ending} --count 100"));
        let info = folder.done(&format!("info s.{ending} --json")).stdout;
        let info: serde_json::Value = serde_json::from_str(&info).unwrap();
        assert_eq!(info["particles"], 100, "{ending}");
        let columns = info["columns"].as_array().unwrap();
        assert!(columns.len() >= 3, "{ending}: {columns:?}");
    }
    let ended = folder.done("generate splash -o s.npy --count 100");
    assert!(ended.stderr.contains("velocity"), "{}", ended.stderr);
}

#[test]
fn wrong_wishes_are_refused() {
    let folder = Folder::new();
    for (words, part) in [
        ("generate lava -o a.vtk", "scattered, pool"),
        ("generate pool -o a.vtk --count 0", "between 1 and"),
        ("generate pool -o a.vtk --count -5", "--count"),
        ("generate pool -o a.stl", ".vtk"),
        ("generate splash -o a.vtk --frames 3", "{}"),
        ("generate splash -o 'a_{}.vtk'", "--frames"),
        ("generate splash -o 'a_{}.vtk' --frames 0", "--frames"),
        ("generate pool -o 'a_{}.vtk' --frames 3", "does not move"),
    ] {
        folder.fails(words, 2, &[part]);
    }
}
