//! Entries and exits of supports along a ray, in order, found while the tree is walked front to back.

use crate::accel::supports::{Contents, Segment, SupportTree};
use crate::field::BlobField;
use crate::intersect::Counters;
use glam::DVec3;
use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

/// A blob along the ray: g(s) = g₀ − β(s − c)².
#[derive(Debug, Clone, Copy)]
pub(super) struct Active {
    /// Index of the blob.
    pub(super) index: u32,
    /// Its weight.
    pub(super) weight: f64,
    /// Largest g on the line.
    pub(super) g0: f64,
    /// 1/length².
    pub(super) beta: f64,
    /// Where g is largest.
    pub(super) center: f64,
}

impl Active {
    /// g at `s`; negative outside the support.
    #[inline(always)]
    pub(super) fn g(&self, s: f64) -> f64 {
        let d = s - self.center;
        self.g0 - self.beta * d * d
    }
}

/// What happens at an event.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum What {
    /// The ray enters the support of the candidate.
    Entry(u32),
    /// The ray leaves it.
    Exit(u32),
    /// The ray enters a node of the tree.
    Node(u32),
}

/// Something that happens at `s`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Event {
    /// Where along the ray.
    pub(super) s: f64,
    what: What,
}

impl Eq for Event {}

impl Ord for Event {
    fn cmp(&self, other: &Self) -> Ordering {
        self.s
            .total_cmp(&other.s)
            .then_with(|| self.what.cmp(&other.what))
    }
}

impl PartialOrd for Event {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// Nodes yet to be opened and supports yet to be entered or left, nearest first.
#[derive(Debug, Default)]
pub(super) struct EventQueue {
    heap: BinaryHeap<Reverse<Event>>,
    candidates: Vec<Active>,
    segment: Option<Segment>,
}

impl EventQueue {
    /// Starts a ray.
    pub(super) fn start(&mut self, tree: &SupportTree, segment: Segment) {
        self.heap.clear();
        self.candidates.clear();
        self.segment = Some(segment);
        self.heap.extend(tree.root().map(|root| {
            Reverse(Event {
                s: f64::NEG_INFINITY,
                what: What::Node(root),
            })
        }));
    }

    /// The next entry or exit. Nodes nearer than it are opened first, so nothing comes too late.
    pub(super) fn next(
        &mut self,
        tree: &SupportTree,
        field: &BlobField,
        counters: &mut Counters,
    ) -> Option<Event> {
        let segment = self.segment?;
        while let Some(Reverse(event)) = self.heap.pop() {
            let What::Node(node) = event.what else {
                return Some(event);
            };
            match tree.contents(node) {
                Contents::Children(children) => {
                    counters.nodes += 1;
                    for child in children {
                        if let Some((s, _)) = segment.overlap(tree.bounds(child)) {
                            let what = What::Node(child);
                            self.heap.push(Reverse(Event { s, what }));
                        }
                    }
                }
                Contents::Blobs(blobs) => {
                    counters.leaves += 1;
                    counters.blob_evaluations += blobs.len() as u64;
                    for &blob in blobs {
                        self.meet(field, blob, &segment);
                    }
                }
            }
        }
        None
    }

    /// Queues the entry and exit of a blob if the segment pierces its support.
    fn meet(&mut self, field: &BlobField, index: u32, segment: &Segment) {
        let i = index as usize;
        let at = field.at(segment.time_secs);
        let y = at.transform(i, at.center(i) - segment.origin);
        let v = at.transform(i, segment.direction);
        let beta = v.length_squared();
        let center = y.dot(v) / beta;
        // The part of y perpendicular to v: |y|² − c²β would cancel.
        let off: DVec3 = y - v * center;
        let g0 = 1.0 - off.length_squared();
        let half = (g0 / beta).sqrt();
        let entry = (center - half).max(segment.start);
        let exit = center + half;
        // Also false for numbers that are none.
        if !(g0 > 0.0 && entry < exit && entry < segment.end) {
            return;
        }
        let candidate = self.candidates.len() as u32;
        self.candidates.push(Active {
            index,
            weight: f64::from(field.weights[i]),
            g0,
            beta,
            center,
        });
        for (s, what) in [
            (entry, What::Entry(candidate)),
            (exit, What::Exit(candidate)),
        ] {
            self.heap.push(Reverse(Event { s, what }));
        }
    }

    /// Carries an event out on the list of active blobs, which stays in order of entry.
    pub(super) fn apply(&self, event: Event, active: &mut Vec<Active>) {
        match event.what {
            What::Entry(candidate) => active.push(self.candidates[candidate as usize]),
            What::Exit(candidate) => {
                let index = self.candidates[candidate as usize].index;
                active.retain(|blob| blob.index != index);
            }
            What::Node(_) => {}
        }
    }
}
