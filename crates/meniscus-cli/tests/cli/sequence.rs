//! Slow motion, trajectories and running simulations.

use crate::run::{Folder, is_whole_png};
use std::io::Write;
use std::process::Stdio;
use std::time::{Duration, Instant};

const TINY: &str = "--size 32x18 --spp 1";
const TEXT: &str = "id,x,y,z,vx,vy,vz";

/// Three particles in frame `number`: one stays, one comes, one goes, all along x.
fn frame(number: u32, ids: &[u32], speed: f64) -> String {
    let mut text = format!("{TEXT}\n");
    for id in ids {
        let x = f64::from(number) * 0.1;
        text += &format!("{id},{x},{},0,{speed},0,0\n", id * 2);
    }
    text
}

fn pictures(folder: &Folder, prefix: &str) -> Vec<String> {
    let names = folder.names();
    let pictures = names
        .iter()
        .filter(|name| name.starts_with(prefix) && name.ends_with(".png"));
    pictures.cloned().collect()
}

#[test]
fn slow_motion_fills_the_intervals() {
    let folder = Folder::new();
    folder.done("generate fountain -o 'f_{}.vtk' --count 300 --frames 4");
    let camera = "--camera-eye 0,1.5,6 --camera-target 0,0.9,0 --radius 0.05";
    let slow = format!("render 'f_{{}}.vtk' {TINY} {camera}");
    folder.done(&format!(
        "{slow} -o 's_{{}}.png' --slow-motion 4 --stats s.json"
    ));
    // Three intervals of four pictures, and the last frame.
    assert_eq!(pictures(&folder, "s_").len(), 13);
    assert_eq!(
        folder.json("s.json")["frames"].as_array().unwrap().len(),
        13
    );
    folder.done(&format!("{slow} -o 'p_{{}}.png'"));
    for frame in 0..4 {
        let moment = folder.read(&format!("s_{:02}.png", 4 * frame));
        assert_eq!(
            moment,
            folder.read(&format!("p_{}.png", frame + 1)),
            "{frame}"
        );
    }
    // Between them there is something else.
    assert_ne!(folder.read("s_01.png"), folder.read("s_00.png"));
    assert_ne!(folder.read("s_03.png"), folder.read("s_04.png"));
    // Any factor: moments 0, 0.4, 0.8, … up to 3.
    folder.done(&format!("{slow} -o 't_{{}}.png' --slow-motion 2.5"));
    assert_eq!(pictures(&folder, "t_").len(), 8);
    // The way over a missing frame takes as long as with it.
    std::fs::remove_file(folder.path("f_3.vtk")).unwrap();
    let ended = folder.done(&format!("{slow} -o 'g_{{}}.png' --slow-motion 4"));
    assert_eq!(pictures(&folder, "g_").len(), 13);
    assert!(ended.stderr.contains("frame 3"), "{}", ended.stderr);
    // Ballistic ways are the same over the gap, for those that live through it.
    assert_eq!(folder.read("g_02.png"), folder.read("s_02.png"));
}

#[test]
fn coming_and_going_particles_are_seen_in_part() {
    let folder = Folder::new();
    folder.write("c_1.csv", frame(1, &[0, 1], 2.5));
    folder.write("c_2.csv", frame(2, &[0, 2], 2.5));
    folder.done(&format!(
        "render 'c_{{}}.csv' -o 'c_{{}}.exr' --slow-motion 4 {TINY} --radius 0.5 --stats s.json"
    ));
    let frames = folder.json("s.json")["frames"].clone();
    let particles = |frame: usize| frames[frame]["particles"].as_u64().unwrap();
    let smallest = |frame: usize| frames[frame]["support_min"].as_f64().unwrap();
    assert_eq!([0, 1, 2, 3, 4].map(particles), [2, 3, 3, 3, 2]);
    let supports = [0, 1, 2, 3, 4].map(|frame| smallest(frame) / smallest(0));
    for (found, expected) in supports.into_iter().zip([1.0, 0.25, 0.5, 0.25, 1.0]) {
        assert!((found - expected).abs() < 1e-6, "{supports:?}");
    }
}

#[test]
fn frames_without_particles_show_nothing_and_decide_nothing() {
    let folder = Folder::new();
    // An emitter that starts late and stops early.
    for (number, ids) in [(1, &[][..]), (2, &[0, 1, 2]), (3, &[0, 1, 2]), (4, &[])] {
        folder.write(&format!("e_{number}.csv"), frame(number, ids, 2.5));
    }
    let ended = folder.done(&format!(
        "render 'e_{{}}.csv' -o 'a_{{}}.png' {TINY} --stats s.json"
    ));
    assert_eq!(pictures(&folder, "a_").len(), 4);
    assert!(ended.stderr.contains("e_1.csv"), "{}", ended.stderr);
    assert!(ended.stderr.contains("shows nothing"), "{}", ended.stderr);
    let frames = folder.json("s.json")["frames"].clone();
    let particles = |frame: usize| frames[frame]["particles"].as_u64().unwrap();
    assert_eq!([0, 1, 2, 3].map(particles), [0, 3, 3, 0]);
    assert_eq!(folder.read("a_1.png"), folder.read("a_4.png"));
    assert_ne!(folder.read("a_1.png"), folder.read("a_2.png"));
    // Camera and radius are those of the first frame with particles, whatever comes before it, is
    // selected, or appears one by one.
    folder.done(&format!(
        "render e_2.csv e_3.csv -o 'b_{{}}.png' {TINY} --radius 0.5"
    ));
    folder.done(&format!(
        "render 'e_{{}}.csv' -o 'c_{{}}.png' {TINY} --radius 0.5 --frames 3"
    ));
    assert_eq!(folder.read("c_3.png"), folder.read("b_3.png"));
    folder.done(&format!(
        "render 'e_{{}}.csv' -o 'd_{{}}.png' {TINY} --watch --watch-timeout 1"
    ));
    for number in 1..=4 {
        let of = |prefix: &str| folder.read(&format!("{prefix}_{number}.png"));
        assert_eq!(of("a"), of("d"), "{number}");
    }
    // Those that come within an interval fade in; layers stay what they are.
    let slow = "--slow-motion 2 --radius 0.5 --aov id --stats s.json";
    folder.done(&format!(
        "render 'e_{{}}.csv' -o 's_{{}}.exr' {TINY} {slow}"
    ));
    let frames = folder.json("s.json")["frames"].clone();
    let particles = |frame: usize| frames[frame]["particles"].as_u64().unwrap();
    assert_eq!([0, 1, 2, 3, 4, 5, 6].map(particles), [0, 3, 3, 3, 3, 3, 0]);
    // A picture of nothing alone is a mistake, and so is a sequence of nothing.
    folder.fails(
        &format!("render e_1.csv -o o.png {TINY}"),
        1,
        &["e_1.csv", "no particle is left"],
    );
    folder.fails(
        &format!("render 'e_{{}}.csv' -o 'o_{{}}.png' {TINY} --filter 'id > 7'"),
        1,
        &["no frame of the sequence holds a particle", "--filter"],
    );
}

#[test]
fn what_is_wrong_with_slow_motion_is_said() {
    let folder = Folder::new();
    for number in 1..=2 {
        folder.write(&format!("a_{number}.csv"), frame(number, &[0, 1], 250.0));
        folder.write(&format!("b_{number}.csv"), frame(number, &[4, 7, 4], 2.5));
        let without = frame(number, &[0, 1], 2.5).replace("id,", "kind,");
        folder.write(&format!("n_{number}.csv"), without);
    }
    let words = |name: &str| {
        format!("render '{name}_{{}}.csv' -o 'o_{{}}.png' {TINY} --radius 0.5 --slow-motion 2")
    };
    folder.fails(&format!("{} --frames 1", words("a")), 2, &["two frames"]);
    folder.fails(
        &format!("{} --turntable 3", words("a")),
        2,
        &["--turntable", "--slow-motion"],
    );
    for factor in ["0.5", "0", "-2", "nan", "1e9"] {
        let words = words("a").replace("--slow-motion 2", &format!("--slow-motion {factor}"));
        folder.fails(&words, 2, &["--slow-motion"]);
    }
    let ended = folder.run(&words("n"));
    assert_eq!(ended.code, Some(2), "{}", ended.stderr);
    for part in ["n_1.csv", "`id`", "kind"] {
        assert!(ended.stderr.contains(part), "{}", ended.stderr);
    }
    let ended = folder.run(&words("b"));
    assert_eq!(ended.code, Some(1), "{}", ended.stderr);
    for part in ["b_1.csv", "id 4 twice", "rows 0 and 2"] {
        assert!(ended.stderr.contains(part), "{}", ended.stderr);
    }
    // Velocities a hundred times too large: 0.1 in 1/25 s is 2.5 a second.
    let ended = folder.done(&words("a"));
    assert!(
        ended.stderr.contains("--velocity-scale 0.010"),
        "{}",
        ended.stderr
    );
    let ended = folder.done(&format!("{} --velocity-scale 0.01", words("a")));
    assert!(!ended.stderr.contains("velocity"), "{}", ended.stderr);
}

/// Twelve atoms in frames of full precision, each frame further along x.
fn trr(frames: i32) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut put = |numbers: &[i32]| bytes.extend(numbers.iter().flat_map(|n| n.to_be_bytes()));
    for frame in 0..frames {
        put(&[1993, 13, 12]);
        put(&[0x474d_585f, 0x7472_6e5f, 0x6669_6c65]);
        put(&[0, 0, 36, 0, 0, 0, 0, 144, 0, 0, 12, frame, 0]);
        put(&[0; 11]);
        for atom in 0..12_i16 {
            let at = [f32::from(atom) * 0.15 + frame as f32 * 0.05, 0.0, 0.0];
            put(&at.map(|x| x.to_bits() as i32));
        }
    }
    bytes
}

fn pdb(atoms: usize) -> String {
    let row = |serial: usize| {
        format!(
            "ATOM  {serial:5}  CA  ALA A{serial:4}       0.000   0.000   0.000  1.00  0.00           C\n"
        )
    };
    (1..=atoms).map(row).collect()
}

#[test]
fn a_trajectory_moves_its_topology() {
    let folder = Folder::new();
    folder.write("t.pdb", pdb(12));
    folder.write("t.trr", trr(3));
    folder.done(&format!(
        "render t.pdb t.trr -o 'o_{{}}.png' {TINY} --stats s.json"
    ));
    assert_eq!(pictures(&folder, "o_"), ["o_0.png", "o_1.png", "o_2.png"]);
    assert_ne!(folder.read("o_0.png"), folder.read("o_2.png"));
    let frames = folder.json("s.json")["frames"].clone();
    // Van der Waals radii of carbon: ångström, as the topology has them.
    let spacing = frames[1]["spacing"].as_f64().unwrap();
    assert!((spacing - 1.5).abs() < 1e-5, "{spacing}");
    folder.done(&format!(
        "render t.pdb t.trr -o 'h_{{}}.png' {TINY} --frames 1-2"
    ));
    assert_eq!(pictures(&folder, "h_"), ["h_1.png", "h_2.png"]);
    assert_eq!(folder.read("h_2.png"), folder.read("o_2.png"));
    folder.done(&format!(
        "render t.pdb t.trr -o 'w_{{}}.png' {TINY} --slow-motion 3"
    ));
    assert_eq!(pictures(&folder, "w_").len(), 7);
    // Two parts follow each other.
    folder.done(&format!("render t.pdb t.trr t.trr -o 'd_{{}}.png' {TINY}"));
    assert_eq!(folder.read("d_5.png"), folder.read("o_2.png"));
    folder.write("u.pdb", pdb(11));
    folder.write("cut.trr", &trr(3)[..500]);
    folder.write("w.csv", frame(1, &[0, 1], 1.0));
    let out = format!("-o 'x_{{}}.png' {TINY}");
    folder.fails(
        &format!("render u.pdb t.trr {out}"),
        1,
        &["12 atoms", "has 11", "t.trr"],
    );
    folder.fails(&format!("render t.trr {out}"), 2, &["topology.pdb"]);
    folder.fails(&format!("render w.csv t.trr {out}"), 2, &["w.csv", "PDB"]);
    folder.fails(
        &format!("render t.pdb u.pdb t.trr {out}"),
        2,
        &["one molecule file"],
    );
    folder.fails("info t.trr", 2, &["topology.pdb"]);
    let cut = folder.done(&format!("render t.pdb cut.trr {out}"));
    assert!(cut.stderr.contains("no whole frame"), "{}", cut.stderr);
}

#[test]
fn real_trajectories_agree_with_the_models_of_their_molecule() {
    let Some(folder_of_data) = meniscus_testing::data::file("molecules/biotite") else {
        return;
    };
    let folder = Folder::new();
    for ending in ["pdb", "gro", "xtc", "trr", "dcd"] {
        let name = format!("1l2y.{ending}");
        std::fs::copy(folder_of_data.join(&name), folder.path(&name)).unwrap();
    }
    let camera = "--camera-eye 0,0,60 --camera-target 0,0,0 --frames 0,17,37";
    for ending in ["", "xtc", "trr", "dcd"] {
        let trajectory = if ending.is_empty() {
            String::new()
        } else {
            format!("1l2y.{ending}")
        };
        folder.done(&format!(
            "render 1l2y.pdb {trajectory} -o '{ending}_{{}}.exr' {TINY} {camera} --aov position"
        ));
    }
    for number in ["00", "17", "37"] {
        let pixels = |ending: &str| {
            let image = exr::prelude::read_first_flat_layer_from_file(
                folder.path(&format!("{ending}_{number}.exr")),
            )
            .unwrap();
            let depth = image.layer_data.channel_data.list.iter();
            let depth = depth.clone().find(|c| c.name.to_string() == "Z").unwrap();
            depth.sample_data.values_as_f32().collect::<Vec<f32>>()
        };
        let models = pixels("");
        for ending in ["xtc", "trr", "dcd"] {
            let off = pixels(ending)
                .into_iter()
                .zip(&models)
                .filter(|(a, b)| (a.is_finite() != b.is_finite()) || (a - *b).abs() > 0.05);
            // The atoms are rounded to 0.01 Å, so outlines may differ.
            assert!(off.count() <= 6, "{ending} {number}");
        }
    }
}

#[test]
fn frames_of_a_running_simulation_are_rendered_once_they_are_whole() {
    let folder = Folder::new();
    folder.done("generate fountain -o 'source_{}.vtk' --count 200 --frames 4");
    let words = format!(
        "render 'f_{{}}.vtk' --watch --watch-timeout 20 --frames 1-4 -o 'p_{{}}.png' {TINY} \
         --radius 0.05 --stats s.json"
    );
    folder.write("f_1.vtk", folder.read("source_1.vtk"));
    let child = folder
        .command(&words)
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // The second one grows for a while, so that half of it stands there.
    let second = folder.read("source_2.vtk");
    let mut file = std::fs::File::create(folder.path("f_2.vtk")).unwrap();
    for part in second.chunks(second.len() / 6 + 1) {
        file.write_all(part).unwrap();
        file.flush().unwrap();
        std::thread::sleep(Duration::from_millis(250));
    }
    drop(file);
    for number in [3, 4] {
        folder.write(
            &format!("f_{number}.vtk"),
            folder.read(&format!("source_{number}.vtk")),
        );
    }
    let output = child.wait_with_output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(0), "{said}");
    assert!(!said.contains("left out"), "{said}");
    assert_eq!(pictures(&folder, "p_").len(), 4);
    folder.done(&format!(
        "render 'f_{{}}.vtk' -o 'q_{{}}.png' {TINY} --radius 0.05"
    ));
    for number in 1..=4 {
        let name = |prefix: char| format!("{prefix}_{number}.png");
        assert_eq!(folder.read(&name('p')), folder.read(&name('q')), "{number}");
    }
}

#[test]
fn watching_ends_when_nothing_comes() {
    let folder = Folder::with_water();
    folder.write("w_1.vtk", folder.read("water.vtk"));
    folder.write("w_2.vtk", &folder.read("water.vtk")[..900]);
    let words = format!("render 'w_{{}}.vtk' --watch --watch-timeout 1.5 -o 'p_{{}}.png' {TINY}");
    let ended = folder.done(&words);
    assert!(
        ended.stderr.contains("frame 2 is left out"),
        "{}",
        ended.stderr
    );
    assert_eq!(pictures(&folder, "p_"), ["p_1.png"]);
    // Nothing there at all is no error: it may come.
    let nothing = words
        .replace("w_{}.vtk", "none_{}.vtk")
        .replace("1.5", "0.3");
    folder.done(&nothing);
    folder.fails(
        &format!("render 'w_{{}}.vtk' --watch -o p.png {TINY}"),
        2,
        &["{}"],
    );
    folder.fails(
        &format!("render w_1.vtk --watch -o 'p_{{}}.png' {TINY}"),
        2,
        &["--watch"],
    );
    folder.fails(
        &format!("render 'w_{{}}.vtk' --watch-timeout 3 -o 'z_{{}}.png' {TINY}"),
        2,
        &["--watch"],
    );
    folder.fails(
        &format!("render 'w_{{}}.vtk' --watch --watch-timeout -3 -o 'z_{{}}.png' {TINY}"),
        2,
        &["--watch-timeout"],
    );
    for other in ["--slow-motion 2", "--turntable 4"] {
        let both = format!("render 'w_{{}}.vtk' --watch {other} -o 'z_{{}}.png' {TINY}");
        let option = other.split(' ').next().unwrap_or_default();
        folder.fails(&both, 2, &["--watch", option, "do not go together"]);
    }
    folder.fails(
        &format!("render 'no/w_{{}}.vtk' --watch -o 'z_{{}}.png' {TINY}"),
        1,
        &["no"],
    );
}

#[cfg(unix)]
#[test]
fn ctrl_c_ends_watching_and_finishes_the_film() {
    use std::os::unix::fs::PermissionsExt;
    let folder = Folder::with_water();
    let bin = folder.path("bin");
    std::fs::create_dir(&bin).unwrap();
    std::fs::write(
        bin.join("ffmpeg"),
        "#!/bin/sh\nfor last; do :; done; exec /bin/cat > \"$last\"\n",
    )
    .unwrap();
    std::fs::set_permissions(bin.join("ffmpeg"), PermissionsExt::from_mode(0o755)).unwrap();
    for number in 1..=2 {
        folder.write(&format!("w_{number}.vtk"), folder.read("water.vtk"));
    }
    let child = folder
        .command(&format!("render 'w_{{}}.vtk' --watch -o film.mp4 {TINY}"))
        .env("PATH", &bin)
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let second = folder.path("film.mp4.frames/frame_2.png");
    let start = Instant::now();
    while !second.exists() && start.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_millis(50));
    }
    assert!(is_whole_png(&second));
    // It is in the film before the next frame is waited for.
    std::thread::sleep(Duration::from_millis(300));
    let id = child.id().to_string();
    std::process::Command::new("kill")
        .args(["-INT", &id])
        .status()
        .unwrap();
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130));
    let film = folder.read("film.mp4");
    assert_eq!(
        film.windows(8)
            .filter(|w| w == b"\x89PNG\r\n\x1a\n")
            .count(),
        2
    );
    assert!(!folder.path("film.mp4.frames").exists());
}
