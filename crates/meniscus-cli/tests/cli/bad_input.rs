//! Bad input: one clear message, the right exit code, nothing written.

use crate::run::Folder;

#[test]
fn particle_files_that_are_no_particle_files() {
    let folder = Folder::with_water();
    folder.write("empty.vtk", "");
    let water = folder.read("water.vtk");
    folder.write("short.vtk", &water[..water.len() / 2]);
    folder.write(
        "huge.ply",
        "ply\nformat binary_little_endian 1.0\nelement vertex 4000000000000\n\
         property float x\nproperty float y\nproperty float z\nend_header\n\0\0\0\0",
    );
    folder.write("noise.xyz", [0x00, 0xff, 0x13, 0x37, 0x80, 0x01, 0x02]);
    for (file, part) in [
        ("empty.vtk", "empty"),
        ("short.vtk", "byte"),
        ("huge.ply", "4000000000000"),
        ("noise.xyz", "noise.xyz"),
    ] {
        for command in [
            format!("render {file} -o out.png"),
            format!("info {file}"),
            format!("bench {file}"),
        ] {
            folder.fails(&command, 1, &["error: ", file, part]);
        }
    }
}

#[test]
fn numbers_that_cannot_be_rendered() {
    let folder = Folder::new();
    folder.write("some.csv", "x,y,z\n0,0,0\nnan,1,1\n1,0,0\ninf,0,0\n0,1,0\n");
    folder.write("none.csv", "x,y,z\nnan,0,0\n0,inf,0\n");
    folder.write("flat.csv", "x,y,z,radius\n0,0,0,0\n1,0,0,-2\n");
    let small = "--size 16x9 --spp 1";
    let ended = folder.done(&format!(
        "render some.csv -o some.png {small} --stats s.json"
    ));
    assert!(ended.stderr.contains("warning: "), "{}", ended.stderr);
    assert!(
        ended.stderr.contains("dropped 2 particles"),
        "{}",
        ended.stderr
    );
    let stats = folder.json("s.json");
    assert_eq!(
        (&stats["particles"], &stats["dropped"]),
        (&3.into(), &2.into())
    );
    let ended = folder.done(&format!("render some.csv -o quiet.png {small} -q"));
    assert_eq!(ended.stderr, "");

    folder.fails(
        "render none.csv -o out.png",
        1,
        &["none.csv", "no particle is left of 2"],
    );
    folder.fails(
        "render flat.csv -o out.png",
        1,
        &["flat.csv", "no particle is left", "radius"],
    );
}

#[test]
fn settings_out_of_range() {
    let folder = Folder::with_water();
    for (flags, parts) in [
        ("-r 0", &["radius"][..]),
        ("-r -1", &["radius"]),
        ("--support -2", &["support"]),
        ("-t 0", &["threshold"]),
        ("-t -0.5", &["threshold"]),
        ("-t 1.5 --weights unit -r 0.1", &["--support"]),
        ("-r 1 --support 2", &["--support"]),
        ("--smoothing 0", &["smoothing"]),
        ("--weights missing", &["missing"]),
        ("-a missing", &["missing"]),
        ("--color-by missing", &["missing"]),
        (
            "--kernel gauss",
            &["gauss", "quartic, sextic, octic, wyvill"],
        ),
        ("--filter 'x >'", &["filter"]),
        ("--filter 'density > 1'", &["density"]),
        ("--size 0x100", &["width"]),
        ("--size 100x0", &["height"]),
        ("--size 999999x999999", &["width"]),
        ("--size 10", &["WIDTHxHEIGHT"]),
        ("--spp 0", &["spp"]),
        ("--spp -1", &["--spp"]),
        ("--region 0,0,9999,1", &["--region"]),
        ("--region 0,0,0,1", &["--region"]),
        ("--samples 0-16", &["--samples", "0-15"]),
        ("--samples 5-2", &["--samples"]),
        ("--fov 0", &["fov"]),
        ("--fov 180", &["fov"]),
        ("--up 0,0,0", &["up"]),
        ("--light 0,0,0", &["--light"]),
        ("--light 1,2", &["three numbers"]),
        ("--background red", &["--background"]),
        ("--preset lava", &["lava", "water"]),
        ("--color-map rainbow --color-by x", &["rainbow", "viridis"]),
        ("--color-range 0,1", &["--color-by"]),
        ("--color-range 1,1 --color-by x", &["smaller"]),
        ("--set surface.0.treshold=0.5", &["threshold"]),
        ("--set surface.0.threshold=high", &["--set"]),
        ("--set nonsense", &["key.path=value"]),
        ("--threads 0", &["--threads"]),
        ("--simd mmx", &["mmx"]),
        ("--png-depth 12", &["--png-depth"]),
        ("--integrator photons", &["photons", "path"]),
        ("--noise 0", &["noise"]),
        ("--noise 1.5", &["noise"]),
        ("--time-limit 0", &["--time-limit"]),
        ("--time-limit -1", &["--time-limit"]),
        ("--noise 0.1 --samples 0-3", &["--samples"]),
        ("--frames 0", &["frames"]),
        ("--frames a-b", &["--frames"]),
        ("--aov all", &[".exr"]),
        ("--no-such-flag", &["--no-such-flag"]),
    ] {
        folder.fails(&format!("render water.vtk -o out.png {flags}"), 2, parts);
    }
    folder.fails("render water.vtk", 2, &["--output"]);
    folder.fails("render -o out.png", 2, &["INPUT"]);
    folder.fails("render water.vtk -o out.gif", 2, &[".png or .exr"]);
    folder.fails("render water.vtk -o out", 2, &[".png or .exr"]);
    folder.fails("paint water.vtk", 2, &["paint"]);
    folder.fails("render water.vtk -o out.exr --aov missing", 2, &["missing"]);
}

#[test]
fn what_is_not_there_is_said() {
    let folder = Folder::with_water();
    folder.fails("bench paper gourmel-9", 2, &["gourmel-1"]);
    folder.fails("render water.vtk -o out.png --device tpu", 2, &["cpu"]);
    folder.fails("render water.vtk -o out.png --engine magic", 2, &["cells"]);
}

#[test]
fn inputs_that_are_not_there() {
    let folder = Folder::with_water();
    folder.write("frame_1.vtk", folder.read("water.vtk"));
    folder.write("frame_3.vtk", folder.read("water.vtk"));
    folder.fails("render watr.vtk -o out.png", 1, &["watr.vtk", "water.vtk"]);
    folder.fails("info water.vtp", 1, &["water.vtp", "water.vtk"]);
    folder.fails("render . -o out.png", 1, &["folder"]);
    folder.fails(
        "render 'fram_{}.vtk' -o 'out_{}.png'",
        1,
        &["fram_{}.vtk", "frame_1.vtk"],
    );
    folder.fails(
        "render 'frame_{}.vtk' -o 'out_{}.png' --frames 5-9",
        2,
        &["5-9", "1 to 3"],
    );
    folder.fails("render 'frame_{}.vtk' -o out.png", 2, &["{}"]);
    folder.fails("render frame_%d.vtk -o 'out_{}.png'", 2, &["frame_{}.vtk"]);
    folder.fails("render water.vtk water.toml -o 'out_{}.png'", 2, &["mix"]);
}

#[test]
fn outputs_that_cannot_be_written_are_found_before_the_work() {
    let folder = Folder::with_water();
    folder.fails(
        "render water.vtk -o nowhere/out.png",
        1,
        &["nowhere", "mkdir"],
    );
    std::fs::create_dir(folder.path("taken.png")).unwrap();
    folder.fails("render water.vtk -o taken.png", 1, &["taken.png", "folder"]);
    folder.fails(
        "render water.vtk -o out.png --stats no/s.json",
        1,
        &["no/s.json"],
    );
    folder.fails("generate pool -o no/pool.vtk", 1, &["no/pool.vtk"]);
    folder.fails(
        "trace water.vtk --rays rays.npy -o no/hits.npz",
        1,
        &["no/hits.npz"],
    );
    folder.write("copy.png", folder.read("water.vtk"));
    folder.fails("render copy.png -o copy.png", 2, &["overwritten"]);
}

#[test]
fn scenes_are_answered_with_a_caret() {
    let folder = Folder::with_water();
    let scene = "[[surface]]\nfile = \"water.vtk\"\ntreshold = 0.5\n";
    folder.write("typo.toml", scene);
    let ended = folder.fails(
        "render typo.toml -o out.png",
        2,
        &["error: ", "typo.toml:3:1", "treshold", "threshold"],
    );
    assert!(
        ended.stderr.contains('^') || ended.stderr.contains('─'),
        "{}",
        ended.stderr
    );
    folder.write("broken.json", "{ \"surface\": [ }");
    folder.fails("render broken.json -o out.png", 2, &["broken.json:1"]);
    folder.write("value.toml", "[film]\nwidth = \"wide\"\n");
    folder.fails(
        "render value.toml -o out.png",
        2,
        &["value.toml:2", "width"],
    );
    folder.write("gone.toml", "[[surface]]\nfile = \"gone.vtk\"\n");
    folder.fails("render gone.toml -o out.png", 1, &["gone.vtk"]);
    folder.fails("info typo.toml", 2, &["typo.toml:3:1"]);
}

#[test]
fn lights_and_materials_that_make_no_sense_are_answered() {
    let folder = Folder::with_water();
    let scene = |rest: &str| format!("[[surface]]\nfile = \"water.vtk\"\n{rest}\n");
    folder.write("text.hdr", "not an image");
    folder.write(
        "huge.hdr",
        "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 8000 +X 16000\n\x02\x02",
    );
    for (rest, parts) in [
        ("material = \"gold\"", &["gold"][..]),
        (
            "[material.glass]\ntype = \"glass\"\nior = 0",
            &["light.toml:5", "ior"],
        ),
        (
            "[material.glass]\ntype = \"glas\"",
            &["light.toml:4", "glass"],
        ),
        (
            "[[light]]\ntype = \"sphere\"\nposition = [0, 1, 0]\nradius = 0",
            &["light.toml:6", "radius"],
        ),
        (
            "[[light]]\ntype = \"environment\"\nfile = \"gone.hdr\"",
            &["gone.hdr", "cannot be read"],
        ),
        (
            "[[light]]\ntype = \"environment\"\nfile = \"text.hdr\"",
            &["text.hdr", ".exr"],
        ),
        (
            "[[light]]\ntype = \"environment\"\nfile = \"huge.hdr\"",
            &["huge.hdr", "damaged"],
        ),
        ("roughness_by = \"wear\"", &["wear"]),
    ] {
        folder.write("light.toml", scene(rest));
        folder.fails("render light.toml -o out.png --size 16x9", 2, parts);
    }
}
