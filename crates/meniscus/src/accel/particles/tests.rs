use super::layout::Node;
use super::*;

use crate::accel::cells::layout::{LEAF, LeafHeader};
use crate::field::{Motion, Search};
use crate::kernel::Kernel;
use crate::primitive::Ellipsoid;
use glam::{DMat3, DVec3};

/// `count` balls in a cube, of one radius or spread over six orders of magnitude.
fn field(count: usize, spread: bool) -> BlobField {
    let mut state = 7_u64;
    let mut random = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f32 / (1 << 24) as f32
    };
    let centers: Vec<[f32; 3]> = (0..count).map(|_| [random(), random(), random()]).collect();
    let radii = (0..count)
        .map(|_| {
            if spread {
                0.1 * 10_f32.powf(-6.0 * random())
            } else {
                0.05
            }
        })
        .collect();
    BlobField {
        kernel: Kernel::Sextic,
        threshold: 0.3,
        origin: DVec3::ZERO,
        centers,
        shapes: Shapes::Balls(radii),
        weights: vec![1.0; count],
        rows: (0..count as u32).collect(),
        motion: None,
        attributes: Vec::new(),
        spacing: 0.05,
        search: Search::default(),
    }
}

const BUILDERS: [Builder; 2] = [Builder::Sah, Builder::Morton];

/// Every blob stands in exactly one leaf, within the boxes of all nodes above it.
fn check(tree: &ParticleTree, field: &BlobField) {
    let mut seen = vec![0; field.len()];
    let mut open = Vec::new();
    if let Some(bounds) = tree.bounds {
        open.push((0, bounds));
    }
    let per_leaf = layout::leaf_blocks::<Ball>(layout::motion_columns(field));
    while let Some((reference, bounds)) = open.pop() {
        if reference & LEAF == 0 {
            let node: &Node = &tree.nodes[reference as usize];
            for slot in 0..8 {
                if node.children[slot] == Node::NONE {
                    continue;
                }
                let corner = |upper: usize| {
                    Vec3::from_array([0, 1, 2].map(|axis| node.bounds[3 * upper + axis][slot]))
                };
                let (min, max) = (corner(0), corner(1));
                assert!(bounds.contains(min) && bounds.contains(max));
                open.push((node.children[slot], Aabb { min, max }));
            }
            continue;
        }
        let leaf = &tree.blocks[(reference & !LEAF) as usize * per_leaf..][..per_leaf];
        let count = LeafHeader::from_block(&leaf[0]).count;
        assert!((1..=topology::LEAF_BLOBS).contains(&count));
        for slot in leaf[layout::columns::<Ball>()].0.iter().take(count) {
            let i = slot.to_bits() as usize;
            seen[i] += 1;
            let support = field.support_box(i);
            assert!(bounds.contains(support.min) && bounds.contains(support.max));
        }
    }
    assert!(seen.iter().all(|&times| times == 1));
}

#[test]
fn every_blob_is_in_one_leaf_within_its_boxes() {
    for builder in BUILDERS {
        for count in [0, 1, 16, 17, 97, 5_000, 40_000] {
            for spread in [false, true] {
                let field = field(count, spread);
                check(&ParticleTree::build(&field, builder), &field);
            }
        }
    }
}

#[test]
fn blobs_at_one_place_and_clusters_far_smaller_than_the_whole() {
    for builder in BUILDERS {
        let mut field = field(3_000, false);
        for (i, center) in field.centers.iter_mut().enumerate() {
            *center = match i {
                0 => [1e9; 3],
                1..1_500 => [0.5; 3],
                _ => [i as f32 * 1e-3, 0.0, 0.0],
            };
        }
        check(&ParticleTree::build(&field, builder), &field);
    }
}

#[test]
fn the_same_tree_for_any_number_of_threads() {
    let field = field(60_000, true);
    for builder in BUILDERS {
        let build = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            pool.expect("threads start")
                .install(|| ParticleTree::build(&field, builder))
        };
        assert_eq!(build(1), build(3));
    }
}

#[test]
fn a_refit_tree_holds_moved_blobs() {
    for builder in BUILDERS {
        let mut field = field(2_000, true);
        let built = ParticleTree::build(&field, builder);
        let mut tree = ParticleTree::build(&field, builder);
        tree.refit(&field);
        assert_eq!(tree, built);
        assert!(!tree.is_worn());
        for (i, center) in field.centers.iter_mut().enumerate() {
            center[i % 3] += 0.3 * (i as f32).sin();
        }
        tree.refit(&field);
        check(&tree, &field);
        field.centers.reverse();
        tree.refit(&field);
        check(&tree, &field);
        assert!(tree.is_worn());
    }
}

#[test]
fn inner_spheres_only_where_every_blob_has_one() {
    let mut field = field(20, false);
    let level = |field: &BlobField| ParticleTree::build(field, Builder::Sah).inner_level;
    assert!(level(&field) < 1.0);
    field.weights[3] = 0.2;
    assert!(level(&field) >= 1.0);
    field.weights[3] = -2.0;
    assert!(level(&field) >= 1.0);
}

/// `count` blobs that fly along strongly curved ways of about `way` box sizes, far from the origin;
/// ellipsoids turn and stretch as well.
fn flying(count: usize, way: f32, ellipsoids: bool) -> BlobField {
    let mut field = field(count, false);
    let number = |i: usize, k: usize| ((i * 7 + k * 13) as f32 * 1.618_034).sin();
    let rates = |i: usize, k: usize| [0, 1, 2].map(|axis| way * number(i, k + axis));
    if ellipsoids {
        let factor = |i: usize| {
            let radii = DVec3::new(0.02, 0.05, 0.08);
            let turn = DMat3::from_rotation_y(i as f64) * DMat3::from_rotation_x(0.3 * i as f64);
            let axes = turn * DMat3::from_diagonal(radii);
            let inverse = axes.inverse();
            Ellipsoid::from_metric(inverse.transpose() * inverse).expect("three axes")
        };
        field.shapes = Shapes::Ellipsoids((0..count).map(factor).collect());
    }
    for center in &mut field.centers {
        center[0] += 40.0;
    }
    field.motion = Some(Motion {
        velocities: (0..count).map(|i| rates(i, 0)).collect(),
        half_accelerations: (0..count).map(|i| rates(i, 3).map(|a| 2.0 * a)).collect(),
        velocity_gradients: if ellipsoids {
            let gradient = |i: usize| [0, 1, 2, 3, 4, 5, 6, 7, 8].map(|k| 0.2 * number(i, k));
            (0..count).map(gradient).collect()
        } else {
            Vec::new()
        },
        shutter: [-0.2, 0.8],
    });
    field
}

/// The exact box around the support of blob `i` at a time.
fn exact_box(field: &BlobField, i: usize, secs: f64) -> [DVec3; 2] {
    let at = field.at(secs);
    let columns = DVec3::AXES.map(|axis| at.transform(i, axis));
    let inverse = DMat3::from_cols(columns[0], columns[1], columns[2]).inverse();
    let half = DVec3::from_array([0, 1, 2].map(|row| inverse.row(row).length()));
    [at.center(i) - half, at.center(i) + half]
}

/// A face at a time, in f32 as rays find it.
fn face_at(faces: &MovingFaces<'_>, elapsed: &Elapsed<f32>, row: usize, slot: usize) -> f32 {
    let close = faces.close.expect("blobs move")[row][slot];
    let straight = elapsed.straight(faces.open[row][slot], close);
    match faces.bulge {
        None => straight,
        Some(bulge) => elapsed.bent(straight, bulge[row][slot]),
    }
}

/// Every blob lies within the boxes of all nodes above it at a time, interpolated in f32 as rays do.
fn check_at(tree: &ParticleTree, field: &BlobField, secs: f64) {
    let [open, close] = tree.shutter_secs;
    let part = ((secs - open) / (close - open)) as f32;
    let elapsed = Elapsed::new(part, 1.0 - part);
    let per_leaf = match field.shapes {
        Shapes::Balls(_) => layout::leaf_blocks::<Ball>(layout::motion_columns(field)),
        Shapes::Ellipsoids(_) => layout::leaf_blocks::<Ellipsoid>(layout::motion_columns(field)),
    };
    let indices = match field.shapes {
        Shapes::Balls(_) => layout::columns::<Ball>(),
        Shapes::Ellipsoids(_) => layout::columns::<Ellipsoid>(),
    };
    let mut seen = 0;
    let mut open = vec![(0_u32, Vec::<[DVec3; 2]>::new())];
    while let Some((reference, above)) = open.pop() {
        if reference & LEAF == 0 {
            let faces = tree.faces(reference as usize);
            for slot in 0..8 {
                let child = tree.nodes[reference as usize].children[slot];
                let face = |row: usize| face_at(&faces, &elapsed, row, slot);
                let corner = |first: usize| {
                    DVec3::from_array([0, 1, 2].map(|axis| f64::from(face(first + axis))))
                };
                let [min, max] = [corner(0), corner(3)];
                if child == Node::NONE {
                    assert!(min.cmpgt(max).all());
                    continue;
                }
                let mut boxes = above.clone();
                boxes.push([min, max]);
                open.push((child, boxes));
            }
            continue;
        }
        let leaf = &tree.blocks[(reference & !LEAF) as usize * per_leaf..][..per_leaf];
        let count = LeafHeader::from_block(&leaf[0]).count;
        for slot in &leaf[indices].0[..count] {
            let [low, high] = exact_box(field, slot.to_bits() as usize, secs);
            for [min, max] in &above {
                assert!(min.cmple(low).all() && high.cmple(*max).all(), "{secs}");
            }
            seen += 1;
        }
    }
    assert_eq!(seen, field.len());
}

#[test]
fn boxes_hold_their_blobs_at_all_times() {
    for ellipsoids in [false, true] {
        for way in [0.01, 1.0, 30.0] {
            let field = flying(1_500, way, ellipsoids);
            for bounds in [
                MotionBounds::Linear,
                MotionBounds::Bezier,
                MotionBounds::Auto,
            ] {
                let mut tree = ParticleTree::build_with(&field, Builder::Sah, bounds);
                assert!(tree.moves());
                for n in 0..25 {
                    let phase = f64::from(n) * 0.618_034 % 1.0;
                    let part = [0.0, 1.0, 0.5].get(n as usize).copied().unwrap_or(phase);
                    check_at(&tree, &field, -0.2 + part);
                }
                let other = flying(1_500, 0.5 * way, ellipsoids);
                tree.refit(&other);
                check_at(&tree, &other, 0.123);
            }
        }
    }
}

#[test]
fn curves_are_taken_where_ways_are_bent() {
    let along_curves = |field: &BlobField, bounds: MotionBounds| {
        ParticleTree::build_with(field, Builder::Morton, bounds).moves_along_curves()
    };
    let bent = flying(2_000, 1.0, false);
    let mut straight = bent.clone();
    if let Some(motion) = &mut straight.motion {
        motion.half_accelerations.fill([0.0; 3]);
        motion.velocities.fill([1.0, -2.0, 0.5]);
    }
    assert!(along_curves(&bent, MotionBounds::Auto));
    assert!(!along_curves(&bent, MotionBounds::Linear));
    assert!(!along_curves(&straight, MotionBounds::Auto));
    assert!(along_curves(&straight, MotionBounds::Bezier));
}

#[test]
fn straightened_boxes_hold_curves() {
    let field = flying(300, 3.0, true);
    let tree = ParticleTree::build_with(&field, Builder::Sah, MotionBounds::Bezier);
    for index in 0..tree.nodes.len() {
        let curved = tree.faces(index);
        let [open, close] = curved.straightened();
        for step in 0..=16 {
            let part = step as f32 / 16.0;
            let elapsed = Elapsed::new(part, 1.0 - part);
            for (row, slot) in (0..6).flat_map(|row| (0..8).map(move |slot| (row, slot))) {
                let exact = face_at(&curved, &elapsed, row, slot);
                let straight = elapsed.straight(open[row][slot], close[row][slot]);
                let margin = 1e-5 * (1.0 + exact.abs());
                let outside = if row < 3 {
                    exact - straight
                } else {
                    straight - exact
                };
                assert!(outside >= -margin, "{outside}");
            }
        }
    }
}
