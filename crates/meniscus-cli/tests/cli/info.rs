//! `meniscus info`.

use crate::run::Folder;
use serde_json::Value;

#[test]
fn json_has_the_keys_of_the_contract() {
    let folder = Folder::new();
    folder.done("generate splash -o s.vtk --count 400");
    let info: Value = serde_json::from_str(&folder.done("info s.vtk --json").stdout).unwrap();
    for key in [
        "format",
        "particles",
        "frames",
        "columns",
        "bounds",
        "spacing",
        "radius",
        "support",
        "neighbours_per_support",
        "warnings",
    ] {
        assert!(!info[key].is_null(), "{key} in {info}");
    }
    assert_eq!(
        (&info["particles"], &info["frames"]),
        (&400.into(), &1.into())
    );
    let columns = info["columns"].as_array().unwrap();
    let velocity = columns
        .iter()
        .find(|column| column["name"] == "velocity")
        .unwrap();
    assert_eq!(
        (&velocity["type"], &velocity["components"]),
        (&"f32".into(), &3.into())
    );
    assert!(velocity["min"].as_f64().unwrap() < velocity["max"].as_f64().unwrap());
    // Without radii: half the spacing, and four times that.
    let number = |key: &str| info[key].as_f64().unwrap();
    assert!((number("radius") - 0.5 * number("spacing")).abs() < 1e-9);
    assert!((number("support") - 4.0 * number("radius")).abs() < 1e-9);
    assert!(number("neighbours_per_support") > 2.0);
}

#[test]
fn neighbours_are_counted() {
    let folder = Folder::new();
    folder.write("three.csv", "x,y,z\n0,0,0\n1,0,0\n5,0,0\n");
    let info = folder.done("info three.csv --json --support 1.5").stdout;
    let info: Value = serde_json::from_str(&info).unwrap();
    let neighbours = info["neighbours_per_support"].as_f64().unwrap();
    assert!((neighbours - 2.0 / 3.0).abs() < 1e-12);
    assert_eq!(info["support"], 1.5);
    assert_eq!(info["bounds"]["max"], serde_json::json!([5.0, 0.0, 0.0]));
}

#[test]
fn text_is_for_people_and_sequences_are_counted() {
    let folder = Folder::new();
    folder.done("generate splash -o 's_{}.vtk' --count 100 --frames 3");
    let text = folder.done("info 's_{}.vtk'").stdout;
    for part in [
        "100 particles",
        "3 frames",
        "velocity",
        "3 x f32",
        "spacing",
    ] {
        assert!(text.contains(part), "{part} in {text}");
    }
}
