//! `meniscus render`.

use crate::run::{Folder, has_control_characters, is_whole_png};
use serde_json::Value;

const SMALL: &str = "--size 96x54 --spp 2";

#[test]
fn pictures_are_the_same_bit_for_bit_with_any_number_of_threads() {
    let folder = Folder::new();
    folder.done("generate splash -o s.vtk --count 1500");
    for (threads, name) in [(1, "a"), (2, "b"), (8, "c"), (8, "d")] {
        folder.done(&format!(
            "render s.toml -o {name}.png {SMALL} --threads {threads} --color-by velocity"
        ));
        folder.done(&format!(
            "render s.toml -o {name}.exr {SMALL} --threads {threads} --aov all"
        ));
    }
    assert!(is_whole_png(&folder.path("a.png")));
    for other in ["b", "c", "d"] {
        for ending in ["png", "exr", "legend.png", "legend.json"] {
            let same =
                folder.read(&format!("a.{ending}")) == folder.read(&format!("{other}.{ending}"));
            assert!(same, "{other}.{ending} differs");
        }
    }
}

#[test]
fn a_real_frame_is_the_same_bit_for_bit_with_any_number_of_threads() {
    let frame = "fluid/splishsplash_crown/ParticleData_Fluid_36.vtk";
    let Some(frame) = meniscus_testing::data::file(frame) else {
        return;
    };
    let folder = Folder::new();
    let frame = frame.canonicalize().unwrap();
    for (threads, name) in [(1, "a"), (2, "b"), (8, "c"), (8, "d")] {
        folder.done(&format!(
            "render '{}' -o {name}.exr --size 160x90 --threads {threads} --aov all --ground",
            frame.display()
        ));
    }
    for other in ["b", "c", "d"] {
        let same = folder.read("a.exr") == folder.read(&format!("{other}.exr"));
        assert!(same, "{other}.exr differs");
    }
}

#[test]
fn the_metric_column_can_be_named() {
    let folder = Folder::new();
    let header = "x,y,z,flat_xx,flat_xy,flat_xz,flat_yy,flat_yz,flat_zz";
    let rows = "0,0,0,4,0,0,16,0,4\n0.5,0,0,4,0,0,16,0,4\n";
    folder.write("p.csv", format!("{header}\n{rows}"));
    folder.done(&format!("render p.csv -o round.png {SMALL} --support 0.5"));
    folder.done(&format!("render p.csv -o flat.png {SMALL} --metric flat"));
    assert_ne!(folder.read("round.png"), folder.read("flat.png"));
    folder.fails(
        &format!("render p.csv -o out.png {SMALL} --metric missing"),
        2,
        &["missing"],
    );
}

#[test]
fn stats_have_exactly_the_keys_of_the_contract() {
    let folder = Folder::with_water();
    folder.done(&format!(
        "render water.vtk -o a.png {SMALL} --stats s.json --threads 2"
    ));
    let stats = folder.json("s.json");
    let sorted = |value: &Value| {
        let mut keys: Vec<String> = value.as_object().unwrap().keys().cloned().collect();
        keys.sort();
        keys.join(" ")
    };
    assert_eq!(
        sorted(&stats),
        "build_secs device dropped engine image kernel particles peak_rss_bytes rays read_secs \
         render_secs simd spacing structure_bytes support_max support_min threads threshold \
         total_secs weights write_secs"
    );
    assert_eq!(sorted(&stats["image"]), "height mean_samples spp width");
    assert_eq!(
        sorted(&stats["rays"]),
        "ambient_occlusion diffuse primary reflection refraction shadow"
    );
    assert_eq!(stats["particles"], 300);
    assert_eq!(
        (&stats["kernel"], &stats["weights"]),
        (&"sextic".into(), &"volume".into())
    );
    assert_eq!(
        (&stats["engine"], &stats["device"]),
        (&"cells".into(), &"cpu".into())
    );
    assert_eq!(stats["threads"], 2);
    assert_eq!(stats["rays"]["primary"], 96 * 54 * 2);
    let total = stats["total_secs"].as_f64().unwrap();
    let parts: f64 = ["read_secs", "build_secs", "render_secs", "write_secs"]
        .iter()
        .map(|key| stats[key].as_f64().unwrap())
        .sum();
    assert!(parts > 0.0 && parts <= total + 1e-6, "{stats}");
    assert!(stats["structure_bytes"].as_u64().unwrap() > 0);
}

#[test]
fn sequences_keep_numbers_padding_camera_and_colours() {
    let folder = Folder::new();
    folder.done("generate splash -o 's_{}.vtk' --count 300 --frames 12");
    let words = "render 's_{}.vtk' --size 64x36 --spp 1 --color-by velocity --color-range 0,3";
    folder.done(&format!(
        "{words} -o 'p_{{}}.png' --frames 3-12x4 --stats s.json --ground"
    ));
    let pictures: Vec<String> = folder
        .names()
        .into_iter()
        .filter(|n| n.starts_with("p"))
        .collect();
    assert_eq!(
        pictures,
        [
            "p.legend.json",
            "p.legend.png",
            "p_03.png",
            "p_07.png",
            "p_11.png"
        ]
    );
    assert_eq!(
        folder.json("p.legend.json")["range"],
        serde_json::json!([0.0, 3.0])
    );
    assert_eq!(folder.json("s.json")["frames"].as_array().unwrap().len(), 3);
    // One frame alone is the same picture: nothing depends on which frames are rendered.
    folder.done(&format!("{words} -o 'q_{{}}.png' --frames 7 --ground"));
    assert_eq!(folder.read("p_07.png"), folder.read("q_07.png"));
    // Several files are a sequence too.
    folder.done("render s_07.vtk s_03.vtk -o 'r_{}.png' --size 16x9 --spp 1");
    assert!(folder.names().contains(&"r_03.png".to_owned()));
}

#[test]
fn regions_and_sample_ranges_are_parts_of_the_picture() {
    let folder = Folder::with_water();
    folder.done("render water.vtk -o whole.png --size 64x36 --spp 4");
    folder
        .done("render water.vtk -o same.png --size 64x36 --spp 4 --samples 0-3 --region 0,0,64,36");
    assert_eq!(folder.read("whole.png"), folder.read("same.png"));
    folder.done("render water.vtk -o part.png --size 64x36 --spp 4 --region 16,9,32,18");
    let part = folder.read("part.png");
    let side = |at: usize| u32::from_be_bytes([part[at], part[at + 1], part[at + 2], part[at + 3]]);
    assert_eq!((side(16), side(20)), (32, 18));
    folder.done("render water.vtk -o deep.png --size 64x36 --spp 1 --png-depth 16");
    assert_eq!(folder.read("deep.png")[24], 16);
}

#[test]
fn nothing_but_lines_goes_into_a_pipe() {
    let folder = Folder::with_water();
    let quiet = folder.done(&format!("render water.vtk -o a.png {SMALL} --support 0.2"));
    assert_eq!((&quiet.stdout[..], &quiet.stderr[..]), ("", ""));
    let verbose = folder.done(&format!("render water.vtk -o a.png {SMALL} -v"));
    assert!(verbose.stderr.contains("wrote a.png"), "{}", verbose.stderr);
    assert!(
        !has_control_characters(&verbose.stderr),
        "{}",
        verbose.stderr
    );
    let wrong = folder.run("render water.vtk -o a.png --set surface.0.treshold=1");
    assert!(!has_control_characters(&wrong.stderr), "{}", wrong.stderr);
}

#[test]
fn json_progress_is_one_object_a_line() {
    let folder = Folder::with_water();
    let ended = folder.done(&format!(
        "render water.vtk -o a.png {SMALL} --progress json"
    ));
    let events: Vec<Value> = ended
        .stderr
        .lines()
        .map(|line| serde_json::from_str(line).unwrap_or_else(|_| panic!("{line}")))
        .collect();
    let named = |name: &str| events.iter().filter(|event| event["event"] == name).count();
    assert_eq!(
        (
            named("start"),
            named("frame"),
            named("frame_done"),
            named("done")
        ),
        (1, 1, 1, 1)
    );
    let fractions: Vec<f64> = events
        .iter()
        .filter(|event| event["event"] == "progress")
        .map(|event| event["fraction"].as_f64().unwrap())
        .collect();
    assert!(fractions.len() >= 3, "{fractions:?}");
    assert!(
        fractions
            .iter()
            .all(|fraction| (0.0..=1.0).contains(fraction))
    );
}

#[test]
fn integrators_count_the_rays_that_they_are_about() {
    let folder = Folder::with_water();
    folder.write(
        "clear.toml",
        "[[surface]]\nfile = \"water.vtk\"\nmaterial = \"clear\"\n[ground]\n\
         [material.clear]\ntype = \"water\"\n",
    );
    for (flags, kinds) in [
        ("--integrator shaded", &["primary", "shadow"][..]),
        ("--integrator ao", &["primary", "ambient_occlusion"]),
        (
            "--integrator whitted",
            &["primary", "shadow", "reflection", "refraction"],
        ),
        (
            "--integrator path",
            &["primary", "shadow", "reflection", "refraction", "diffuse"],
        ),
    ] {
        for threads in [1, 3] {
            folder.done(&format!(
                "render clear.toml -o {threads}.png {SMALL} {flags} --threads {threads} --stats s.json"
            ));
        }
        assert_eq!(folder.read("1.png"), folder.read("3.png"), "{flags}");
        let rays = folder.json("s.json")["rays"].clone();
        for (kind, count) in rays.as_object().unwrap() {
            let expected = kinds.contains(&kind.as_str());
            assert_eq!(count.as_u64().unwrap() > 0, expected, "{flags}: {rays}");
        }
    }
}

#[test]
fn presets_choose_their_integrator_and_flags_override_it() {
    let folder = Folder::with_water();
    let refracted = |flags: &str| {
        folder.done(&format!(
            "render water.vtk -o out.png {SMALL} --stats s.json {flags}"
        ));
        folder.json("s.json")["rays"]["refraction"]
            .as_u64()
            .unwrap()
            > 0
    };
    assert!(refracted("--preset water"));
    assert!(refracted("--preset honey"));
    assert!(!refracted("--preset mercury"));
    assert!(!refracted("--preset milk"));
    assert!(!refracted("--preset water --integrator shaded"));
    assert!(!refracted("--preset clay"));
}

#[test]
fn noise_and_time_end_the_sampling_early() {
    let folder = Folder::with_water();
    let flags = "--size 48x32 --integrator path --ground --stats s.json";
    folder.done(&format!(
        "render water.vtk -o a.exr {flags} --noise 0.2 --aov samples"
    ));
    let mean = |folder: &Folder| {
        folder.json("s.json")["image"]["mean_samples"]
            .as_f64()
            .unwrap()
    };
    assert!((16.0..1024.0).contains(&mean(&folder)), "{}", mean(&folder));
    folder.done(&format!(
        "render water.vtk -o b.png {flags} --time-limit 0.01"
    ));
    assert!(mean(&folder) >= 1.0);
    folder.done(&format!("render water.vtk -o c.png {flags} --spp 3"));
    assert_eq!(mean(&folder), 3.0);
}
