//! `--device`: on machines without a card, and on a software driver where there is one.

use crate::run::{Ended, Folder};
use meniscus_testing::image::{Budget, Picture};
use npyz::npz::NpzArchive;

/// Fails tests where there is no adapter.
const REQUIRE_VARIABLE: &str = "MENISCUS_REQUIRE_GPU";

/// Runs `meniscus` where software drivers count.
fn run_on_software(folder: &Folder, words: &str, variables: &[(&str, &str)]) -> Ended {
    let mut command = folder.command(words);
    command.env("MENISCUS_GPU", "software");
    command.envs(variables.iter().copied());
    Ended::of(command)
}

/// Whether a driver is there to test with; if not, that is said.
#[expect(clippy::print_stderr, reason = "tests say what they skip")]
fn has_driver(folder: &Folder, test: &str) -> bool {
    let ended = run_on_software(
        folder,
        "bench water.toml --device gpu --size 4x4 --repeats 1",
        &[],
    );
    let missing = ended.code == Some(1) && ended.stderr.contains("no graphics card");
    assert!(missing || ended.code == Some(0), "{test}: {}", ended.stderr);
    if missing {
        assert!(
            std::env::var_os(REQUIRE_VARIABLE).is_none(),
            "{test}: {}; {REQUIRE_VARIABLE} forbids to skip it",
            ended.stderr
        );
        eprintln!("skipped {test}: {}", ended.stderr);
    }
    !missing
}

#[test]
fn what_a_card_cannot_do_is_said() {
    let folder = Folder::with_water();
    for (words, part) in [
        (
            "render water.toml -o a.png --engine cells",
            "--engine cells",
        ),
        ("bench paper gourmel-1", "bench paper"),
    ] {
        let words = format!("{words} --device gpu");
        folder.fails(&words, 2, &[part, "--device cpu"]);
    }
}

#[test]
fn without_a_card_the_processor_does_it_or_that_is_an_error() {
    let folder = Folder::with_water();
    let small = "render water.toml --size 32x24 --spp 1 --stats stats.json";
    folder.fails(
        &format!("{small} -o a.png --device gpu"),
        1,
        &["no graphics card", "--device cpu"],
    );
    let auto = folder.done(&format!("{small} -o auto.png"));
    assert_eq!(folder.json("stats.json")["device"], "cpu");
    assert_eq!(folder.json("stats.json")["engine"], "cells");
    let cpu = folder.done(&format!("{small} -o cpu.png --device cpu"));
    assert_eq!(folder.read("auto.png"), folder.read("cpu.png"));
    assert_eq!(auto.stderr, cpu.stderr);
}

#[test]
fn a_picture_is_that_of_the_processor() {
    let folder = Folder::with_water();
    if !has_driver(&folder, "a_picture_is_that_of_the_processor") {
        return;
    }
    let words = "render water.toml --size 160x120 --spp 2 --ground --stats stats.json";
    let ended = run_on_software(&folder, &format!("{words} -o gpu.png --device gpu"), &[]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let stats = folder.json("stats.json");
    assert_eq!(stats["device"], "gpu");
    assert_eq!(stats["engine"], "particles");
    folder.done(&format!("{words} -o cpu.png"));
    let [gpu, cpu] = ["gpu.png", "cpu.png"].map(|name| Picture::read(&folder.path(name)));
    let budget = Budget::default();
    let difference = gpu.difference(&cpu, budget.channel);
    assert!(
        difference.pixels <= budget.pixels && difference.mean <= budget.mean,
        "{difference:?}"
    );
    // Never by itself.
    let ended = run_on_software(&folder, &format!("{words} -o auto.png"), &[]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    assert_eq!(folder.json("stats.json")["device"], "cpu");
}

/// Every integrator, on a tree that the card builds too; frame after frame.
#[test]
fn integrators_and_builders_give_the_same_pictures() {
    let folder = Folder::with_water();
    if !has_driver(&folder, "integrators_and_builders_give_the_same_pictures") {
        return;
    }
    let budget = Budget::default();
    for (integrator, builder) in [("path", "device"), ("whitted", "sah"), ("ao", "morton")] {
        let words = format!(
            "render water.toml --size 64x48 --spp 2 --turntable 2 --integrator {integrator} \
             --set engine.builder={builder}"
        );
        let ended = run_on_software(
            &folder,
            &format!("{words} -o gpu{{}}.png --device gpu"),
            &[],
        );
        assert_eq!(ended.code, Some(0), "{}", ended.stderr);
        folder.done(&format!("{words} -o cpu{{}}.png --engine particles"));
        for number in 0..2 {
            let [gpu, cpu] = ["gpu", "cpu"]
                .map(|name| Picture::read(&folder.path(&format!("{name}{number}.png"))));
            let difference = gpu.difference(&cpu, budget.channel);
            assert!(
                difference.pixels <= budget.pixels && difference.mean <= budget.mean,
                "{integrator} {number}: {difference:?}"
            );
        }
    }
}

#[test]
fn a_card_says_how_long_it_builds() {
    let folder = Folder::with_water();
    if !has_driver(&folder, "a_card_says_how_long_it_builds") {
        return;
    }
    let words = "bench water.toml --device gpu --size 8x8 --repeats 2 --json";
    for builder in ["device", "morton"] {
        let ended = run_on_software(
            &folder,
            &format!("{words} --set engine.builder={builder}"),
            &[],
        );
        assert_eq!(ended.code, Some(0), "{}", ended.stderr);
        let report: serde_json::Value = serde_json::from_str(&ended.stdout).unwrap();
        let secs = |key: &str| report["on_card"][key].as_f64().unwrap();
        assert!(secs("send_secs") > 0.0 && secs("update_secs") > 0.0);
        assert_eq!(secs("own_build_secs") > 0.0, builder == "device");
        assert_eq!(secs("own_update_secs") > 0.0, builder == "device");
    }
}

#[test]
fn engine_peel_needs_a_card_and_says_what_it_cannot() {
    let folder = Folder::with_water();
    let small = "render water.toml -o a.png --size 32x24 --engine peel";
    folder.fails(
        &format!("{small} --device cpu"),
        2,
        &["card", "--device gpu"],
    );
    folder.fails(small, 1, &["no graphics card", "particles"]);
    crate::trace::write_rays(&folder, 8, &[0.0, 0.0, 9.0, 0.0, 0.0, -1.0, 0.0, 9.0]);
    folder.fails(
        "trace water.toml --rays rays.npy -o a.npz --engine peel",
        2,
        &["--engine peel", "camera"],
    );
    folder.fails("bench paper kanamori-gpu", 1, &["no graphics card"]);
    folder.fails("bench paper kanamori-1 --device gpu", 2, &["bench paper"]);
    if !has_driver(&folder, "engine_peel_needs_a_card_and_says_what_it_cannot") {
        return;
    }
    for (words, part) in [
        ("--anisotropy estimate", "ellipsoids"),
        (
            "--set engine.peel=sprites --set engine.clipping=nishita",
            "nishita",
        ),
    ] {
        let words = format!("{small} --device gpu {words}");
        let ended = run_on_software(&folder, &words, &[]);
        assert_eq!(ended.code, Some(2), "{words}: {}", ended.stderr);
        assert!(ended.stderr.contains(part), "{}", ended.stderr);
    }
}

#[test]
fn engine_peel_s_picture_is_that_of_the_processor() {
    let folder = Folder::with_water();
    if !has_driver(&folder, "engine_peel_s_picture_is_that_of_the_processor") {
        return;
    }
    let words = "render water.toml --size 160x120 --spp 2 --ground --stats stats.json";
    for (variant, integrator) in [
        ("tiles", "shaded"),
        ("sprites", "shaded"),
        ("tiles", "path"),
    ] {
        let words = format!("{words} --integrator {integrator}");
        folder.done(&format!("{words} -o cpu.png"));
        let cpu = Picture::read(&folder.path("cpu.png"));
        let peel = format!("--device gpu --engine peel --set engine.peel={variant}");
        let ended = run_on_software(&folder, &format!("{words} -o gpu.png {peel}"), &[]);
        assert_eq!(ended.code, Some(0), "{}", ended.stderr);
        assert_eq!(folder.json("stats.json")["engine"], "peel");
        let budget = Budget::default();
        let difference = Picture::read(&folder.path("gpu.png")).difference(&cpu, budget.channel);
        assert!(
            difference.pixels <= budget.pixels && difference.mean <= budget.mean,
            "{variant}: {difference:?}"
        );
        let words = format!("bench water.toml --size 64x48 --repeats 1 --json {peel}");
        let ended = run_on_software(&folder, &words, &[]);
        assert_eq!(ended.code, Some(0), "{}", ended.stderr);
        let report: serde_json::Value = serde_json::from_str(&ended.stdout).unwrap();
        assert_eq!(report["engine"], "peel");
        assert!(
            report["peel"]["listed"].as_f64().unwrap() > 100.0,
            "{report}"
        );
        let layers = report["peel"]["layers"].as_f64().unwrap();
        assert_eq!(layers > 0.0, variant == "sprites", "{report}");
        assert!(report["primary"]["hit_fraction"].as_f64().unwrap() > 0.02);
    }
}

#[test]
fn rays_of_a_file_hit_the_same() {
    let folder = Folder::with_water();
    if !has_driver(&folder, "rays_of_a_file_hit_the_same") {
        return;
    }
    // From above, all over the box of the particles.
    let info = folder.done("info water.vtk --json").stdout;
    let info: serde_json::Value = serde_json::from_str(&info).unwrap();
    let bound =
        |end: usize, axis: usize| info["bounds"][["min", "max"][end]][axis].as_f64().unwrap();
    let mut numbers: Vec<f64> = (0..200)
        .flat_map(|i| {
            let at =
                |axis: usize, part: f64| bound(0, axis) + part * (bound(1, axis) - bound(0, axis));
            let (x, z) = (f64::from(i % 20) / 20.0, f64::from(i / 20) / 10.0);
            let height = bound(1, 1) + 3.0;
            [
                at(0, x),
                height,
                at(2, z),
                0.1,
                -1.0,
                0.05,
                0.0,
                f64::INFINITY,
            ]
        })
        .collect();
    // No ray, and one that ends before anything.
    numbers.extend([f64::NAN, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
    numbers.extend([0.5, 3.0, 0.5, 0.0, -1.0, 0.0, 0.0, 0.1]);
    crate::trace::write_rays(&folder, 8, &numbers);
    let read = |name: &str| -> (Vec<f64>, Vec<i64>) {
        let mut archive = NpzArchive::open(folder.path(name)).unwrap();
        let t = archive.by_name("t").unwrap().unwrap().into_vec().unwrap();
        let id = archive.by_name("id").unwrap().unwrap().into_vec().unwrap();
        (t, id)
    };
    let words = "trace water.toml --rays rays.npy -o";
    let ended = run_on_software(&folder, &format!("{words} gpu.npz --device gpu"), &[]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    folder.done(&format!("{words} cpu.npz --engine particles"));
    let ((gpu, gpu_ids), (cpu, cpu_ids)) = (read("gpu.npz"), read("cpu.npz"));
    assert!(cpu.iter().filter(|t| t.is_finite()).count() > 50);
    for (i, (a, b)) in gpu.iter().zip(&cpu).enumerate() {
        assert!(a == b || (a - b).abs() < 1e-5, "ray {i}: {a} and {b}");
    }
    assert_eq!(gpu_ids, cpu_ids);
    let ended = run_on_software(&folder, &format!("{words} any.npz --device gpu --any"), &[]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let mut archive = NpzArchive::open(folder.path("any.npz")).unwrap();
    let any: Vec<bool> = archive
        .by_name("occluded")
        .unwrap()
        .unwrap()
        .into_vec()
        .unwrap();
    let hit: Vec<bool> = cpu.iter().map(|t| t.is_finite()).collect();
    assert_eq!(any, hit);
    let ended = run_on_software(&folder, &format!("{words} all.npz --device gpu --all"), &[]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    folder.done(&format!("{words} all-cpu.npz --engine particles --all"));
    let crossings = |name: &str| -> (Vec<i64>, Vec<f64>, Vec<bool>) {
        let mut archive = NpzArchive::open(folder.path(name)).unwrap();
        let ray = archive.by_name("ray").unwrap().unwrap().into_vec().unwrap();
        let t = archive.by_name("t").unwrap().unwrap().into_vec().unwrap();
        let entering = archive.by_name("entering").unwrap().unwrap();
        (ray, t, entering.into_vec().unwrap())
    };
    let (gpu, cpu) = (crossings("all.npz"), crossings("all-cpu.npz"));
    assert!(cpu.0.len() > 100, "{}", cpu.0.len());
    assert_eq!((&gpu.0, &gpu.2), (&cpu.0, &cpu.2));
    for (a, b) in gpu.1.iter().zip(&cpu.1) {
        assert!((a - b).abs() < 1e-5, "{a} and {b}");
    }
}

#[test]
fn a_device_that_goes_away_is_an_error() {
    let folder = Folder::with_water();
    if !has_driver(&folder, "a_device_that_goes_away_is_an_error") {
        return;
    }
    let before = folder.names();
    let ended = run_on_software(
        &folder,
        "render water.toml -o out.png --size 600x40 --spp 2 --device gpu",
        &[("MENISCUS_GPU_LOSE_AFTER", "2")],
    );
    assert_eq!(ended.code, Some(1), "{}", ended.stderr);
    assert!(ended.stderr.contains("was lost"), "{}", ended.stderr);
    assert!(ended.stderr.contains("--device cpu"), "{}", ended.stderr);
    assert_eq!(folder.names(), before);
}
