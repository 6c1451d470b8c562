//! Motion blur from the command line.

use crate::run::Folder;

const SMALL: &str = "--size 48x36 --spp 4 -q";

#[test]
fn a_shutter_blurs_what_moves_and_nothing_else() {
    let folder = Folder::new();
    folder.done("generate fountain -o f.vtk --count 400 -q");
    folder.done(&format!("render f.toml -o sharp.png {SMALL}"));
    let blur = format!("render f.toml -o blur.png --shutter 0.5 --stats s.json {SMALL}");
    folder.done(&blur);
    assert_ne!(folder.read("sharp.png"), folder.read("blur.png"));
    assert_eq!(folder.json("s.json")["engine"], "cells");
    folder.done(&format!(
        "render f.toml -o again.png --set motion.shutter=0.5 {SMALL}"
    ));
    assert_eq!(folder.read("blur.png"), folder.read("again.png"));
    folder.done(&format!(
        "render f.toml -o faster.png --shutter 1 --fps 50 {SMALL}"
    ));
    assert_eq!(folder.read("blur.png"), folder.read("faster.png"));

    folder.done("generate pool -o p.vtk --count 400 -q");
    folder.done(&format!("render p.toml -o still.png {SMALL}"));
    let open = folder.run("render p.toml -o open.png --shutter 0.5 --size 48x36 --spp 4");
    assert_eq!(open.code, Some(0));
    assert!(open.stderr.contains("nothing moves"), "{}", open.stderr);
    assert_eq!(folder.read("still.png"), folder.read("open.png"));
}

#[test]
fn shutters_that_make_no_sense() {
    let folder = Folder::new();
    folder.done("generate fountain -o f.vtk --count 50 -q");
    for (flags, word) in [
        ("--shutter -1", "shutter"),
        ("--shutter nan", "shutter"),
        ("--shutter 0.5 --fps 0", "fps"),
        ("--shutter 0.5 --velocity-scale 0", "velocity-scale"),
        ("--shutter 0.5 --engine fitted-bvh", "particles"),
    ] {
        folder.fails(
            &format!("render f.toml -o out.png {flags} {SMALL}"),
            2,
            &[word],
        );
    }
}
