//! Scenes that are well-formed and make no sense.

use super::*;

#[test]
fn senseless_values_are_pointed_at() {
    let cases = [
        (
            "[camera]\nfov = 180",
            "180",
            "`fov` is the vertical angle in degrees",
        ),
        ("[camera]\nfov = nan", "nan", "not NaN"),
        (
            "[camera]\nup = [0, 0, 0]",
            "[0, 0, 0]",
            "`up` must be a direction",
        ),
        (
            "[camera]\neye = [0, inf, 0]",
            "[0, inf, 0]",
            "`eye` must be three finite numbers",
        ),
        (
            "[camera]\neye = [1, 2, 3]\ntarget = [1, 2, 3]",
            "[1, 2, 3]",
            "are the same point",
        ),
        (
            "[camera]\neye = [0, 5, 0]\ntarget = [0, 0, 0]\nup = \"y\"",
            "\"y\"",
            "`up` points along",
        ),
        (
            "[camera]\neye = [1, 2, 3]\n[[camera.key]]\ntime = 0\neye = [1, 0, 0]\ntarget = [0, 0, 0]",
            "[1, 2, 3]",
            "no effect beside the keys",
        ),
        (
            "[[camera.key]]\ntime = 2\neye = [1, 0, 0]\ntarget = [0, 0, 0]\n[[camera.key]]\ntime = 2.0\neye = [1, 0, 0]\ntarget = [0, 0, 0]",
            "2.0",
            "in the order of their times",
        ),
        (
            "[[camera.key]]\ntime = 0\neye = [1, 0, 0]\ntarget = [1, 0, 0]",
            "[1, 0, 0]",
            "are the same point",
        ),
        (
            "[[camera.key]]\ntime = 0\neye = [0, 0, 0]\ntarget = [1, 0, 0]\n[[camera.key]]\ntime = 1\neye = [0, 0, 0]\ntarget = [-1, 0, 0]",
            "[[camera.key]]",
            "at 0.500 s",
        ),
        (
            "[[surface]]\nname = \"a\"\nfile = \"a\"\n[[instance]]\nsurface = \"a\"\n[[instance.key]]\ntime = nan\nmatrix = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]",
            "nan",
            "must be a number of seconds",
        ),
        ("[motion]\ntime = inf", "inf", "must be a number of seconds"),
        (
            "[film]\nwidth = 0",
            "0",
            "`width` must be 1 to 65536 pixels, not 0",
        ),
        (
            "[film]\nheight = 65537",
            "65537",
            "`height` must be 1 to 65536 pixels",
        ),
        (
            "[film]\nwidth = 65536\nheight = 65536",
            "65536",
            "is more than 1073741824 pixels",
        ),
        ("[film]\nspp = 0", "0", "`spp` must be"),
        ("[film]\nexposure = inf", "inf", "`exposure` is in stops"),
        ("[film]\nbackground = [-1, 0, 0]", "[-1, 0, 0]", "0 or more"),
        ("[integrator]\ndepth = 0", "0", "`depth` must be at least 1"),
        (
            "[[surface]]\nfile = \"\"",
            "\"\"",
            "the key `file` is missing",
        ),
        (
            "[[surface]]\nfile = \"a\"\nradius = 0",
            "0",
            "`radius` must be a positive number",
        ),
        (
            "[[surface]]\nfile = \"a\"\nthreshold = nan",
            "nan",
            "`threshold` must be a positive",
        ),
        (
            "[[surface]]\nfile = \"a\"\nradius = 1\nsupport = 2",
            "1",
            "no effect beside `support`",
        ),
        (
            "[[surface]]\nfile = \"a\"\ncolor_range = [2, 1]",
            "[2, 1]",
            "the smaller first",
        ),
        (
            "[[surface]]\nfile = \"a\"\nfilter = \"\"",
            "\"\"",
            "`filter` is empty",
        ),
        (
            "[[surface]]\nfile = \"a\"\nmaterial = \"gold\"",
            "\"gold\"",
            "no material `gold`",
        ),
        (
            "[[surface]]\nname = \"a\"\nfile = \"a\"\n[[surface]]\nname = \"a\"\nfile = \"b\"",
            "\"a\"",
            "surface 0 is called `a` already",
        ),
        (
            "[[instance]]\nsurface = \"crown\"",
            "\"crown\"",
            "there is no surface `crown`",
        ),
        (
            "[[plane]]\nnormal = [0, 0, 0]",
            "[0, 0, 0]",
            "`normal` must be a direction",
        ),
        (
            "[[plane]]\npoint = [0, nan, 0]",
            "[0, nan, 0]",
            "three finite numbers",
        ),
        (
            "[ground]\nheight = inf",
            "inf",
            "`height` must be a finite number",
        ),
        (
            "[[light]]\ndirection = [0, 0, 0]",
            "[0, 0, 0]",
            "`direction` must be a direction",
        ),
        (
            "[[light]]\ntype = \"sky\"\ndirection = [0, 1, 0]",
            "[0, 1, 0]",
            "takes no `direction`",
        ),
        (
            "[[light]]\ntype = \"sky\"\nintensity = -1",
            "-1",
            "`intensity` must be 0 or more",
        ),
        (
            "[material.m]\ncolor = [2, 0, 0]",
            "[2, 0, 0]",
            "components from 0 to 1",
        ),
        (
            "[material.m]\nroughness = 2",
            "2",
            "`roughness` must be from 0 to 1",
        ),
        (
            "[material.m]\ntype = \"diffuse\"\nspecular = 1",
            "1",
            "takes no `specular`",
        ),
        (
            "[integrator]\ndistance = 0",
            "0",
            "`distance` must be a positive number",
        ),
        (
            "[integrator]\nclamp = -1",
            "-1",
            "`clamp` must be a positive number",
        ),
        ("[integrator]\nsamples = 0", "0", "`samples` must be 1 to"),
        ("[engine]\ntime_slabs = 9", "9", "`time_slabs` must be 0"),
        ("[film]\nnoise = 0", "0", "`noise` is relative"),
        ("[film]\nnoise = 2", "2", "`noise` is relative"),
        ("[film]\nwhite_balance = 100", "100", "1667 to 25000 kelvin"),
        (
            "[film]\nwhite_balance = [1, 0, 1]",
            "[1, 0, 1]",
            "components above 0",
        ),
        (
            "[[surface]]\nfile = \"a\"\nroughness_range = [2, 1]",
            "[2, 1]",
            "the smaller first",
        ),
        (
            "[[light]]\ndirection = [0, 1, 0]\nangle = 180",
            "180",
            "`angle` is in degrees",
        ),
        (
            "[[light]]\ntype = \"sphere\"\nposition = [0, 0, 0]\nradius = 0",
            "0",
            "`radius` must be a positive number",
        ),
        (
            "[[light]]\ntype = \"point\"\nposition = [0, nan, 0]",
            "[0, nan, 0]",
            "three finite numbers",
        ),
        (
            "[[light]]\ntype = \"rectangle\"\nposition = [0, 0, 0]\nedges = [[1, 0, 0], [2, 0, 0]]",
            "[[1, 0, 0], [2, 0, 0]]",
            "span no area",
        ),
        (
            "[[light]]\ntype = \"sky\"\nradius = 1",
            "1",
            "takes no `radius`",
        ),
        (
            "[material.m]\ntype = \"glass\"\nior = 0",
            "0",
            "`ior` is the index of refraction",
        ),
        (
            "[material.m]\ntype = \"water\"\nabsorption = [0, 1, 1]",
            "[0, 1, 1]",
            "above 0 and up to 1",
        ),
        (
            "[material.m]\ntype = \"water\"\nabsorption_depth = 0",
            "0",
            "`absorption_depth` must be a positive number",
        ),
        (
            "[material.m]\ntype = \"glass\"\nthin = true\npriority = 3",
            "3",
            "a material of type `glass (thin)` takes no `priority`",
        ),
        (
            "[material.m]\ntype = \"metal\"\nthin = true",
            "true",
            "takes no `thin`",
        ),
        (
            "[material.m]\ntype = \"metal\"\nior = 1.5",
            "1.5",
            "takes no `ior`",
        ),
        (
            "[material.m]\ntype = \"foam\"\ntranslucency = 1.5",
            "1.5",
            "`translucency` must be from 0 to 1",
        ),
        ("{\"film\": {\"spp\": 0}}", "0", "`spp` must be"),
        ("{\"camera\": {\"fov\": 1e999}}", "1e999", "not inf"),
    ];
    for (text, pointed_at, message) in cases {
        let (error, pointed) = error_of(text);
        assert_eq!(error.kind, SceneErrorKind::Invalid, "{error}");
        assert!(
            error.message.contains(message),
            "{text}\ngave {}",
            error.message
        );
        assert_eq!(pointed, pointed_at, "{text}\ngave {error}");
    }
    // What is missing is pointed at where it should stand.
    let (error, pointed) = error_of("[film]\nspp = 4\n[[light]]\ntype = \"sun\"\n");
    assert!(
        error.message.contains("the sun has no `direction`"),
        "{error}"
    );
    assert_eq!(pointed, "[[light]]");
    for (kind, rest, what) in [
        ("point", "", "no `position`"),
        ("sphere", "position = [0, 0, 0]", "no `radius`"),
        ("rectangle", "position = [0, 0, 0]", "no `edges`"),
        ("environment", "", "no `file`"),
    ] {
        let (error, _) = error_of(&format!("[[light]]\ntype = \"{kind}\"\n{rest}"));
        assert!(error.message.contains(what), "{error}");
    }
    let (error, _) = error_of("");
    assert_eq!(error.message, "the scene shows nothing");
}

#[test]
fn flat_and_mirrored_matrices_are_told_apart() {
    let with = |matrix: &str| {
        let text = format!(
            "[[surface]]\nname = \"a\"\nfile = \"a\"\n[[instance]]\nsurface = \"a\"\nmatrix = {matrix}"
        );
        parse(&text, "scene")
    };
    for flat in [
        "[[1,0,0,0],[0,1,0,0],[0,0,0,0]]",
        "[[1,2,3,0],[2,4,6,0],[0,0,1,0]]",
        "[1,0,0,0, 0,1,0,0, 1,1,0,0]",
        "[nan,0,0,0, 0,1,0,0, 0,0,1,0]",
    ] {
        assert_eq!(
            with(flat).unwrap_err().kind,
            SceneErrorKind::Invalid,
            "{flat}"
        );
    }
    for good in [
        "[[-1,0,0,0],[0,1,0,0],[0,0,1,0]]",
        "[1e-6,0,0,0, 0,1e-6,0,0, 0,0,1e-6,0]",
        "[1,0,0,1e6, 0,1e3,0,0, 0,0,1e-3,0, 0,0,0,1]",
    ] {
        assert!(with(good).is_ok(), "{good}: {}", with(good).unwrap_err());
    }
}

#[test]
fn what_is_announced_but_not_there_yet_says_so() {
    let cases = [
        (
            "[[surface]]\ntype = \"skeleton\"",
            "\"skeleton\"",
            "surface type `skeleton`",
        ),
        (
            "[[surface]]\ntype = \"points\"",
            "\"points\"",
            "surface type `points`",
        ),
    ];
    for (text, pointed_at, what) in cases {
        let (error, pointed) = error_of(text);
        assert_eq!(error.kind, SceneErrorKind::Unsupported, "{error}");
        assert_eq!(error.message, format!("{what} is not supported yet"));
        assert!(pointed.contains(pointed_at), "{text}: {pointed}");
        assert!(error.help.is_some());
    }
}
