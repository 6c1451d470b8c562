use super::BoxTree;
use crate::math::aabb::DAabb;
use glam::DVec3;

/// Boxes whose sizes span `octaves` powers of two.
fn boxes(count: usize, octaves: f64) -> Vec<DAabb> {
    let mut state = 17_u64;
    let mut next = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    (0..count)
        .map(|_| {
            let center = DVec3::new(next(), next(), next());
            let half = DVec3::new(next(), next(), next()) * (-octaves * next()).exp2();
            DAabb {
                min: center - half,
                max: center + half,
            }
        })
        .collect()
}

fn contains(bounds: &DAabb, point: DVec3) -> bool {
    bounds.min.cmple(point).all() && point.cmple(bounds.max).all()
}

fn containing(tree: &BoxTree, boxes: &[DAabb], point: DVec3) -> Vec<u32> {
    let mut found = Vec::new();
    tree.for_each_containing(point, |item| {
        if contains(&boxes[item as usize], point) {
            found.push(item);
        }
    });
    found.sort_unstable();
    found
}

#[test]
fn every_box_around_a_point_is_found_whatever_the_sizes() {
    for octaves in [0.0, 3.0, 30.0] {
        let boxes = boxes(3000, octaves);
        let tree = BoxTree::build(boxes.len(), |i| boxes[i]);
        let mut total = 0;
        for bounds in boxes.iter().step_by(13) {
            let point = bounds.center();
            let expected: Vec<u32> = (0..3000)
                .filter(|&i| contains(&boxes[i as usize], point))
                .collect();
            total += expected.len();
            assert_eq!(containing(&tree, &boxes, point), expected);
        }
        assert!(total > 300);
        assert!(containing(&tree, &boxes, DVec3::splat(50.0)).is_empty());
    }
}

#[test]
fn every_box_that_meets_a_region_is_in_a_group() {
    let boxes = boxes(2000, 20.0);
    let tree = BoxTree::build(boxes.len(), |i| boxes[i]);
    let region = DAabb {
        min: DVec3::splat(0.4),
        max: DVec3::splat(0.5),
    };
    let mut seen = vec![false; boxes.len()];
    tree.for_each_group_overlapping(&region, |items| {
        items.iter().for_each(|&item| seen[item as usize] = true);
    });
    let meets = |b: &DAabb| b.min.cmple(region.max).all() && region.min.cmple(b.max).all();
    for (bounds, seen) in boxes.iter().zip(&seen) {
        assert!(*seen || !meets(bounds));
    }
    let visited = seen.iter().filter(|seen| **seen).count();
    assert!(visited < 1500, "{visited} of 2000 boxes visited");
}

#[test]
fn groups_and_order_hold_every_item_once() {
    let mut boxes = boxes(500, 12.0);
    // A heap at one place, and a cluster a billionth of the whole.
    let (heap, cluster) = (boxes[0], boxes[1]);
    boxes.extend([heap; 300]);
    boxes.extend((0..300).map(|i| {
        let shift = DVec3::X * f64::from(i) * 1e-9;
        DAabb {
            min: cluster.min + shift,
            max: cluster.max + shift,
        }
    }));
    let tree = BoxTree::build(boxes.len(), |i| boxes[i]);
    let grouped: Vec<u32> = tree.groups().flatten().copied().collect();
    assert_eq!(grouped, tree.order());
    let mut sorted = grouped;
    sorted.sort_unstable();
    assert!(sorted.iter().copied().eq(0..1100));
    assert!(tree.groups().all(|group| (1..=16).contains(&group.len())));
    assert!(tree.bytes() < 1100 * 64);
}

#[test]
fn a_refitted_tree_finds_the_new_boxes() {
    let points = boxes(3000, 40.0);
    let centers: Vec<DVec3> = points.iter().map(DAabb::center).collect();
    let tree = BoxTree::build(3000, |i| DAabb {
        min: centers[i],
        max: centers[i],
    });
    let grown: Vec<DAabb> = centers
        .iter()
        .map(|c| DAabb {
            min: *c - 0.05,
            max: *c + 0.05,
        })
        .collect();
    let tree = tree.refitted(|i| grown[i]);
    for point in centers.iter().step_by(31) {
        let expected: Vec<u32> = (0..3000)
            .filter(|&i| contains(&grown[i as usize], *point))
            .collect();
        assert_eq!(containing(&tree, &grown, *point), expected);
    }
}

#[test]
fn empty_and_single_trees_answer() {
    let none = BoxTree::build(0, |_| DAabb::EMPTY);
    none.for_each_containing(DVec3::ZERO, |_| panic!("there is no box"));
    assert_eq!(none.groups().count(), 0);
    let point = DAabb {
        min: DVec3::ONE,
        max: DVec3::ONE,
    };
    let one = BoxTree::build(1, |_| point);
    assert_eq!(containing(&one, &[point], DVec3::ONE), [0]);
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let boxes = boxes(60_000, 8.0);
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        let tree = pool.install(|| BoxTree::build(boxes.len(), |i| boxes[i]));
        format!("{tree:?}")
    };
    assert!(with(1) == with(4));
}
