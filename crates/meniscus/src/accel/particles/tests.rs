use super::layout::Node;
use super::*;

use crate::accel::cells::layout::{LEAF, LeafHeader};
use crate::field::Search;
use crate::kernel::Kernel;
use glam::DVec3;

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
