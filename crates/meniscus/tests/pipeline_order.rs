//! The modules of `lib.rs` stand in pipeline order, and each uses only those above it.

use std::fs;
use std::path::{Path, PathBuf};

fn rust_files(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            rust_files(&path, files);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            files.push(path);
        }
    }
}

/// Module names used through `crate::name` in `text`, test modules included.
fn used_modules(text: &str) -> Vec<String> {
    text.match_indices("crate::")
        .filter(|(at, _)| !text[..*at].ends_with('$'))
        .map(|(at, found)| {
            text[at + found.len()..]
                .chars()
                .take_while(|c| c.is_alphanumeric() || *c == '_')
                .collect::<String>()
        })
        .filter(|name| !name.is_empty())
        .collect()
}

#[test]
fn modules_use_only_those_above_them() {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let lib = fs::read_to_string(source.join("lib.rs")).unwrap();
    let order: Vec<&str> = lib
        .lines()
        .filter_map(|line| line.strip_prefix("pub mod ")?.strip_suffix(';'))
        .collect();
    assert!(order.len() >= 12, "modules found in lib.rs: {order:?}");

    let mut wrong = Vec::new();
    let mut uses_seen = 0;
    for (rank, module) in order.iter().enumerate() {
        let mut files = Vec::new();
        rust_files(&source.join(module), &mut files);
        assert!(!files.is_empty(), "module {module} has no folder");
        for file in files {
            for used in used_modules(&fs::read_to_string(&file).unwrap()) {
                let Some(used_rank) = order.iter().position(|name| *name == used) else {
                    continue; // a macro exported at the crate root
                };
                uses_seen += 1;
                if used_rank > rank {
                    wrong.push(format!("{} uses crate::{used}", file.display()));
                }
            }
        }
    }
    assert!(uses_seen > 20, "the scan found only {uses_seen} uses");
    assert!(
        wrong.is_empty(),
        "against the pipeline:\n{}",
        wrong.join("\n")
    );
}

#[test]
fn the_library_knows_no_gpu_command_line_window_or_python() {
    let manifest = concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml");
    let output = std::process::Command::new(env!("CARGO"))
        .args(["tree", "--offline", "--edges", "normal", "--prefix", "none"])
        .args(["--package", "meniscus", "--manifest-path", manifest])
        .output()
        .unwrap();
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let tree = String::from_utf8(output.stdout).unwrap();
    assert!(tree.contains("glam"), "cargo tree printed: {tree}");
    for forbidden in ["wgpu", "clap", "winit", "egui", "pyo3", "anyhow", "miette"] {
        assert!(
            !tree
                .lines()
                .any(|line| line.split(' ').next() == Some(forbidden)),
            "the library must not depend on {forbidden}"
        );
    }
}
