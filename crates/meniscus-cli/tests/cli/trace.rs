//! `meniscus trace`: rays in, hits out.

use crate::run::Folder;
use npyz::WriterBuilder;
use npyz::npz::NpzArchive;

/// Two unit balls (a lone particle of weight 1 and radius 1) at x = 0 and x = 10, and one that the
/// filter removes in row 1.
fn folder_with_balls() -> Folder {
    let folder = Folder::new();
    folder.write(
        "balls.csv",
        "x,y,z,heat,vx,vy,vz\n0,0,0,2.5,1,2,3\n50,50,50,9,0,0,0\n10,0,0,-1,4,5,6\n",
    );
    folder
}

const SURFACE: &str = "--weights unit --kernel quartic -t 0.2 -r 1 --filter 'x < 20'";

pub(crate) fn write_rays<T: npyz::AutoSerialize + Copy>(
    folder: &Folder,
    width: u64,
    numbers: &[T],
) {
    let file = std::fs::File::create(folder.path("rays.npy")).unwrap();
    let mut writer = npyz::WriteOptions::new()
        .default_dtype()
        .shape(&[numbers.len() as u64 / width, width])
        .writer(std::io::BufWriter::new(file))
        .begin_nd()
        .unwrap();
    writer.extend(numbers.iter().copied()).unwrap();
    writer.finish().unwrap();
}

const INF: f64 = f64::INFINITY;
const NAN: f64 = f64::NAN;

/// Origin, direction, t_min, t_max.
const RAYS: [[f64; 8]; 7] = [
    [-5.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, INF],
    [5.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 100.0],
    [0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 9.0],
    [-5.0, 3.0, 0.0, 1.0, 0.0, 0.0, 0.0, INF],
    [-5.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 3.9],
    [-5.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, INF],
    [NAN, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, INF],
];

fn array<T: npyz::Deserialize>(folder: &Folder, name: &str) -> (Vec<u64>, String, Vec<T>) {
    let mut archive = NpzArchive::open(folder.path("hits.npz")).unwrap();
    let file = archive
        .by_name(name)
        .unwrap()
        .unwrap_or_else(|| panic!("no array {name}"));
    let shape = file.shape().to_vec();
    let kind = file.dtype().descr();
    (shape, kind, file.into_vec().unwrap())
}

#[test]
fn hits_have_the_arrays_of_the_contract() {
    let folder = folder_with_balls();
    write_rays(&folder, 8, RAYS.as_flattened());
    folder.done(&format!(
        "trace balls.csv --rays rays.npy -o hits.npz {SURFACE} -a heat -a v"
    ));
    let (shape, kind, t) = array::<f64>(&folder, "t");
    assert_eq!((&shape[..], &kind[..]), (&[7][..], "'<f8'"));
    // 1e-4 of the spacing, which is 10, would do.
    for (found, expected) in t.iter().zip([4.0, 2.0, 1.0, INF, INF, INF, INF]) {
        assert!(
            *found == expected || (found - expected).abs() < 1e-4,
            "{t:?}"
        );
    }
    let (shape, kind, normal) = array::<f32>(&folder, "normal");
    assert_eq!((&shape[..], &kind[..]), (&[7, 3][..], "'<f4'"));
    let expected = [
        [-1.0, 0.0, 0.0],
        [-1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0; 3],
    ];
    for (found, expected) in normal.chunks(3).zip(expected) {
        let distance = found
            .iter()
            .zip(expected)
            .map(|(a, b)| (a - b).abs())
            .sum::<f32>();
        assert!(distance < 1e-5, "{normal:?}");
    }
    let (_, kind, id) = array::<i64>(&folder, "id");
    assert_eq!(kind, "'<i8'");
    // Rows of the file, the filtered one counted.
    assert_eq!(id, [0, 2, 0, -1, -1, -1, -1]);
    let (_, kind, surface) = array::<i32>(&folder, "surface");
    assert_eq!(kind, "'<i4'");
    assert_eq!(surface, [0, 0, 0, -1, -1, -1, -1]);
    let (_, kind, inside) = array::<bool>(&folder, "inside");
    assert_eq!(kind, "'|b1'");
    assert_eq!(inside, [false, false, true, false, false, false, false]);
    let (shape, _, heat) = array::<f32>(&folder, "heat");
    assert_eq!(shape, [7]);
    assert_eq!(heat, [2.5, -1.0, 2.5, 0.0, 0.0, 0.0, 0.0]);
    let (shape, _, velocity) = array::<f32>(&folder, "v");
    assert_eq!(shape, [7, 3]);
    assert_eq!(&velocity[3..6], &[4.0, 5.0, 6.0]);
}

#[test]
fn any_and_all_answer_their_questions() {
    let folder = folder_with_balls();
    write_rays(&folder, 8, RAYS.as_flattened());
    let words = format!("trace balls.csv --rays rays.npy -o hits.npz {SURFACE}");
    folder.done(&format!("{words} --any"));
    let (shape, kind, occluded) = array::<bool>(&folder, "occluded");
    assert_eq!((&shape[..], &kind[..]), (&[7][..], "'|b1'"));
    assert_eq!(occluded, [true, true, true, false, false, false, false]);

    folder.done(&format!("{words} --all"));
    let (_, kind, ray) = array::<i64>(&folder, "ray");
    assert_eq!(kind, "'<i8'");
    assert_eq!(ray, [0, 0, 0, 0, 1, 1, 2]);
    let (_, _, t) = array::<f64>(&folder, "t");
    for (found, expected) in t.iter().zip([4.0, 6.0, 14.0, 16.0, 2.0, 3.0, 1.0]) {
        assert!((found - expected).abs() < 1e-4, "{t:?}");
    }
    let (_, kind, entering) = array::<bool>(&folder, "entering");
    assert_eq!(kind, "'|b1'");
    assert_eq!(entering, [true, false, true, false, true, false, false]);
    folder.fails(&format!("{words} --any --all"), 2, &["--all"]);
}

#[test]
fn rays_may_be_f32_and_carry_a_time() {
    let folder = folder_with_balls();
    let with_time: Vec<f32> = RAYS
        .iter()
        .flat_map(|ray| ray.iter().map(|&x| x as f32).chain([0.01]))
        .collect();
    write_rays(&folder, 9, &with_time);
    folder.done(&format!(
        "trace balls.csv --rays rays.npy -o hits.npz {SURFACE} --engine sweep"
    ));
    let (_, _, id) = array::<i64>(&folder, "id");
    assert_eq!(id, [0, 2, 0, -1, -1, -1, -1]);
}

#[test]
fn wrong_rays_are_refused() {
    let folder = folder_with_balls();
    let words = format!("trace balls.csv --rays rays.npy -o hits.npz {SURFACE}");
    folder.fails(&words, 1, &["rays.npy"]);
    folder.write("rays.npy", "no array");
    folder.fails(&words, 1, &["rays.npy", "NPY"]);
    write_rays(&folder, 7, &[0.0f64; 14]);
    folder.fails(&words, 2, &["(n, 8)", "[2, 7]"]);
    write_rays(&folder, 8, &[0i32; 16]);
    folder.fails(&words, 2, &["f32 or f64"]);
    write_rays(&folder, 8, RAYS.as_flattened());
    let whole = folder.read("rays.npy");
    folder.write("rays.npy", &whole[..whole.len() - 9]);
    folder.fails(&words, 1, &["rays.npy"]);
    folder.fails("trace balls.csv --rays rays.npy -o hits.csv", 2, &[".npz"]);
}
