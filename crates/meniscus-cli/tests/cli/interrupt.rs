//! Ctrl-C in the middle of the work.
#![cfg(unix)]

use crate::run::{Folder, is_whole_png};
use serde_json::Value;
use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};

#[test]
fn ctrl_c_leaves_whole_files_only() {
    let folder = Folder::with_water();
    for number in 1..=3 {
        folder.write(&format!("w_{number}.vtk"), folder.read("water.vtk"));
    }
    let before = folder.names();
    // Small enough to start soon, with samples enough to last.
    let words = "render 'w_{}.vtk' -o 'p_{}.png' --size 640x360 --spp 4096 --progress json";
    let mut child = folder
        .command(words)
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
    let rendering = lines.by_ref().map_while(Result::ok).find(|line| {
        let event: Value = serde_json::from_str(line).unwrap();
        event["event"] == "progress" && event["stage"] == "render"
    });
    assert!(rendering.is_some(), "no progress line");
    let kill = Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status()
        .unwrap();
    assert!(kill.success());
    for line in lines.map_while(Result::ok) {
        assert!(!line.contains("frame_done"), "{line}");
    }
    let status = child.wait().unwrap();
    assert_eq!(status.code(), Some(130));
    assert_eq!(folder.names(), before);
}

#[test]
fn finished_frames_stay_and_resume_renders_the_rest() {
    let folder = Folder::with_water();
    for number in 1..=3 {
        folder.write(&format!("w_{number}.vtk"), folder.read("water.vtk"));
    }
    folder.done("render 'w_{}.vtk' -o 'q_{}.png' --size 32x18 --spp 1 --frames 2");
    let second = folder.read("q_2.png");
    assert!(is_whole_png(&folder.path("q_2.png")));
    folder.write("q_2.png", "kept as it is");
    folder.done("render 'w_{}.vtk' -o 'q_{}.png' --size 32x18 --spp 1 --resume");
    assert_eq!(folder.read("q_2.png"), b"kept as it is");
    for number in [1, 3] {
        assert!(is_whole_png(&folder.path(&format!("q_{number}.png"))));
    }
    folder.done("render 'w_{}.vtk' -o 'q_{}.png' --size 32x18 --spp 1");
    assert_eq!(folder.read("q_2.png"), second);
}
