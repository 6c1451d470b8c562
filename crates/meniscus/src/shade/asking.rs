//! Whom integrators ask about rays. They are written as `async` functions, which run through where answers
//! come at once, and stop at each question where rays are to be traced many at a time: the compiler makes
//! the records that wavefront path tracing keeps by hand (Laine, Karras & Aila, "Megakernels Considered
//! Harmful", 2013). Either way a sample draws the same random numbers.

use super::rays::{Bundle, ShadeScratch};
use crate::frame::Frame;
use crate::intersect::{BlobTracer, Hit};
use crate::math::ray::Ray;
use std::cell::{RefCell, RefMut};
use std::ops::Range;
use std::pin::Pin;
use std::task::{Context, Poll, Waker};

/// Answers questions about the surfaces of a frame.
pub(super) trait Ask {
    /// Buffers for what is no question; not to be held while an answer is awaited.
    fn scratch(&self) -> RefMut<'_, ShadeScratch>;

    /// The first surface that a ray meets.
    async fn closest(&self, ray: &Ray) -> Option<Hit>;

    /// Whether a ray meets anything.
    async fn is_blocked(&self, ray: &Ray) -> bool;

    /// How many of some rays meet anything.
    async fn blocked_of(&self, rays: impl Iterator<Item = Ray>) -> usize;
}

/// This processor, at once.
pub(super) struct AtOnce<'a> {
    frame: &'a Frame,
    scratch: RefCell<&'a mut ShadeScratch>,
}

impl<'a> AtOnce<'a> {
    pub(super) fn new(frame: &'a Frame, scratch: &'a mut ShadeScratch) -> Self {
        Self {
            frame,
            scratch: RefCell::new(scratch),
        }
    }
}

impl Ask for AtOnce<'_> {
    fn scratch(&self) -> RefMut<'_, ShadeScratch> {
        RefMut::map(self.scratch.borrow_mut(), |scratch| &mut **scratch)
    }

    async fn closest(&self, ray: &Ray) -> Option<Hit> {
        self.frame.closest_hit(ray, &mut self.scratch().trace)
    }

    async fn is_blocked(&self, ray: &Ray) -> bool {
        self.frame.any_hit(ray, &mut self.scratch().trace)
    }

    async fn blocked_of(&self, rays: impl Iterator<Item = Ray>) -> usize {
        let scratch = &mut *self.scratch();
        let Bundle {
            rays: bundle, hits, ..
        } = &mut scratch.bundle;
        bundle.clear();
        bundle.extend(rays);
        hits.clear();
        hits.resize(bundle.len(), false);
        self.frame.any_hits(bundle, hits, &mut scratch.trace);
        hits.iter().filter(|&&is_blocked| is_blocked).count()
    }
}

/// The result of work that asks [`AtOnce`], which never waits.
pub(super) fn run<T>(mut work: Pin<&mut impl Future<Output = T>>) -> T {
    let mut context = Context::from_waker(Waker::noop());
    loop {
        if let Poll::Ready(result) = work.as_mut().poll(&mut context) {
            return result;
        }
    }
}

/// Collects questions; all are answered together.
pub(super) struct Desk<'a> {
    frame: &'a Frame,
    scratch: RefCell<&'a mut ShadeScratch>,
    questions: RefCell<Questions>,
}

/// Those of this round, and the answers to those of the last.
#[derive(Default)]
struct Questions {
    closest: Vec<Ray>,
    closest_hits: Vec<Option<Hit>>,
    any: Vec<Ray>,
    any_hits: Vec<bool>,
}

impl<'a> Desk<'a> {
    pub(super) fn new(frame: &'a Frame, scratch: &'a mut ShadeScratch) -> Self {
        Self {
            frame,
            scratch: RefCell::new(scratch),
            questions: RefCell::default(),
        }
    }

    /// Lets `tracer` answer everything that was asked since the last time.
    pub(super) fn answer<T: BlobTracer + ?Sized>(&self, tracer: &T) -> Result<(), T::Error> {
        let Questions {
            closest,
            closest_hits,
            any,
            any_hits,
        } = &mut *self.questions.borrow_mut();
        let scratch = &mut self.scratch().trace;
        closest_hits.clear();
        closest_hits.resize(closest.len(), None);
        self.frame
            .closest_hits_by(tracer, closest, closest_hits, scratch)?;
        any_hits.clear();
        any_hits.resize(any.len(), false);
        self.frame.any_hits_by(tracer, any, any_hits, scratch)?;
        closest.clear();
        any.clear();
        Ok(())
    }

    /// Asks whether rays meet anything; where the answers will stand.
    fn ask_any(&self, rays: impl Iterator<Item = Ray>) -> Range<usize> {
        let asked = &mut self.questions.borrow_mut().any;
        let first = asked.len();
        asked.extend(rays);
        first..asked.len()
    }
}

impl Ask for Desk<'_> {
    fn scratch(&self) -> RefMut<'_, ShadeScratch> {
        RefMut::map(self.scratch.borrow_mut(), |scratch| &mut **scratch)
    }

    async fn closest(&self, ray: &Ray) -> Option<Hit> {
        let number = {
            let asked = &mut self.questions.borrow_mut().closest;
            asked.push(*ray);
            asked.len() - 1
        };
        next_round().await;
        self.questions.borrow().closest_hits[number]
    }

    async fn is_blocked(&self, ray: &Ray) -> bool {
        self.blocked_of(std::iter::once(*ray)).await > 0
    }

    async fn blocked_of(&self, rays: impl Iterator<Item = Ray>) -> usize {
        let numbers = self.ask_any(rays);
        next_round().await;
        let hits = &self.questions.borrow().any_hits[numbers];
        hits.iter().filter(|&&is_blocked| is_blocked).count()
    }
}

/// Ends when it is looked at for the second time, which is when the questions have been answered.
async fn next_round() {
    let mut is_asked = false;
    std::future::poll_fn(|_| {
        if is_asked {
            return Poll::Ready(());
        }
        is_asked = true;
        Poll::Pending
    })
    .await;
}
