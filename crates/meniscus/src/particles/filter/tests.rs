use super::Filter;
use crate::particles::{Column, Particles};
use glam::DVec3;
use proptest::prelude::*;

fn particles() -> Particles {
    let mut particles = Particles::from_positions(vec![
        DVec3::new(0.0, 1.0, 2.0),
        DVec3::new(3.0, -4.0, 0.0),
        DVec3::new(1.0, 1.0, f64::NAN),
    ]);
    particles.columns = vec![
        Column::new("id", 1, vec![7_u32, 8, 9]),
        Column::new(
            "velocity",
            3,
            vec![3.0_f32, 4.0, 0.0, 0.0, 0.0, 1.0, -1.0, 0.0, 0.0],
        ),
        Column::new("my density", 1, vec![1000.0_f64, f64::NAN, 990.0]),
        Column::new("ax", 1, vec![1.0_f64, 2.0, 3.0]),
        Column::new("ay", 1, vec![0.0_f64, 2.0, 4.0]),
        Column::new("az", 1, vec![0.0_f64, 1.0, 0.0]),
    ];
    particles
}

fn kept(text: &str) -> Vec<u8> {
    let keep = Filter::parse(text).unwrap().keep(&particles()).unwrap();
    keep.into_iter().map(u8::from).collect()
}

#[test]
fn expressions_mean_what_they_say() {
    for (text, expected) in [
        ("x > 0", [0, 1, 1]),
        ("x>=1&&x<3", [0, 0, 1]),
        ("y > 0 || id == 8", [1, 1, 1]),
        ("!(y > 0) and not x < 0", [0, 1, 0]),
        ("|velocity| > 0.5 && |velocity| < 5", [0, 1, 1]),
        ("|velocity.x| == 1", [0, 0, 1]),
        ("velocity[1] == 4", [1, 0, 0]),
        ("velocity.0 == -1", [0, 0, 1]),
        ("velocity.magnitude == 5", [1, 0, 0]),
        ("|acceleration| == 3 || |a| == 5", [0, 1, 1]),
        ("ax + ay * 2 == 6", [0, 1, 0]),
        ("-ax^2 == -4", [0, 1, 0]),
        ("2^-1 == 0.5 && 2^3^2 == 512", [1, 1, 1]),
        ("7 % 4 == 3 && 1e1 == 10 && .5 < 1.", [1, 1, 1]),
        ("||x - 2| - 1| < 0.5", [0, 1, 1]),
        ("|x - |y|| == 1 || x == 1", [1, 1, 1]),
        ("min(x, y, z) < 0", [0, 1, 0]),
        ("max(abs(y), 2) == 4", [0, 1, 0]),
        (
            "sqrt(ax * ax) == ax && floor(2.5) == 2 && ceil(2.5) == 3",
            [1, 1, 1],
        ),
        ("exp(log(ax)) < 1.5", [1, 0, 0]),
        ("`my density` > 0", [1, 0, 1]),
        ("\"my density\" >= 995", [1, 0, 0]),
        ("z == z", [1, 1, 0]),
        ("z != 5", [1, 1, 0]),
        ("!(z > 5)", [1, 1, 1]),
    ] {
        assert_eq!(kept(text), expected, "{text}");
    }
}

/// Expression, the text under the caret, and a word of the message.
#[test]
fn errors_name_the_place_and_the_way_out() {
    for (text, under, word) in [
        ("", "", "ends"),
        ("x >", "", "ends"),
        ("x = 3", "=", "=="),
        ("x & y", "&", "&&"),
        ("0 < x < 1", "<", "chain"),
        ("x > 3 )", ")", "operator"),
        ("(x > 3", "", "`)`"),
        ("x > 2y", "2y", "not a number"),
        ("x > 1.2.3", "1.2.3", "not a number"),
        ("|x > 3", ">", "`|`"),
        ("x > #", "#", "`#`"),
        ("x > é", "é", "no column `é`"),
        ("`my densi", "`my densi", "does not end"),
        ("sin(x) > 0", "sin", "no function `sin`"),
        ("max(x) > 0", "max", "two arguments"),
        ("sqrt(x, y) > 0", ",", "`)`"),
        ("velocty.x > 1", "velocty.x", "did you mean `velocity`"),
        ("velocity.w > 1", "velocity.w", "3 components"),
        ("velocity > 1", "velocity", "|velocity|"),
        ("x", "x", "condition"),
        ("x && y > 1", "x", "expected a condition"),
        ("(x > 1) + 1 > 0", "x > 1", "expected a number"),
        ("!x", "x", "expected a condition"),
    ] {
        let error = Filter::parse(text)
            .and_then(|filter| filter.keep(&particles()))
            .expect_err(text);
        assert_eq!(&text[error.span.clone()], under, "{text}: {error}");
        assert!(error.to_string().contains(word), "{text}: {error}");
    }
}

#[test]
fn nesting_is_bounded() {
    for text in [
        "(".repeat(100_000),
        "!".repeat(100_000),
        "not ".repeat(100_000),
        "-".repeat(100_000),
        "|".repeat(100_000),
        "2^".repeat(100_000),
        "min(1,".repeat(100_000),
    ] {
        assert!(Filter::parse(&text).is_err());
    }
    // What is long but flat is fine.
    let long = format!("x{} > 0", " + 1".repeat(20_000));
    assert_eq!(kept(&long), [1, 1, 1]);
}

#[test]
fn apply_removes_rows_and_counts_them() {
    let mut particles = particles();
    let removed = Filter::parse("x > 0 && z == z")
        .unwrap()
        .apply(&mut particles);
    assert_eq!(removed, Ok(2));
    assert_eq!(particles.rows, [1]);
    assert_eq!(particles.column("id").unwrap().get(0, 0), 8.0);
}

#[test]
fn blocks_of_rows_agree_with_single_rows() {
    let positions: Vec<DVec3> = (0..3000)
        .map(|i| DVec3::new(f64::from(i), f64::from(i % 7), -1.0))
        .collect();
    let particles = Particles::from_positions(positions);
    let keep = Filter::parse("x % 3 == 1 && |y - 3| < 2")
        .unwrap()
        .keep(&particles)
        .unwrap();
    for (i, keep) in keep.into_iter().enumerate() {
        let expected = i % 3 == 1 && (i as f64 % 7.0 - 3.0).abs() < 2.0;
        assert_eq!(keep, expected, "row {i}");
    }
}

proptest! {
    #[test]
    fn no_text_panics(text in "[xyz0-9.()|&!<>=+*/^%`, a-e\\-\\[\\]éµ]{0,40}") {
        if let Err(error) = Filter::parse(&text).and_then(|filter| filter.keep(&particles())) {
            prop_assert!(text.get(error.span.clone()).is_some(), "{:?}", error);
        }
    }
}
