//! `meniscus bench`.

use crate::run::Folder;
use serde_json::Value;

fn keys(value: &Value) -> Vec<&str> {
    value
        .as_object()
        .unwrap()
        .keys()
        .map(String::as_str)
        .collect()
}

#[test]
fn json_has_exactly_the_keys_of_the_contract() {
    let folder = Folder::with_water();
    let out = folder
        .done("bench water.toml --json --repeats 2 --size 64x48")
        .stdout;
    let report: Value = serde_json::from_str(&out).unwrap();
    let mut expected = [
        "engine",
        "simd",
        "device",
        "threads",
        "repeats",
        "particles",
        "build_secs",
        "structure_bytes",
        "bytes_per_particle",
        "primary",
        "shadow",
        "hemisphere",
        "shuffled",
        "nodes_per_ray",
        "leaves_per_ray",
        "blob_evaluations_per_ray",
    ];
    expected.sort_unstable();
    let mut found = keys(&report);
    found.sort_unstable();
    assert_eq!(found, expected);
    for pass in ["primary", "shadow", "hemisphere", "shuffled"] {
        let mut found = keys(&report[pass]);
        found.sort_unstable();
        let expected = [
            "best_mrays_per_sec",
            "hit_fraction",
            "mrays_per_sec",
            "rays",
            "secs",
        ];
        assert_eq!(found, expected);
    }
    assert_eq!(report["primary"]["rays"], 64 * 48);
    assert_eq!(report["repeats"], 2);
    assert_eq!(report["particles"], 300);
    let number = |value: &Value| value.as_f64().unwrap();
    let primary = &report["primary"];
    let hits = number(&primary["hit_fraction"]) * 64.0 * 48.0;
    assert!(hits > 500.0, "{report}");
    assert!((number(&report["hemisphere"]["rays"]) - hits).abs() < 0.5);
    assert_eq!(report["shuffled"]["rays"], report["hemisphere"]["rays"]);
    assert_eq!(
        report["shuffled"]["hit_fraction"],
        report["hemisphere"]["hit_fraction"]
    );
    assert!(number(&report["shadow"]["rays"]) <= hits);
    assert!(number(&primary["best_mrays_per_sec"]) >= number(&primary["mrays_per_sec"]));
    assert!(number(&report["nodes_per_ray"]) > 0.0);
    assert!(number(&report["blob_evaluations_per_ray"]) > 0.0);
}

#[test]
fn text_is_a_table_and_wrong_wishes_are_refused() {
    let folder = Folder::with_water();
    let text = folder
        .done("bench water.toml --repeats 1 --size 32x24")
        .stdout;
    for part in ["primary", "shadow", "hemisphere", "shuffled", "Mray/s"] {
        assert!(text.contains(part), "{text}");
    }
    folder.fails("bench water.toml --repeats 0", 2, &["--repeats"]);
    folder.fails("bench water.toml --size 0x0", 2, &["width"]);
}
