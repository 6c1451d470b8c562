//! Meshes, spheres, cuts, depth cues, turntables, molecules.

use crate::run::{Folder, is_whole_png};

const SMALL: &str = "--size 32x24 --spp 1";

/// A closed tetrahedron with its corner of three right angles at the origin.
const TETRAHEDRON: &str =
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

fn folder_with(scene: &str) -> Folder {
    let folder = Folder::new();
    folder.write("solid.obj", TETRAHEDRON);
    folder.write("scene.toml", scene);
    folder
}

/// Rays as a NumPy array of shape (n, 8).
fn rays(rays: &[[f64; 8]]) -> Vec<u8> {
    let mut header = format!(
        "{{'descr': '<f8', 'fortran_order': False, 'shape': ({}, 8), }}",
        rays.len()
    );
    while (10 + header.len() + 1) % 64 != 0 {
        header.push(' ');
    }
    header.push('\n');
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(rays.as_flattened().iter().flat_map(|x| x.to_le_bytes()));
    bytes
}

fn doubles(folder: &Folder, archive: &str, name: &str) -> Vec<f64> {
    let bytes = folder.read(archive);
    let mut archive = npyz::npz::NpzArchive::new(std::io::Cursor::new(bytes)).unwrap();
    archive.by_name(name).unwrap().unwrap().into_vec().unwrap()
}

#[test]
fn a_scene_of_a_mesh_and_a_sphere_is_traced_and_told() {
    let folder = folder_with(
        "[[mesh]]\nfile = \"solid.obj\"\nmatrix = [[2,0,0,0],[0,2,0,0],[0,0,2,0]]\n\
         [[sphere]]\ncenter = [5, 3, 0]\nradius = 0.5\n",
    );
    let inf = f64::INFINITY;
    folder.write(
        "rays.npy",
        rays(&[
            [-1.0, 0.25, 0.25, 1.0, 0.0, 0.0, 0.0, inf],
            [9.0, 3.0, 0.0, -2.0, 0.0, 0.0, 0.0, inf],
            [0.0, 5.0, 5.0, 0.0, 1.0, 0.0, 0.0, inf],
        ]),
    );
    folder.done("trace scene.toml --rays rays.npy -o hits.npz");
    assert_eq!(doubles(&folder, "hits.npz", "t"), [1.0, 1.75, inf]);
    folder.done("trace scene.toml --rays rays.npy -o all.npz --all");
    assert_eq!(doubles(&folder, "all.npz", "t"), [1.0, 2.5, 1.75, 2.25]);
    let info: serde_json::Value =
        serde_json::from_str(&folder.done("info scene.toml --json").stdout).unwrap();
    assert_eq!(info["meshes"][0]["triangles"], 4);
    assert_eq!(info["meshes"][0]["closed"], true);
    folder.done(&format!(
        "render scene.toml -o out.png --ground {SMALL} --clip x<0.5"
    ));
    assert!(is_whole_png(&folder.path("out.png")));
}

#[test]
fn meshes_that_cannot_be_used() {
    let scene = "[[mesh]]\nfile = \"solid.obj\"\n";
    let folder = folder_with(scene);
    let render = format!("render scene.toml -o out.png {SMALL}");
    for (text, parts) in [
        ("hello\n", &["solid.obj", "no mesh", "ply, gltf, obj"][..]),
        (
            "v 0 0 0\nv 1 0 0\nv 0 nan 0\nf 1 2 3\n",
            &["solid.obj", "vertex 2", "NaN"],
        ),
        (
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n",
            &["solid.obj", "out of bounds"],
        ),
        (
            "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n",
            &["solid.obj", "degenerate"],
        ),
        (
            "v 0 0 0\nv 1 0 0\nv 2 0 0\n",
            &["solid.obj", "no faces", "[[surface]]"],
        ),
    ] {
        folder.write("solid.obj", text);
        folder.fails(&render, 2, parts);
    }
    // Holes are no error: the picture is right.
    folder.write("solid.obj", TETRAHEDRON.replace("f 2 3 4\n", ""));
    let ended = folder.done(&render);
    assert!(ended.stderr.contains("holes (3 edges"), "{}", ended.stderr);
    for (scene, parts) in [
        (
            "[[mesh]]\nfile = \"none.ply\"\n",
            &["none.ply", "cannot read"][..],
        ),
        (
            "[[mesh]]\nmaterial = \"x\"\n",
            &["mesh", "`file` is missing"],
        ),
        (
            "[[mesh]]\nfile = \"solid.obj\"\nmaterial = \"glas\"\n",
            &["no material `glas`"],
        ),
        (
            "[[mesh]]\nfile = \"solid.obj\"\nmatrix = [[1,0,0,0],[1,0,0,0],[0,0,1,0]]\n",
            &["matrix"],
        ),
        ("[[sphere]]\nradius = 0\n", &["radius", "positive"]),
        (
            "[[sphere]]\n[[clip]]\nnormal = [0, 0, 0]\n",
            &["normal", "direction"],
        ),
        ("[[sphere]]\n[[clip]]\npoint = [0, 0, 0]\n", &["normal"]),
        (
            "[[sphere]]\n[cues]\nsilhouettes = 2\n",
            &["silhouettes", "from 0 to 1"],
        ),
    ] {
        folder.write("scene.toml", scene);
        folder.fails(&render, 2, parts);
    }
    folder.write("scene.toml", "[[sphere]]\n");
    folder.fails(
        &format!("{render} --clip w<1"),
        2,
        &["--clip", "w<1", "x<0.5"],
    );
}

#[test]
fn a_turntable_goes_round_in_n_pictures() {
    let folder = Folder::with_water();
    let words = format!("render water.vtk -o turn_{{}}.png {SMALL} --turntable 12 --stats s.json");
    folder.done(&words);
    let pictures: Vec<Vec<u8>> = (0..12)
        .map(|k| folder.read(&format!("turn_{k:02}.png")))
        .collect();
    for (k, picture) in pictures.iter().enumerate() {
        assert!(
            pictures[..k].iter().all(|other| other != picture),
            "picture {k}"
        );
    }
    assert_eq!(
        folder.json("s.json")["frames"].as_array().unwrap().len(),
        12
    );
    // The first is the picture without a turntable.
    folder.done(&format!("render water.vtk -o still.png {SMALL}"));
    assert_eq!(folder.read("still.png"), pictures[0]);
    folder.fails(
        &format!("render water.vtk -o turn.png {SMALL} --turntable 3"),
        2,
        &["{}"],
    );
    // Of a single file --frames chooses pictures.
    folder.done(&format!(
        "render water.vtk -o some_{{}}.png {SMALL} --turntable 12 --frames 3-11x8"
    ));
    assert_eq!(folder.read("some_03.png"), pictures[3]);
    assert_eq!(folder.read("some_11.png"), pictures[11]);
    assert!(!folder.path("some_00.png").exists() && !folder.path("some_04.png").exists());
    folder.fails(
        "render water.vtk -o t_{}.png --turntable 3 --frames 3-5",
        2,
        &["--frames", "0 to 2"],
    );
    folder.fails(
        "render water.vtk -o t_{}.png --turntable 0",
        2,
        &["between 1"],
    );
}

#[test]
fn depth_cues_change_the_picture_and_can_be_weighed() {
    let folder = Folder::with_water();
    let picture = |flags: &str| {
        folder.done(&format!("render water.vtk -o out.png {SMALL} {flags}"));
        folder.read("out.png")
    };
    let all = [
        "",
        "--silhouettes",
        "--silhouettes=0.5",
        "--depth-shading",
        "--depth-shading=2",
    ];
    let pictures: Vec<Vec<u8>> = all.iter().map(|flags| picture(flags)).collect();
    for (k, one) in pictures.iter().enumerate() {
        assert!(pictures[..k].iter().all(|other| other != one), "{}", all[k]);
    }
    assert_eq!(picture("--silhouettes=0"), pictures[0]);
    assert_eq!(picture("--silhouettes=1"), pictures[1]);
}

#[test]
fn molecules_come_with_radii_colours_and_models() {
    let folder = Folder::new();
    let atom = |z: f64| {
        format!("HETATM    1  O   HOH A   1       0.000   0.000{z:8.3}  1.00  1.00           O\n")
    };
    let text = format!(
        "MODEL 1\n{}ENDMDL\nMODEL 2\n{}ENDMDL\n",
        atom(0.0),
        atom(3.0)
    );
    folder.write("water.pdb", &text);
    folder.done(&format!(
        "render water.pdb -o model_{{}}.png {SMALL} --stats s.json"
    ));
    assert!(is_whole_png(&folder.path("model_0.png")) && is_whole_png(&folder.path("model_1.png")));
    let stats = folder.json("s.json");
    assert_eq!(stats["frames"][0]["threshold"], 0.2);
    assert_eq!(stats["frames"][0]["weights"], "unit");
    let by_element = folder.read("model_0.png");
    folder.done(&format!(
        "render water.pdb -o clay.png {SMALL} --preset clay"
    ));
    assert_ne!(folder.read("clay.png"), by_element);
    folder.done(&format!(
        "render water.pdb -o molecule.png {SMALL} --preset molecule"
    ));
}
