//! One ellipsoid from every form of columns.

use crate::run::Folder;
use crate::trace::{array, write_rays};

/// A turn by 40° about (1, 2, 2)/3 and radii 0.9, 0.5, 0.3.
struct Shape {
    turn: [[f64; 3]; 3],
    quaternion: [f64; 4],
    radii: [f64; 3],
}

fn shape() -> Shape {
    let axis = [1.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0];
    let angle = 40.0_f64.to_radians();
    let (sine, cosine) = angle.sin_cos();
    let [x, y, z] = axis;
    let cross = [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]];
    let row = |i: usize| {
        [0, 1, 2].map(|j| {
            let diagonal = if i == j { cosine } else { 0.0 };
            diagonal + (1.0 - cosine) * axis[i] * axis[j] + sine * cross[i][j]
        })
    };
    let half = (0.5 * angle).sin();
    Shape {
        turn: [0, 1, 2].map(row),
        quaternion: [x * half, y * half, z * half, (0.5 * angle).cos()],
        radii: [0.9, 0.5, 0.3],
    }
}

/// A file of two such particles.
fn file(names: &str, numbers: &[f64]) -> String {
    let numbers: Vec<String> = numbers.iter().map(f64::to_string).collect();
    let row = numbers.join(",");
    format!("x,y,z,{names}\n0,0,0,{row}\n0.7,0.2,0,{row}\n")
}

#[test]
fn all_forms_are_hit_at_the_same_places() {
    let folder = Folder::new();
    let Shape {
        turn,
        quaternion,
        radii,
    } = shape();
    let image = turn.map(|row| [0, 1, 2].map(|k| row[k] * radii[k]));
    // Column k of the turn is axis k.
    let axes: Vec<f64> = (0..9).map(|i| turn[i % 3][i / 3]).collect();
    // With T = 0.5 and the quartic kernel the surface of a lone particle is at q = 1 − √0.5.
    let q = 1.0 - 0.5_f64.sqrt();
    let tensor = |power: i32, scale: f64| {
        let at = |i: usize, j: usize| -> f64 {
            (0..3)
                .map(|k| turn[i][k] * turn[j][k] * radii[k].powi(power))
                .sum::<f64>()
                * scale
        };
        [at(0, 0), at(0, 1), at(0, 2), at(1, 1), at(1, 2), at(2, 2)]
    };
    let [xx, xy, xz, yy, yz, zz] = tensor(2, 1.5381722544550522_f64.powi(-2));
    let six = "metric_xx,metric_xy,metric_xz,metric_yy,metric_yz,metric_zz";
    let gradient = "F00,F01,F02,F10,F11,F12,F20,F21,F22";
    let with_radii = |numbers: &[f64]| [numbers, &radii[..]].concat();
    let [i, j, k, w] = quaternion;
    let forms = [
        ("metric", file(six, &tensor(-2, q)), ""),
        (
            "quaternion",
            file("qx,qy,qz,qw,radii0,radii1,radii2", &with_radii(&quaternion)),
            "",
        ),
        (
            "scalar-first",
            file("q0,q1,q2,q3,rx,ry,rz", &with_radii(&[w, i, j, k])),
            "--radii rx,ry,rz --orientation q1,q2,q3,q0",
        ),
        (
            "axes",
            file(
                "axes0,axes1,axes2,axes3,axes4,axes5,axes6,axes7,axes8,radii0,radii1,radii2",
                &with_radii(&axes),
            ),
            "",
        ),
        ("gradient", file(gradient, image.as_flattened()), "-r 1"),
        (
            "thermal",
            file("U11,U22,U33,U12,U13,U23", &[xx, yy, zz, xy, xz, yz]),
            "--anisotropy thermal",
        ),
    ];
    let rays = (0..40 * 30).map(|i| {
        let (x, y) = (f64::from(i % 40), f64::from(i / 40));
        [
            x / 16.0 - 0.9,
            y / 16.0 - 0.9,
            4.0,
            0.1,
            0.02,
            -1.0,
            0.0,
            f64::INFINITY,
        ]
    });
    let rays: Vec<f64> = rays.flatten().collect();
    write_rays(&folder, 8, &rays);
    let mut first: Option<Vec<f64>> = None;
    for (name, text, options) in forms {
        folder.write(&format!("{name}.csv"), text);
        folder.done(&format!(
            "trace {name}.csv --rays rays.npy -o hits.npz --weights unit --kernel quartic -t 0.5 {options}"
        ));
        let (_, _, hits) = array::<f64>(&folder, "t");
        assert!(
            hits.iter().filter(|t| t.is_finite()).count() > 300,
            "{name}"
        );
        let expected = first.get_or_insert_with(|| hits.clone());
        for (t, expected) in hits.iter().zip(expected) {
            let is_near = (t - *expected).abs() < 1e-4;
            assert!(is_near || t == expected, "{name}: {t} {expected}");
        }
    }
    folder.done("render gradient.csv -o round.exr --size 96x72 --spp 1 --anisotropy none -r 1");
    folder.fails(
        "render gradient.csv -o a.png -r 1 --radii F",
        2,
        &["--radii", "--radius"],
    );
    folder.fails(
        "render gradient.csv -o a.png --anisotropy thermal",
        2,
        &["anisou"],
    );
    folder.fails(
        "render gradient.csv -o a.png --probability 2",
        2,
        &["probability"],
    );
    folder.fails(
        "render gradient.csv -o a.png --anisotropy flat",
        2,
        &["estimate, thermal"],
    );
}

#[test]
fn shapes_that_are_none_are_named_and_left_out() {
    let folder = Folder::new();
    let names = "metric_xx,metric_xy,metric_xz,metric_yy,metric_yz,metric_zz";
    let rows = "0,0,0,4,0,0,4,0,4\n1,0,0,1,2,0,1,0,1\n2,0,0,nan,0,0,1,0,1\n3,0,0,0,0,0,0,0,0\n";
    folder.write("p.csv", format!("x,y,z,{names}\n{rows}"));
    let picture = "-o out.png --size 32x18 --spp 1";
    let ended = folder.done(&format!("render p.csv {picture}"));
    for part in [
        "p.csv",
        "dropped 3 particles",
        "not positive definite",
        "row 1",
    ] {
        assert!(ended.stderr.contains(part), "{}", ended.stderr);
    }
    folder.write("q.csv", format!("x,y,z,{names}\n1,0,0,1,2,0,1,0,1\n"));
    folder.fails(
        &format!("render q.csv {picture}"),
        1,
        &["q.csv", "no particle is left", "row 0"],
    );
    let crushed = "x,y,z,F00,F01,F02,F10,F11,F12,F20,F21,F22\n0,0,0,1,0,0,0,1,0,0,0,0\n";
    folder.write("f.csv", crushed);
    let ended = folder.done(&format!("render f.csv -r 1 {picture}"));
    for part in [
        "f.csv",
        "deformation gradient in column F",
        "lengthened",
        "row 0",
    ] {
        assert!(ended.stderr.contains(part), "{}", ended.stderr);
    }
}
