//! A device for tests, and a field on it that the suite can ask.

use meniscus::accel::Engine;
use meniscus::field::{BlobField, Motion, Search};
use meniscus::frame::Blobs;
use meniscus::intersect::{BlobHit, Crossing, Scratch};
use meniscus::math::ray::Ray;
use meniscus::math::simd::Level;
use meniscus::scene::{Builder, EngineSettings};
use meniscus_gpu::{
    AdapterChoice, Device, FieldTracer, GpuError, OpenOptions, TraceWork, TracerOptions, TreeUpdate,
};
use meniscus_testing::corpus::Scene;
use meniscus_testing::examine::Tracer;
use std::sync::{Mutex, OnceLock};

/// Fails tests where there is no adapter.
const REQUIRE_VARIABLE: &str = "MENISCUS_REQUIRE_GPU";

/// Any adapter that runs shaders, shared by the tests of a program. Without one the test `test` has to
/// be skipped, which is said.
#[expect(clippy::print_stderr, reason = "tests say what they skip")]
pub(crate) fn device(test: &str) -> Option<&'static Device> {
    static DEVICE: OnceLock<Result<Device, GpuError>> = OnceLock::new();
    let options = OpenOptions {
        choice: AdapterChoice::CardOrSoftware,
        lose_after: None,
    };
    match DEVICE.get_or_init(|| Device::open(options)) {
        Ok(device) => Some(device),
        Err(error) => {
            assert!(
                std::env::var_os(REQUIRE_VARIABLE).is_none(),
                "{test}: {error}; {REQUIRE_VARIABLE} forbids to skip it"
            );
            eprintln!("skipped {test}: {error}");
            None
        }
    }
}

/// A field for engine `particles`, its tree built by `builder`.
pub(crate) fn blobs(field: BlobField, builder: Builder) -> Blobs {
    let settings = EngineSettings {
        builder,
        ..EngineSettings::default()
    };
    Blobs::build_with(field, Engine::Particles, settings, Level::new())
}

/// When the shutter is open where sets move.
pub(crate) const SHUTTER: [f64; 2] = [-0.3, 0.7];

/// A set whose blobs move on curved ways.
pub(crate) fn moving(mut scene: Scene) -> Scene {
    let field = &mut scene.field;
    let speed = 2.0 * field.spacing;
    let rate = |i: usize, turn: f32| {
        let angle = turn * i as f32;
        [angle.cos() * speed, angle.sin() * speed, 0.3 * speed]
    };
    let count = field.len();
    field.motion = Some(Motion {
        velocities: (0..count).map(|i| rate(i, 2.4)).collect(),
        half_accelerations: (0..count).map(|i| rate(i, -1.1)).collect(),
        velocity_gradients: Vec::new(),
        shutter: SHUTTER,
    });
    field.search = Search::default();
    scene
}

/// A field on a device.
pub(crate) struct Gpu<'a> {
    blobs: &'a Blobs,
    tracer: FieldTracer<'a>,
    work: Mutex<TraceWork>,
}

impl<'a> Gpu<'a> {
    pub(crate) fn new(device: &'a Device, blobs: &'a Blobs, options: TracerOptions) -> Self {
        Self {
            blobs,
            tracer: FieldTracer::upload(device, blobs, options).expect("the field fits"),
            work: Mutex::default(),
        }
    }

    /// The next field of a moving set in the same buffers.
    pub(crate) fn followed_by(mut self, blobs: &'a Blobs) -> (Self, TreeUpdate) {
        let update = self.tracer.update(blobs).expect("the field fits");
        self.blobs = blobs;
        (self, update)
    }

    /// The tree's words, and where the leaves begin.
    pub(crate) fn words(&self) -> (Vec<[u32; 4]>, usize) {
        self.tracer.words().expect("the device works")
    }

    pub(crate) fn work(&self) -> TraceWork {
        *self.work.lock().expect("no test panicked with it")
    }

    fn settle(&self, done: Result<TraceWork, GpuError>) {
        *self.work.lock().expect("no test panicked with it") += done.expect("the device works");
    }
}

impl Tracer for Gpu<'_> {
    fn closest(&self, ray: &Ray, scratch: &mut Scratch) -> Option<BlobHit> {
        self.closest_many(std::slice::from_ref(ray), scratch)[0]
    }

    fn occluded(&self, ray: &Ray, scratch: &mut Scratch) -> bool {
        self.occluded_many(std::slice::from_ref(ray), scratch)[0]
    }

    fn crossings(&self, ray: &Ray, scratch: &mut Scratch) -> Vec<Crossing> {
        self.crossings_many(std::slice::from_ref(ray), scratch)
            .remove(0)
    }

    fn closest_many(&self, rays: &[Ray], scratch: &mut Scratch) -> Vec<Option<BlobHit>> {
        let mut hits = vec![None; rays.len()];
        self.settle(
            self.tracer
                .closest_many(self.blobs, rays, &mut hits, scratch),
        );
        hits
    }

    fn occluded_many(&self, rays: &[Ray], scratch: &mut Scratch) -> Vec<bool> {
        let mut hits = vec![false; rays.len()];
        self.settle(
            self.tracer
                .occluded_many(self.blobs, rays, &mut hits, scratch),
        );
        hits
    }

    fn crossings_many(&self, rays: &[Ray], scratch: &mut Scratch) -> Vec<Vec<Crossing>> {
        let mut crossings = vec![Vec::new(); rays.len()];
        self.settle(
            self.tracer
                .crossings_many(self.blobs, rays, &mut crossings, scratch),
        );
        crossings
    }
}
