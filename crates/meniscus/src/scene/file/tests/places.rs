//! Text that is not a scene: syntax, unknown keys, wrong types.

use super::*;

#[test]
fn unknown_keys_are_pointed_at_with_the_nearest_known_one() {
    let cases = [
        (
            "[[surface]]\nfile = \"a\"\ntreshold = 0.5",
            "treshold",
            "threshold",
            (3, 1),
        ),
        (
            "[[surface]]\n  kernal = \"quartic\"",
            "kernal",
            "kernel",
            (2, 3),
        ),
        ("[film]\nwidth = 3\nhight = 4", "hight", "height", (3, 1)),
        ("[cammera]\nfov = 3", "cammera", "camera", (1, 2)),
        ("[[surfaces]]\nfile = \"a\"", "surfaces", "surface", (1, 3)),
        (
            "[material.red]\ncolour = \"#f00\"",
            "colour",
            "color",
            (2, 1),
        ),
        ("[[light]]\ndir = [1, 2, 3]", "dir", "direction", (2, 1)),
        (
            "{\"film\": {\n  \"widht\": 3}}",
            "\"widht\"",
            "width",
            (2, 3),
        ),
        (
            "{\"film\": {\"w\\u0069dht\": 3}}",
            "\"w\\u0069dht\"",
            "width",
            (1, 11),
        ),
        (
            "{\"surface\": [{\"file\": \"a\", \"x\": [1, {\"q\": \"\"}], \"tresh\": 1}]}",
            "\"x\"",
            "keys here are",
            (1, 28),
        ),
    ];
    for (text, pointed_at, help, place) in cases {
        let (error, pointed) = error_of(text);
        assert_eq!(error.kind, SceneErrorKind::Schema, "{error}");
        assert_eq!(pointed, pointed_at, "{error}");
        assert!(error.message.starts_with("unknown key `"), "{error}");
        let given = error.help.clone().unwrap();
        assert!(given.contains(help), "{error}");
        assert_eq!(
            error.excerpt.as_ref().unwrap().line_column(),
            place,
            "{error}"
        );
    }
    let (error, _) = error_of("[[surface]]\nfile = \"a\"\ntreshold = 0.5");
    let start = "scene, line 3, column 1: unknown key `treshold` in `surface` (did you mean \
                 `threshold`? the keys here are: name, type, file";
    assert!(error.to_string().starts_with(start), "{error}");
}

#[test]
fn wrong_types_and_names_are_pointed_at() {
    let cases = [
        (
            "[camera]\nfov = \"wide\"",
            "\"wide\"",
            "`fov`: expected a number, found the text \"wide\"",
        ),
        (
            "[camera]\neye = [1, 2]",
            "[1, 2]",
            "`eye`: expected 3 numbers, found 2",
        ),
        (
            "[camera]\neye = [1, 2, 3, 4]",
            "[1, 2, 3, 4]",
            "expected 3 elements, found 4",
        ),
        (
            "[camera]\neye = [1, \"a\", 3]",
            "\"a\"",
            "`eye`: expected a number, found the text \"a\"",
        ),
        (
            "[camera]\nup = \"w\"",
            "\"w\"",
            "`w` is not a direction; use x, y, z, -x",
        ),
        ("[camera]\nup = 3", "3", "`up`: expected a direction"),
        (
            "[film]\nwidth = -3",
            "-3",
            "`width`: expected a whole number, 0 or more, found -3",
        ),
        (
            "[film]\nspp = 1.5",
            "1.5",
            "`spp`: expected a whole number, 0 or more, found 1.5",
        ),
        (
            "[film]\nbackground = \"blue\"",
            "\"blue\"",
            "use sky, transparent or #rrggbb",
        ),
        ("[film]\nbackground = [1, 2]", "[1, 2]", "a colour"),
        (
            "[[surface]]\nkernel = \"quartik\"",
            "\"quartik\"",
            "`kernel`: there is no `quartik`",
        ),
        (
            "[[surface]]\nkernel = 4",
            "4",
            "expected one of the names quartic, sextic, octic or wyvill",
        ),
        (
            "[[surface]]\ncolor_map = \"jet\"",
            "\"jet\"",
            "`color_map`: there is no `jet`",
        ),
        (
            "[[surface]]\ncolor_range = [1]",
            "[1]",
            "`color_range`: expected 2 numbers, found 1",
        ),
        (
            "[[surface]]\nfile = 2024-01-01",
            "2024-01-01",
            "found the date 2024-01-01",
        ),
        (
            "[[surface]]\nattributes = \"v\"",
            "\"v\"",
            "`attributes`: expected a list",
        ),
        ("surface = 3", "3", "`surface`: expected a list, found 3"),
        (
            "[[instance]]\nmatrix = [1]\nsurface = \"a\"",
            "[1]",
            "a matrix has 16 numbers",
        ),
        (
            "[[instance]]\nsurface = \"a\"\nmatrix = [[1,0,0,0],[0,1,0,0],[0,0,1,0],[1,2,3,1]]",
            "[[1,0,0,0],[0,1,0,0],[0,0,1,0],[1,2,3,1]]",
            "the last row of a matrix must be 0 0 0 1",
        ),
        (
            "{\"film\": {\"width\": true}}",
            "true",
            "`width`: expected a whole number",
        ),
        ("{\"film\": {\"width\": null}}", "null", "found nothing"),
        (
            "{\"camera\": {\"eye\": [1, {}, 3]}}",
            "{}",
            "`eye`: expected a number, found a table",
        ),
        (
            "{\"integrator\": {\"type\": \"shadedd\"}}",
            "\"shadedd\"",
            "there is no `shadedd`",
        ),
    ];
    for (text, pointed_at, message) in cases {
        let (error, pointed) = error_of(text);
        assert_eq!(error.kind, SceneErrorKind::Schema, "{error}");
        assert!(
            error.message.contains(message),
            "{text}\ngave {}",
            error.message
        );
        assert_eq!(pointed, pointed_at, "{text}\ngave {error}");
    }
    let (error, _) = error_of("[[surface]]\nkernel = \"quartik\"");
    assert_eq!(
        error.help.as_deref(),
        Some("did you mean `quartic`? it can be: quartic, sextic, octic or wyvill")
    );
    assert_eq!(error.key, "surface.0.kernel");
    for (text, brackets) in [
        ("[surface]\nfile = \"a\"", "[[…]]"),
        ("[[camera]]\nfov = 3", "[…]"),
    ] {
        let (error, _) = error_of(text);
        assert!(
            error
                .help
                .as_ref()
                .is_some_and(|help| help.contains(brackets)),
            "{error}"
        );
    }
}

#[test]
fn syntax_errors_are_pointed_at() {
    let cases = [
        ("[camera\nfov = 3", (1, 8), "TOML"),
        ("[camera]\nfov = ", (2, 7), "TOML"),
        ("[camera]\nfov = 3\nfov = 4", (3, 1), "TOML"),
        ("{\"camera\": {\"fov\" 3}}", (1, 19), "JSON"),
        ("{\n  \"camera\": {},\n}", (3, 1), "JSON"),
        ("{\"film\": {\"width\": 3, \"width\": 4}}", (1, 23), "JSON"),
        ("{} x", (1, 4), "JSON"),
    ];
    for (text, place, format) in cases {
        let (error, _) = error_of(text);
        assert_eq!(error.kind, SceneErrorKind::Syntax, "{error}");
        assert!(
            error.message.starts_with(&format!("not valid {format}: ")),
            "{error}"
        );
        assert_eq!(
            error.excerpt.as_ref().unwrap().line_column(),
            place,
            "{error}"
        );
    }
    for deep in [
        "[".repeat(100_000),
        format!("{{\"a\":{}", "[".repeat(100_000)),
    ] {
        assert_eq!(
            error_of(&format!("a = {deep}")).0.kind,
            SceneErrorKind::Syntax
        );
        assert_eq!(error_of(&deep).0.kind, SceneErrorKind::Syntax);
    }
    let dotted = format!("{}a = 1", "a.".repeat(100_000));
    assert_eq!(error_of(&dotted).0.kind, SceneErrorKind::Syntax);
}
