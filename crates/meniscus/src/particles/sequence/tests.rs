use super::*;

fn folder_with(names: &[&str]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for name in names {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, "").unwrap();
    }
    folder
}

fn texts(frames: &[FrameFile]) -> Vec<&str> {
    frames.iter().map(|frame| frame.text.as_str()).collect()
}

#[test]
fn patterns_find_their_files_in_order_of_number() {
    let folder = folder_with(&[
        "f_10.vtk",
        "f_9.vtk",
        "f_0011.vtk",
        "f_x.vtk",
        "f_.vtk",
        "f_1.vtk.gz",
        "g_1.vtk",
        "f_-3.vtk",
    ]);
    let frames = matches(&folder.path().join("f_{}.vtk")).unwrap();
    assert_eq!(texts(&frames), ["9", "10", "0011"]);
    assert_eq!(frames[2].number, 11);
    assert_eq!(frames[2].path, folder.path().join("f_0011.vtk"));
    assert_eq!(
        output_path(Path::new("out/p_{}.png"), &frames[2].text),
        Path::new("out/p_0011.png")
    );
}

#[test]
fn the_placeholder_may_stand_in_a_folder() {
    let folder = folder_with(&["run2/p.ply", "run10/p.ply", "run3/q.ply"]);
    let frames = matches(&folder.path().join("run{}/p.ply")).unwrap();
    assert_eq!(texts(&frames), ["2", "10"]);
    assert!(frames[1].path.ends_with("run10/p.ply"));
}

#[test]
fn an_empty_match_names_the_folder_and_what_is_there() {
    let folder = folder_with(&["frame_1.vtu", "frame_2.vtu", "notes.txt"]);
    let error = matches(&folder.path().join("frame_{}.vtk"))
        .unwrap_err()
        .to_string();
    assert!(error.contains("frame_{}.vtk"), "{error}");
    assert!(
        error.contains(&folder.path().display().to_string()),
        "{error}"
    );
    assert!(error.contains("frame_1.vtu, frame_2.vtu"), "{error}");
    let error = matches(&folder.path().join("none/frame_{}.vtk")).unwrap_err();
    assert!(matches!(error, SequenceError::Folder { .. }), "{error}");
    let error = expand(&[folder.path().join("frame_3.vtu")])
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("there are frame_1.vtu, frame_2.vtu"),
        "{error}"
    );
    let empty = folder_with(&[]);
    let error = matches(&empty.path().join("{}.ply"))
        .unwrap_err()
        .to_string();
    assert!(error.contains("the folder is empty"), "{error}");
}

#[test]
fn other_notations_are_answered_with_ours() {
    for (given, suggestion) in [
        ("no/frame_*.vtk", "no/frame_{}.vtk"),
        ("frame_%04d.vtk", "frame_{}.vtk"),
        ("frame_%d.vtk", "frame_{}.vtk"),
        ("frame_####.vtk", "frame_{}.vtk"),
        ("frame_????.vtk", "frame_{}.vtk"),
        ("frame_$F4.bgeo", "frame_{}.bgeo"),
    ] {
        let error = expand(&[PathBuf::from(given)]).unwrap_err();
        assert!(
            matches!(&error, SequenceError::Notation { suggestion: found, .. } if found == suggestion),
            "{given}: {error}"
        );
    }
    let error = expand(&[PathBuf::from("100%.vtk")]).unwrap_err();
    assert!(matches!(error, SequenceError::NoMatch { .. }), "{error}");
    let error = expand(&[PathBuf::from("a{}b{}.vtk")]).unwrap_err();
    assert!(
        matches!(error, SequenceError::Placeholders { count: 2, .. }),
        "{error}"
    );
}

#[test]
fn explicit_lists_are_sorted_and_numbered() {
    let folder = folder_with(&["f10.ply", "f9.ply", "a.ply", "b1.ply", "c1.ply"]);
    let list = |names: &[&str]| {
        let paths: Vec<_> = names.iter().map(|name| folder.path().join(name)).collect();
        let frames = expand(&paths).unwrap();
        frames
            .iter()
            .map(|frame| {
                let name = frame
                    .path
                    .file_name()
                    .unwrap()
                    .to_string_lossy()
                    .into_owned();
                (name, frame.number, frame.text.clone())
            })
            .collect::<Vec<_>>()
    };
    let entry = |name: &str, number, text: &str| (name.to_owned(), number, text.to_owned());
    assert_eq!(
        list(&["f10.ply", "f9.ply"]),
        [entry("f9.ply", 9, "9"), entry("f10.ply", 10, "10")]
    );
    assert_eq!(
        list(&["c1.ply", "b1.ply"]),
        [entry("b1.ply", 1, "1"), entry("c1.ply", 2, "2")]
    );
    assert_eq!(list(&["a.ply"]), [entry("a.ply", 1, "1")]);
}

#[test]
fn natural_order_is_a_total_order() {
    let mut names = [
        "f10", "f9", "f010", "F1", "f", "f1a", "f1", "f01b", "2", "10", "é3", "é20",
    ]
    .map(PathBuf::from);
    names.sort_by(|a, b| natural_order(a, b));
    let sorted: Vec<_> = names.iter().map(|name| name.to_str().unwrap()).collect();
    assert_eq!(
        sorted,
        [
            "2", "10", "F1", "f", "f1", "f1a", "f01b", "f9", "f010", "f10", "é3", "é20"
        ]
    );
}

#[test]
fn selections_say_which_frames() {
    let selection: FrameSelection = "1-9x4, 20,30-31".parse().unwrap();
    let chosen: Vec<u64> = (0..40)
        .filter(|&number| selection.contains(number))
        .collect();
    assert_eq!(chosen, [1, 5, 9, 20, 30, 31]);
    assert_eq!(selection.to_string(), "1-9x4,20,30-31");
    assert_eq!(selection.last(), 31);
    assert_eq!("1-10x4".parse::<FrameSelection>().unwrap().last(), 9);
    let whole: FrameSelection = "0-18446744073709551615".parse().unwrap();
    assert!(whole.contains(u64::MAX));
    for wrong in [
        "",
        "a",
        "1-",
        "-5",
        "5-1",
        "1-9x0",
        "1-9x",
        "5x2",
        "1,,2",
        "1..5",
        "+3",
        "1-2-3",
        "99999999999999999999",
    ] {
        let error = wrong.parse::<FrameSelection>().unwrap_err().to_string();
        assert!(error.contains("1-100x2"), "{wrong}: {error}");
    }
}

#[test]
fn a_selection_of_nothing_is_an_error() {
    let frame = |number: u64| FrameFile {
        path: PathBuf::new(),
        number,
        text: number.to_string(),
    };
    let frames = vec![frame(3), frame(7)];
    let selection: FrameSelection = "7-9".parse().unwrap();
    assert_eq!(selection.select(frames.clone()).unwrap(), [frame(7)]);
    let selection: FrameSelection = "8-9".parse().unwrap();
    let error = selection.select(frames).unwrap_err().to_string();
    assert_eq!(error, "frames 8-9 match none of the 2 there are, 3 to 7");
}
