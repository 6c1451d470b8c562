//! Trees that the device builds: every blob in one leaf, in the order of the curve, every box around
//! what it holds, and what becomes of them when the blobs move on.

use crate::common::{Gpu, SHUTTER, blobs, device, moving};
use glam::{DVec3, Vec3};
use meniscus::accel::cells::layout::LEAF;
use meniscus::accel::particles::size_class;
use meniscus::field::{BlobField, Search};
use meniscus::kernel::Kernel;
use meniscus::math::morton::morton;
use meniscus::primitive::Shapes;
use meniscus::scene::Builder;
use meniscus_gpu::{TracerOptions, TreeUpdate};
use meniscus_testing::corpus::{self, Scene};
use meniscus_testing::examine::Question;
use meniscus_testing::oracle::Oracle;
use meniscus_testing::rays;
use meniscus_testing::suite::{Stage, complaints};

const NONE: u32 = u32::MAX;
const CHILDREN_AT: usize = 12;

/// A box at both ends of the shutter.
#[derive(Clone, Copy)]
struct Ends([[Vec3; 2]; 2]);

impl Ends {
    /// At a part of the shutter's time.
    fn at(&self, elapsed: f64) -> [DVec3; 2] {
        [0, 1].map(|corner| {
            let [open, close] = self.0.map(|bounds| bounds[corner].as_dvec3());
            open.lerp(close, elapsed)
        })
    }
}

/// A tree as the shaders see it.
struct Tree<'a> {
    field: &'a BlobField,
    words: Vec<[u32; 4]>,
    leaves_at: usize,
    node_words: usize,
    blob_words: usize,
    /// Place of the index in a blob's last word of its shape.
    index_at: (usize, usize),
}

impl<'a> Tree<'a> {
    fn new(field: &'a BlobField, (words, leaves_at): (Vec<[u32; 4]>, usize)) -> Self {
        let moves = field.motion.is_some();
        let (shape_words, index_at) = match field.shapes {
            Shapes::Balls(_) => (2, (1, 1)),
            Shapes::Ellipsoids(_) => (3, (2, 2)),
        };
        Self {
            field,
            words,
            leaves_at,
            node_words: if moves { 26 } else { 14 },
            blob_words: shape_words + if moves { 2 } else { 0 },
            index_at,
        }
    }

    fn child(&self, node: usize, slot: usize) -> u32 {
        self.words[node * self.node_words + CHILDREN_AT + slot / 4][slot % 4]
    }

    fn ends(&self, node: usize, slot: usize) -> Ends {
        let first = node * self.node_words;
        let bounds = |at: usize| {
            let face = |row: usize| f32::from_bits(self.words[at + 2 * row + slot / 4][slot % 4]);
            [0, 3].map(|row| Vec3::new(face(row), face(row + 1), face(row + 2)))
        };
        let open = bounds(first);
        let close = match self.field.motion {
            None => open,
            Some(_) => bounds(first + CHILDREN_AT + 2),
        };
        Ends([open, close])
    }

    /// Blobs of a leaf, after looking at their places in it.
    fn leaf(&self, leaf: usize) -> Vec<usize> {
        let first = self.leaves_at + leaf * (2 + 16 * self.blob_words);
        let [x, y, z, count] = self.words[first];
        let center = Vec3::new(f32::from_bits(x), f32::from_bits(y), f32::from_bits(z));
        let (word, part) = self.index_at;
        let middle = self.field.motion.as_ref().map_or(0.0, |m| m.middle_secs());
        (0..count as usize)
            .map(|slot| {
                let at = first + 2 + slot * self.blob_words;
                let index = self.words[at + word][part] as usize;
                let [x, y, z] = [0, 1, 2].map(|axis| f32::from_bits(self.words[at][axis]));
                let place = center.as_dvec3() + Vec3::new(x, y, z).as_dvec3();
                let error = (place - self.field.at(middle).center(index)).length();
                let reach = f64::from(Vec3::new(x, y, z).length());
                assert!(error <= 2e-7 * reach, "blob {index} is off by {error}");
                index
            })
            .collect()
    }

    /// The blobs of all leaves, every box having been looked at.
    fn checked(&self) -> Vec<usize> {
        let mut order = Vec::new();
        self.check_node(0, &mut order);
        order
    }

    fn check_node(&self, node: usize, order: &mut Vec<usize>) -> Vec<Ends> {
        let mut boxes = Vec::new();
        for slot in 0..8 {
            let child = self.child(node, slot);
            if child == NONE {
                continue;
            }
            let ends = self.ends(node, slot);
            if child & LEAF != 0 {
                for index in self.leaf((child & !LEAF) as usize) {
                    self.check_support(index, ends);
                    order.push(index);
                }
            } else {
                for inner in self.check_node(child as usize, order) {
                    for end in 0..2 {
                        let ([low, high], [inner_low, inner_high]) = (ends.0[end], inner.0[end]);
                        assert!(low.cmple(inner_low).all() && inner_high.cmple(high).all());
                    }
                }
            }
            boxes.push(ends);
        }
        boxes
    }

    fn check_support(&self, index: usize, ends: Ends) {
        let half = Vec3::from(self.field.shapes.half_extents(index)).as_dvec3();
        for elapsed in [0.0, 0.31, 0.5, 0.77, 1.0] {
            let [open, close] = SHUTTER;
            let center = self.field.at(open + (close - open) * elapsed).center(index);
            let [low, high] = ends.at(elapsed);
            let holds = low.cmple(center - half).all() && (center + half).cmple(high).all();
            assert!(holds, "blob {index} leaves its box at {elapsed}");
        }
    }
}

/// Place on the Hilbert curve of a cell of a grid with 2¹⁹ cells per axis (Skilling 2004).
fn hilbert(cell: [u32; 3]) -> u64 {
    let mut x = cell;
    let highest = 1_u32 << 18;
    let mut bit = highest;
    while bit > 1 {
        let below = bit - 1;
        for axis in 0..3 {
            if x[axis] & bit != 0 {
                x[0] ^= below;
            } else {
                let swap = (x[0] ^ x[axis]) & below;
                x[0] ^= swap;
                x[axis] ^= swap;
            }
        }
        bit >>= 1;
    }
    x[1] ^= x[0];
    x[2] ^= x[1];
    let mut turned = 0;
    let mut bit = highest;
    while bit > 1 {
        if x[2] & bit != 0 {
            turned ^= bit - 1;
        }
        bit >>= 1;
    }
    morton(x.map(|c| u64::from(c ^ turned)))
}

/// The order that the device is to find.
fn along_curve(field: &BlobField) -> Vec<usize> {
    let middle = field.motion.as_ref().map_or(0.0, |m| m.middle_secs());
    let place = |i: usize| field.at(middle).center(i).as_vec3();
    let all = 0..field.len();
    let low = all.clone().map(place).fold(Vec3::INFINITY, Vec3::min);
    let high = all.clone().map(place).fold(Vec3::NEG_INFINITY, Vec3::max);
    let last = ((1_u32 << 19) - 1) as f32;
    let extent = (high - low).max_element();
    let scale = if extent > 0.0 { last / extent } else { 0.0 };
    let mut codes: Vec<(u64, u64, usize)> = all
        .map(|i| {
            let cell = ((place(i) - low) * scale).to_array();
            let code = hilbert(cell.map(|c| (c as u32).min((1 << 19) - 1)));
            (size_class(field.shapes.mean_radius(i)), code, i)
        })
        .collect();
    codes.sort_unstable();
    codes.into_iter().map(|(_, _, i)| i).collect()
}

#[test]
fn neighbours_on_the_curve_touch() {
    let side = 8_u32;
    let scale = (1 << 19) / side;
    let mut cells: Vec<[u32; 3]> = (0..side.pow(3))
        .map(|i| [i % side, i / side % side, i / side / side])
        .collect();
    cells.sort_by_key(|cell| hilbert(cell.map(|c| c * scale)));
    for pair in cells.windows(2) {
        let steps: u32 = (0..3)
            .map(|axis| pair[0][axis].abs_diff(pair[1][axis]))
            .sum();
        assert_eq!(steps, 1, "{pair:?}");
    }
}

fn check(field: &BlobField, options: TracerOptions) {
    let Some(device) = device("trees_hold_what_they_should") else {
        return;
    };
    let blobs = blobs(field.clone(), Builder::Device);
    let gpu = Gpu::new(device, &blobs, options);
    let order = Tree::new(field, gpu.words()).checked();
    assert_eq!(order, along_curve(field));
}

#[test]
fn trees_hold_what_they_should() {
    // More than one block of the sort.
    for (kind, count) in [
        ("pool", 9000),
        ("mixed", 5000),
        ("ellipsoids", 4097),
        ("pool", 3),
    ] {
        let scene = corpus::scene(kind, Kernel::Sextic, count);
        check(&scene.field, TracerOptions::default());
        check(&moving(scene).field, TracerOptions::default());
    }
    let small = TracerOptions {
        largest_chunk_bytes: Some(1 << 15),
        capacity: None,
    };
    let scene = corpus::scene("ellipsoids", Kernel::Sextic, 900);
    check(&scene.field, small);
    check(&moving(scene).field, small);
}

/// Equal keys stay in order, over several blocks of the sort.
#[test]
fn blobs_at_one_place_stay_in_order() {
    let mut field = corpus::scene("pool", Kernel::Sextic, 9000).field;
    let count = field.centers.len();
    field.centers = vec![field.centers[0]; count];
    field.search = Search::default();
    let expected: Vec<usize> = (0..count).collect();
    assert_eq!(along_curve(&field), expected);
    check(&field, TracerOptions::default());
}

/// Blobs that move a little keep their leaves; those that are scattered get new ones.
#[test]
fn trees_follow_their_blobs() {
    let Some(device) = device("trees_follow_their_blobs") else {
        return;
    };
    let scene = corpus::scene("pool", Kernel::Sextic, 2000);
    let count = scene.field.len();
    let spacing = scene.field.spacing;
    let moved = |by: f32| {
        let mut next = scene.field.clone();
        for (i, center) in next.centers.iter_mut().enumerate() {
            center[i % 3] += by * spacing * (i as f32).sin();
        }
        next.search = Search::default();
        next
    };
    let mut swapped = scene.field.clone();
    for i in 0..count / 2 {
        if i % 3 == 0 {
            swapped.centers.swap(i, count - 1 - i);
        }
    }
    swapped.search = Search::default();
    let fewer = corpus::scene("pool", Kernel::Sextic, 1500).field;
    let steps = [
        (moved(0.05), TreeUpdate::Refitted),
        (moved(-0.05), TreeUpdate::Refitted),
        (swapped, TreeUpdate::Rebuilt),
        (fewer, TreeUpdate::Sent),
    ];
    let first = blobs(scene.field.clone(), Builder::Device);
    let all: Vec<_> = steps
        .map(|(field, expected)| (blobs(field, Builder::Device), expected))
        .into();
    let mut gpu = Gpu::new(device, &first, TracerOptions::default());
    for (next, expected) in &all {
        let update;
        (gpu, update) = gpu.followed_by(next);
        assert_eq!(update, *expected);
        let mut order = Tree::new(&next.field, gpu.words()).checked();
        order.sort_unstable();
        assert!(order.into_iter().eq(0..next.field.len()));
        let stage_scene = Scene {
            field: next.field.clone(),
            ..scene.clone()
        };
        let oracle = Oracle::new(&stage_scene.field);
        let stage = Stage::new(&stage_scene, &oracle, 60);
        let mut all = rays::hemisphere(&stage.points, 3);
        all.extend(rays::primary(&oracle, 16, DVec3::new(0.3, 0.5, 1.0)));
        for question in [Question::ClosestTogether, Question::AnyTogether] {
            assert_eq!(complaints(&gpu, &stage, &all, question), None);
        }
    }
}
