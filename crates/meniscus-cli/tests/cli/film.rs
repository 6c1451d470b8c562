//! Films, what is kept of them, and frames that are prepared ahead.
#![cfg(unix)]

use crate::run::{Ended, Folder, is_whole_png};
use std::os::unix::fs::PermissionsExt;
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::time::Instant;

const TINY: &str = "--size 33x18 --spp 1";

/// A fountain of some frames, `f_01.vtk` and so on.
fn fountain(frames: u32) -> Folder {
    let folder = Folder::new();
    folder.done(&format!(
        "generate fountain -o 'f_{{}}.vtk' --count 400 --frames {frames}"
    ));
    folder
}

/// Puts a program `ffmpeg` of our own into the folder `bin`.
fn with_ffmpeg(folder: &Folder, script: &str) {
    let bin = folder.path("bin");
    std::fs::create_dir_all(&bin).unwrap();
    let program = bin.join("ffmpeg");
    std::fs::write(&program, format!("#!/bin/sh\n{script}\n")).unwrap();
    std::fs::set_permissions(&program, PermissionsExt::from_mode(0o755)).unwrap();
}

/// A "film" that is all its pictures in a row.
const CONCATENATE: &str = "for last; do :; done; exec /bin/cat > \"$last\"";

fn command(folder: &Folder, words: &str) -> Command {
    let mut command = folder.command(words);
    command.env("PATH", folder.path("bin"));
    command
}

fn run(folder: &Folder, words: &str) -> Ended {
    let output = command(folder, words).output().unwrap();
    Ended {
        code: output.status.code(),
        stdout: String::from_utf8(output.stdout).unwrap(),
        stderr: String::from_utf8(output.stderr).unwrap(),
    }
}

/// How many PNGs follow each other in a file.
fn pictures_in(film: &[u8]) -> usize {
    film.windows(8)
        .filter(|window| window == b"\x89PNG\r\n\x1a\n")
        .count()
}

#[test]
fn a_film_is_its_frames_in_order() {
    let folder = fountain(5);
    with_ffmpeg(&folder, CONCATENATE);
    let ended = run(
        &folder,
        &format!("render 'f_{{}}.vtk' -o film.mp4 {TINY} --stats s.json"),
    );
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    folder.done(&format!("render 'f_{{}}.vtk' -o 'p_{{}}.png' {TINY}"));
    let frames: Vec<u8> = (1..=5)
        .flat_map(|number| folder.read(&format!("p_{number}.png")))
        .collect();
    assert_eq!(folder.read("film.mp4"), frames);
    assert_eq!(folder.json("s.json")["frames"].as_array().unwrap().len(), 5);
    assert!(!folder.path("film.mp4.frames").exists());
    // A still turns.
    let words = format!("render f_1.vtk -o turn.mp4 {TINY} --turntable 4");
    assert_eq!(run(&folder, &words).code, Some(0));
    assert_eq!(pictures_in(&folder.read("turn.mp4")), 4);
    assert!(!folder.path("turn.mp4.frames").exists());
}

#[test]
fn the_frames_ahead_change_no_picture() {
    let folder = fountain(4);
    for threads in [1, 2, 3] {
        folder.done(&format!(
            "render 'f_{{}}.vtk' -o '{threads}_{{}}.png' {TINY} --threads {threads}"
        ));
    }
    for number in 1..=4 {
        let one = folder.read(&format!("1_{number}.png"));
        for threads in [2, 3] {
            assert_eq!(
                one,
                folder.read(&format!("{threads}_{number}.png")),
                "{number}"
            );
        }
    }
}

#[test]
fn what_is_wrong_with_films_is_said_and_nothing_stays() {
    let folder = fountain(3);
    let pattern = "render 'f_{}.vtk'";
    let refused = [
        ("-o 'film_{}.mp4'", "{}"),
        ("-o film.mp4 --aov depth", "EXR"),
        ("-o film.mp4 --background transparent", "transparent"),
        ("-o film.mp4 --fps 0", "--fps"),
        ("-o film.mp4 --fps -3", "--fps"),
        ("-o film.mp4 --png-depth 16", "8 bits"),
        ("-o film.mov", ".mp4"),
    ];
    for (flags, word) in refused {
        folder.fails(&format!("{pattern} {TINY} {flags}"), 2, &[word]);
    }
    folder.fails(
        &format!("{pattern} {TINY} -o no/film.mp4"),
        1,
        &["mkdir -p no"],
    );
    std::fs::create_dir_all(folder.path("bin")).unwrap();
    let before = folder.names();
    let absent = run(&folder, &format!("{pattern} {TINY} -o film.mp4"));
    assert_eq!(absent.code, Some(1));
    for part in ["ffmpeg", "apt install ffmpeg", "frame_{}.png"] {
        assert!(absent.stderr.contains(part), "{}", absent.stderr);
    }
    assert_eq!(folder.names(), before);
    with_ffmpeg(&folder, "echo \"Unknown encoder 'libx264'\" >&2; exit 8");
    let failed = run(&folder, &format!("{pattern} {TINY} -o film.mp4"));
    assert_eq!(failed.code, Some(1));
    assert!(
        failed.stderr.contains("Unknown encoder 'libx264'"),
        "{}",
        failed.stderr
    );
    assert!(!folder.path("film.mp4").exists());
}

#[test]
fn a_broken_frame_is_reported_in_its_turn_and_the_film_goes_on_from_there() {
    let folder = fountain(6);
    with_ffmpeg(&folder, CONCATENATE);
    let words = format!("render 'f_{{}}.vtk' -o film.mp4 {TINY}");
    assert_eq!(run(&folder, &words).code, Some(0));
    let whole = folder.read("film.mp4");
    std::fs::remove_file(folder.path("film.mp4")).unwrap();
    let fourth = folder.read("f_4.vtk");
    folder.write("f_4.vtk", &fourth[..fourth.len() / 2]);
    let broken = run(&folder, &words);
    assert_eq!(broken.code, Some(1));
    assert!(broken.stderr.contains("f_4.vtk"), "{}", broken.stderr);
    assert!(broken.stderr.contains("--resume"), "{}", broken.stderr);
    assert!(!folder.path("film.mp4").exists());
    let kept = |number: u32| folder.path(&format!("film.mp4.frames/frame_{number}.png"));
    for number in 1..=3 {
        assert!(is_whole_png(&kept(number)));
    }
    assert!(!kept(4).exists());
    folder.write("f_4.vtk", fourth);
    let resumed = run(&folder, &format!("{words} --resume --stats s.json"));
    assert_eq!(resumed.code, Some(0), "{}", resumed.stderr);
    assert!(resumed.stderr.contains("3 of 6"), "{}", resumed.stderr);
    assert_eq!(folder.json("s.json")["frames"].as_array().unwrap().len(), 3);
    assert_eq!(folder.read("film.mp4"), whole);
    assert!(!folder.path("film.mp4.frames").exists());
    // A film that is there is not made again.
    let again = run(&folder, &format!("{words} --resume --stats t.json"));
    assert_eq!(again.code, Some(0), "{}", again.stderr);
    assert!(
        again.stderr.contains("is there already"),
        "{}",
        again.stderr
    );
    assert_eq!(folder.json("t.json")["frames"].as_array().unwrap().len(), 0);
}

#[test]
fn frames_of_other_sizes_make_no_film() {
    let folder = fountain(2);
    with_ffmpeg(&folder, CONCATENATE);
    std::fs::create_dir(folder.path("film.mp4.frames")).unwrap();
    folder.done("render f_1.vtk -o film.mp4.frames/frame_1.png --size 20x20 --spp 1");
    let words = format!("render 'f_{{}}.vtk' -o film.mp4 {TINY}");
    let mixed = run(&folder, &format!("{words} --resume"));
    assert_eq!(mixed.code, Some(2), "{}", mixed.stderr);
    assert!(mixed.stderr.contains("20x20"), "{}", mixed.stderr);
    // Without --resume they are made anew.
    assert_eq!(run(&folder, &words).code, Some(0));
}

#[test]
fn killed_at_any_moment_and_resumed_every_frame_is_the_same() {
    let folder = fountain(40);
    with_ffmpeg(&folder, CONCATENATE);
    const TINY: &str = "--size 64x36 --spp 4";
    let film = format!("render 'f_{{}}.vtk' -o film.mp4 {TINY}");
    let pictures = format!("render 'f_{{}}.vtk' -o 'p_{{}}.png' {TINY}");
    let start = Instant::now();
    assert_eq!(run(&folder, &film).code, Some(0));
    let undisturbed = start.elapsed();
    let whole = folder.read("film.mp4");
    std::fs::remove_file(folder.path("film.mp4")).unwrap();
    folder.done(&format!("render 'f_{{}}.vtk' -o 'q_{{}}.png' {TINY}"));
    // Moments spread over a run, whatever it takes on this machine.
    let moments = [0.4, 0.05, 0.21, 0.13, 0.3, 0.08, 0.17];
    for words in [&film, &pictures] {
        for moment in moments.map(|moment| undisturbed.mul_f64(moment)) {
            let mut child = command(&folder, &format!("{words} --resume"))
                .stderr(Stdio::null())
                .spawn()
                .unwrap();
            std::thread::sleep(moment);
            // SIGKILL: nobody can tidy up.
            child.kill().unwrap();
            child.wait().unwrap();
            // The kill may come after the film took its place, never before it was whole.
            if folder.path("film.mp4").exists() {
                assert_eq!(folder.read("film.mp4"), whole);
            }
            for picture in finished(&folder) {
                assert!(is_whole_png(&picture), "{}", picture.display());
            }
        }
        let ended = run(&folder, &format!("{words} --resume"));
        assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    }
    assert_eq!(folder.read("film.mp4"), whole);
    for number in 1..=40 {
        let name = |prefix: char| format!("{prefix}_{number:02}.png");
        assert_eq!(folder.read(&name('p')), folder.read(&name('q')), "{number}");
    }
}

/// Everything that looks like a finished picture.
fn finished(folder: &Folder) -> Vec<PathBuf> {
    let in_folder = |name: &str| std::fs::read_dir(folder.path(name)).into_iter().flatten();
    in_folder(".")
        .chain(in_folder("film.mp4.frames"))
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|ending| ending == "png"))
        .collect()
}

#[test]
fn a_frame_missing_in_the_middle_is_named() {
    let folder = fountain(5);
    std::fs::remove_file(folder.path("f_3.vtk")).unwrap();
    let words = format!("render 'f_{{}}.vtk' -o 'p_{{}}.png' {TINY}");
    let ended = folder.done(&words);
    assert!(ended.stderr.contains("frame 3;"), "{}", ended.stderr);
    assert!(folder.path("p_5.png").exists());
    for unaffected in ["--frames 1-2", "--frames 1-5x4", "--frames 4-5"] {
        let ended = folder.done(&format!("{words} {unaffected}"));
        assert!(!ended.stderr.contains("missing"), "{}", ended.stderr);
    }
    assert!(
        folder
            .done(&format!("{words} --frames 1-5x2"))
            .stderr
            .contains("frame 3;")
    );
    // Whoever names files means these.
    let listed = folder.done(&format!(
        "render f_2.vtk f_4.vtk f_5.vtk f_1.vtk -o 'p_{{}}.png' {TINY}"
    ));
    assert!(!listed.stderr.contains("missing"), "{}", listed.stderr);
}

#[test]
fn real_films_have_all_frames_and_even_sides() {
    let is_there = |program: &str| Command::new(program).arg("-version").output().is_ok();
    if !is_there("ffmpeg") || !is_there("ffprobe") {
        eprintln!("skipped: no ffmpeg");
        return;
    }
    let folder = fountain(6);
    folder.done("render 'f_{}.vtk' -o film.mp4 --size 65x37 --spp 1 --fps 30");
    let probe = Command::new("ffprobe")
        .args(["-v", "error", "-of", "default=nw=1", "-show_entries"])
        .arg("stream=codec_name,width,height,nb_frames,r_frame_rate,pix_fmt")
        .arg(folder.path("film.mp4"))
        .output()
        .unwrap();
    let told = String::from_utf8(probe.stdout).unwrap();
    for part in [
        "codec_name=h264",
        "width=64",
        "height=36",
        "nb_frames=6",
        "r_frame_rate=30/1",
        "pix_fmt=yuv420p",
    ] {
        assert!(told.contains(part), "{part}: {told}");
    }
}
