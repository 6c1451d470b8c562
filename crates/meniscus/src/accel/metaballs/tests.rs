use super::{Boxes, LEAF, LeafHeader, MetaballTree};
use crate::accel::cells::layout::{Columns, LANES};
use crate::field::{BlobField, Search};
use crate::kernel::Kernel;
use crate::math::aabb::Aabb;
use crate::math::ray::Side;
use crate::primitive::{Ball, Ellipsoid, Shapes};
use crate::scene::{EngineSettings, LeafCost};
use glam::{DMat3, DVec3, Vec3};

/// Reproducible numbers in [0, 1).
fn random(seed: u32) -> impl FnMut() -> f32 {
    let mut state = seed;
    move || {
        state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        (state >> 8) as f32 / (1 << 24) as f32
    }
}

fn field(count: usize, size: f32, ellipsoids: bool, negative: bool) -> BlobField {
    let mut next = random(7);
    let centers: Vec<[f32; 3]> = (0..count)
        .map(|_| [next() * size, next() * size, next() * size])
        .collect();
    let shapes = if ellipsoids {
        let metric = |a: f32, b: f32| {
            let turn = DMat3::from_rotation_y(f64::from(a)) * DMat3::from_rotation_x(f64::from(b));
            let stretch = DMat3::from_diagonal(DVec3::new(0.3, 1.0, 4.0));
            Ellipsoid::from_metric(turn * stretch * turn.transpose()).unwrap()
        };
        Shapes::Ellipsoids(
            (0..count)
                .map(|_| metric(next() * 6.0, next() * 6.0))
                .collect(),
        )
    } else {
        Shapes::Balls((0..count).map(|_| 0.6 + 0.8 * next()).collect())
    };
    let weights = (0..count)
        .map(|i| {
            if negative && i % 5 == 0 {
                -0.5
            } else {
                0.5 + next()
            }
        })
        .collect();
    BlobField {
        kernel: Kernel::Wyvill,
        threshold: 0.7,
        origin: DVec3::ZERO,
        centers,
        shapes,
        weights,
        rows: (0..count as u32).collect(),
        motion: None,
        attributes: Vec::new(),
        spacing: 0.7,
        search: Search::default(),
    }
}

/// Every combination of the switches.
fn all_settings() -> Vec<EngineSettings> {
    let mut all = Vec::new();
    for cost in [LeafCost::N, LeafCost::N2] {
        for bits in [0, 1, 3, 4, 7] {
            all.push(EngineSettings {
                cost,
                fit: bits & 1 != 0,
                rmax_boxes: bits & 2 != 0,
                discard: bits & 4 != 0,
                ..EngineSettings::default()
            });
        }
    }
    all
}

fn balls_per_chunk() -> usize {
    Columns::ALL.blocks_per_chunk::<Ball>()
}

/// Box and blobs of each leaf, own ones first, with their number.
fn leaves(tree: &MetaballTree, per_chunk: usize) -> Vec<(Aabb, Vec<u32>)> {
    let mut leaves = Vec::new();
    let mut open: Vec<(u32, Aabb)> = tree.root.into_iter().zip(tree.bounds).collect();
    while let Some((reference, bounds)) = open.pop() {
        if reference & LEAF == 0 {
            let node = &tree.nodes[reference as usize];
            for child in 0..2 {
                let corner =
                    |row: usize| Vec3::from_array([0, 1, 2].map(|k| node.bounds[row + k][child]));
                let around = Aabb {
                    min: corner(0),
                    max: corner(3),
                };
                open.push((node.children[child], around));
            }
            continue;
        }
        let block = (reference & !LEAF) as usize;
        let header = LeafHeader::from_block(&tree.blocks[block]);
        let blobs: Vec<u32> = (0..header.chunks)
            .flat_map(|chunk| tree.blocks[block + chunk * per_chunk + per_chunk].0)
            .map(f32::to_bits)
            .filter(|&blob| blob != u32::MAX)
            .collect();
        assert_eq!(blobs.len(), header.count);
        assert!(header.own_chunks <= header.chunks && header.chunks * LANES <= tree.largest_leaf);
        leaves.push((bounds, blobs));
    }
    assert_eq!(leaves.len(), tree.leaves);
    leaves
}

/// What the paper promises of an FBVH: the leaves hold all of the surface, and each knows the field
/// wherever it is at least T.
fn check_disjoint(field: &BlobField, settings: &EngineSettings) {
    let per_chunk = match field.shapes {
        Shapes::Balls(_) => balls_per_chunk(),
        Shapes::Ellipsoids(_) => Columns::ALL.blocks_per_chunk::<Ellipsoid>(),
    };
    let tree = MetaballTree::build(field, Boxes::Disjoint, settings);
    let leaves = leaves(&tree, per_chunk);
    let bounds = field.bounds();
    let mut next = random(99);
    let mut inside = 0;
    for _ in 0..600 {
        let u = Vec3::new(next(), next(), next());
        let point = bounds.min + bounds.size() * u;
        let value = field.value(point.as_dvec3());
        let holding: Vec<_> = leaves.iter().filter(|(b, _)| b.contains(point)).collect();
        if value > 0.7 {
            inside += 1;
            assert!(!holding.is_empty(), "{settings:?}: no leaf at {point}");
        }
        for (_, blobs) in holding {
            let known: f64 = blobs
                .iter()
                .map(|&blob| {
                    let d = point.as_dvec3() - field.center(blob as usize).as_dvec3();
                    let q = field.shapes.q(blob as usize, d);
                    f64::from(field.weights[blob as usize]) * field.kernel.value(q)
                })
                .sum();
            let right = if value >= 0.7 || !tree.settings.discard {
                (known - value).abs() < 1e-9
            } else {
                known <= value + 1e-9
            };
            assert!(right, "{settings:?}: {known} of {value} at {point}");
        }
    }
    assert!(inside > 20, "{inside} points are inside");
}

#[test]
fn disjoint_leaves_hold_the_surface_and_know_the_field() {
    for (size, ellipsoids, negative) in [
        (4.0, false, false),
        (9.0, false, false),
        (6.0, true, false),
        (5.0, false, true),
    ] {
        let field = field(200, size, ellipsoids, negative);
        for settings in all_settings() {
            check_disjoint(&field, &settings);
        }
    }
}

#[test]
fn overlapping_leaves_own_every_metaball_once_and_know_its_support() {
    let field = field(300, 6.0, false, false);
    for cost in [LeafCost::N, LeafCost::N2] {
        let settings = EngineSettings {
            cost,
            ..EngineSettings::default()
        };
        let tree = MetaballTree::build(&field, Boxes::Overlapping, &settings);
        assert!(!tree.settings.fit && !tree.settings.rmax_boxes && !tree.settings.discard);
        let mut next = random(5);
        let mut owned = 0;
        for i in 0..field.len() {
            // A leaf whose box holds all of the support and that lists every blob at some point of it.
            let support = field.support_box(i);
            let point = field.center(i) + (Vec3::new(next(), next(), next()) - 0.5) * 0.5;
            let mut needed = Vec::new();
            field.contributions(point.as_dvec3(), &mut needed);
            let owner = leaves(&tree, balls_per_chunk())
                .into_iter()
                .find(|(bounds, blobs)| {
                    bounds.contains(support.min)
                        && bounds.contains(support.max)
                        && blobs.contains(&(i as u32))
                        && needed.iter().all(|part| blobs.contains(&part.blob))
                });
            owned += usize::from(owner.is_some());
        }
        assert_eq!(owned, field.len(), "{cost:?}");
    }
}

#[test]
fn each_switch_makes_boxes_or_lists_smaller() {
    let field = field(3000, 26.0, false, false);
    let none = EngineSettings {
        fit: false,
        rmax_boxes: false,
        discard: false,
        ..EngineSettings::default()
    };
    let measure = |settings: &EngineSettings| {
        let tree = MetaballTree::build(&field, Boxes::Disjoint, settings);
        let leaves = leaves(&tree, balls_per_chunk());
        let n = leaves.len() as f32;
        let volume: f32 = leaves.iter().map(|(b, _)| b.size().element_product()).sum();
        let blobs: usize = leaves.iter().map(|(_, blobs)| blobs.len()).sum();
        (volume, blobs as f32 / n)
    };
    let fit = EngineSettings { fit: true, ..none };
    let rmax = EngineSettings {
        rmax_boxes: true,
        ..fit
    };
    let all = EngineSettings {
        discard: true,
        ..rmax
    };
    let [none, fit, rmax, all] = [none, fit, rmax, all].map(|settings| measure(&settings));
    assert!(fit.0 < 0.9 * none.0, "{fit:?} {none:?}");
    assert!(rmax.0 < 0.95 * fit.0, "{rmax:?} {fit:?}");
    assert!(all.1 < rmax.1, "{all:?} {rmax:?}");
}

#[test]
fn negative_weights_switch_the_bounds_off() {
    let all = EngineSettings::default();
    let tree = MetaballTree::build(&field(200, 4.0, false, true), Boxes::Disjoint, &all);
    let off = tree.settings;
    assert!(!off.fit && !off.rmax_boxes && !off.discard);
    let tree = MetaballTree::build(&field(200, 4.0, false, false), Boxes::Disjoint, &all);
    assert_eq!(tree.settings, all);
}

#[test]
fn the_tree_is_the_same_for_any_number_of_threads() {
    let field = field(5000, 14.0, false, false);
    for boxes in [Boxes::Overlapping, Boxes::Disjoint] {
        let build = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            let build = || MetaballTree::build(&field, boxes, &EngineSettings::default());
            pool.unwrap().install(build)
        };
        let bits = |tree: &MetaballTree| -> Vec<u32> {
            let blocks = tree.blocks.iter().flat_map(|block| block.0);
            blocks.map(f32::to_bits).collect()
        };
        let (one, four) = (build(1), build(4));
        assert_eq!(one.nodes, four.nodes);
        assert_eq!(bits(&one), bits(&four));
    }
}

#[test]
fn fields_without_surface_and_tiny_fields() {
    for boxes in [Boxes::Overlapping, Boxes::Disjoint] {
        let settings = EngineSettings::default();
        let empty = MetaballTree::build(&field(0, 1.0, false, false), boxes, &settings);
        assert!(empty.root.is_none() && empty.bounds.is_none());
        let one = MetaballTree::build(&field(1, 1.0, false, false), boxes, &settings);
        assert!(one.leaves <= 1);
        let same = BlobField {
            centers: vec![[0.5; 3]; 40],
            ..field(40, 1.0, false, false)
        };
        assert!(MetaballTree::build(&same, boxes, &settings).leaves >= 1);
        let high = BlobField {
            threshold: 1e6,
            ..field(40, 1.0, false, false)
        };
        let none = MetaballTree::build(&high, boxes, &settings);
        assert_eq!(none.root.is_none(), boxes == Boxes::Disjoint);
        assert_eq!(high.side(DVec3::splat(0.5)), Side::Outside);
    }
}
