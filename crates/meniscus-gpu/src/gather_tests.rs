//! The stage that gathers what reaches a stretch of a ray, on fixed rays, against all blobs looked at one by
//! one in f64: none that reaches the stretch is lost, none is listed that does not.

use crate::device::Device;
use crate::readback;
use crate::shader::{WORKGROUP, sources};
use crate::stage::dispatch;
use crate::test_device::device;
use crate::tracer::{FieldTracer, TracerOptions};
use crate::uploaded::{CAPACITIES, Uploaded};
use glam::DVec3;
use meniscus::accel::Engine;
use meniscus::accel::particles::layout::columns;
use meniscus::field::{BlobField, Motion, Search};
use meniscus::frame::Blobs;
use meniscus::intersect::ClippedRay;
use meniscus::kernel::Kernel;
use meniscus::math::ray::Ray;
use meniscus::math::simd::Level;
use meniscus::primitive::{Ball, Ellipsoid, Shapes};
use meniscus::scene::{Builder, EngineSettings};
use meniscus_testing::corpus;
use std::collections::BTreeSet;

/// Gathers one stretch from a quarter, a half or three quarters of the ray on, or from its start.
const ENTRY: &str = "
@compute @workgroup_size(WORKGROUP)
fn gathered(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let index = number_of(group, groups, lane);
    ray = rays[index];
    first_met = (index - lane) * params.capacity + lane;
    prepare();
    let from_at = 0.25 * f32(index & 3u) * ray.length;
    gather(from_at, params.longest);
    if trouble == MISS {
        drop_what_is_beyond(from_at);
    }
    hits[index] = HitRecord(trouble, stretch_start, stretch_end, count, vec3f(from_at, 0.0, 0.0), 0u);
}
";

const RAYS: usize = 256;
/// 1 − q where f32 may see a blob on either side of its support.
const UNSURE: f64 = 1e-3;

/// What one ray gathered.
struct Gathered {
    trouble: u32,
    start: f64,
    end: f64,
    from: f64,
    blobs: BTreeSet<usize>,
}

fn ask(
    device: &Device,
    uploaded: &Uploaded,
    (words, index_column): (&[[u32; 4]], usize),
    rays: &[(Ray, ClippedRay)],
    capacity: u32,
) -> Vec<Gathered> {
    use wgpu::BufferUsages as Usage;
    let program = uploaded.program(device);
    let wgpu = &device.device;
    let module = wgpu.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("gathered"),
        source: wgpu::ShaderSource::Wgsl((sources(&uploaded.kind()) + ENTRY).into()),
    });
    let pipeline = program.bindings.pipeline(wgpu, &module, "gathered");
    let buffer = |size: usize, usage| {
        wgpu.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: size as u64,
            usage: usage | Usage::COPY_DST,
            mapped_at_creation: false,
        })
    };
    let listed = RAYS * capacity as usize;
    let sent = buffer(RAYS * 64, Usage::STORAGE);
    let hits = buffer(RAYS * 32, Usage::STORAGE | Usage::COPY_SRC);
    let met = buffer(listed * 16, Usage::STORAGE);
    let met_words = buffer(listed * 4, Usage::STORAGE | Usage::COPY_SRC);
    let back = buffer(RAYS * 32 + listed * 4, Usage::MAP_READ);
    let mut numbers = uploaded.params();
    let params = buffer(size_of_val(&numbers), Usage::UNIFORM);
    numbers[5] = RAYS as u32;
    numbers[7] = capacity;
    let records: Vec<_> = (rays.iter())
        .map(|(ray, clipped)| uploaded.record(ray, clipped))
        .collect();
    device
        .queue
        .write_buffer(&params, 0, bytemuck::cast_slice(&numbers));
    device
        .queue
        .write_buffer(&sent, 0, bytemuck::cast_slice(&records));
    let group = uploaded.bound(device, &program, [&params, &sent, &hits, &met, &met_words]);
    let mut encoder = wgpu.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        let groups = RAYS as u32 / WORKGROUP;
        dispatch(device, &mut pass, &pipeline, &group, groups);
    }
    encoder.copy_buffer_to_buffer(&hits, 0, &back, 0, (RAYS * 32) as u64);
    let at = (RAYS * 32) as u64;
    encoder.copy_buffer_to_buffer(&met_words, 0, &back, at, (listed * 4) as u64);
    device.queue.submit([encoder.finish()]);
    let all = readback::read(device, &back, at + (listed * 4) as u64, |view| {
        bytemuck::cast_slice::<u8, u32>(view).to_vec()
    });
    let all = all.expect("the device works");
    let (hits, met_words) = all.split_at(RAYS * 8);
    let lanes = WORKGROUP as usize;
    (hits.chunks_exact(8).enumerate())
        .map(|(ray, hit)| {
            let first = (ray - ray % lanes) * capacity as usize + ray % lanes;
            let number = |i: usize| f64::from(f32::from_bits(hit[i]));
            let blob = |i: usize| {
                let word = met_words[first + i * lanes] as usize;
                words[word + index_column / 4][index_column % 4] as usize
            };
            Gathered {
                trouble: hit[0],
                start: number(1),
                end: number(2),
                from: number(4),
                blobs: (0..hit[3] as usize).map(blob).collect(),
            }
        })
        .collect()
}

/// Rays through the box of a field, at some times of its shutter.
fn rays(field: &BlobField, uploaded: &Uploaded) -> Vec<(Ray, ClippedRay)> {
    let bounds = uploaded.bounds();
    let [min, size] = [bounds.min, bounds.max - bounds.min].map(|v| v.as_dvec3());
    let [open, close] = uploaded.shutter_secs();
    let mut all = Vec::new();
    for i in 0.. {
        let turn = |k: f64| 0.5 + 0.5 * (k * f64::from(i)).sin();
        let place =
            |k: f64| field.origin + min + size * DVec3::new(turn(k), turn(1.7 * k), turn(2.3 * k));
        let (from, to) = (place(1.3), place(0.6));
        let back = if i % 2 == 0 { 0.0 } else { size.length() };
        let direction = (to - from).normalize_or(DVec3::X);
        let mut ray = Ray::new(from - direction * back, direction);
        ray.time = open + (close - open) * turn(0.9);
        all.extend(uploaded.clip(&ray).map(|clipped| (ray, clipped)));
        if all.len() == RAYS {
            break;
        }
    }
    all
}

/// c, β, g₀ of a blob along a clipped ray.
fn along(field: &BlobField, blob: usize, (ray, clipped): &(Ray, ClippedRay)) -> [f64; 3] {
    let field = field.at(ray.time);
    let y = field.transform(blob, clipped.origin - field.center(blob));
    let v = field.transform(blob, clipped.direction);
    let beta = v.length_squared();
    let c = -y.dot(v) / beta;
    [c, beta, 1.0 - (y + v * c).length_squared()]
}

/// How many rays gathered, and how many had a full list on their way.
fn check(device: &Device, name: &str, field: BlobField, capacity: u32) -> [usize; 2] {
    let settings = EngineSettings {
        builder: Builder::Sah,
        ..EngineSettings::default()
    };
    let blobs = Blobs::build_with(field, Engine::Particles, settings, Level::new());
    let field = &blobs.field;
    let tracer = FieldTracer::upload(device, &blobs, TracerOptions::default()).expect("it fits");
    let uploaded = tracer.uploaded().expect("there are blobs");
    let (words, _) = tracer.words().expect("the device works");
    let index_column = match field.shapes {
        Shapes::Balls(_) => columns::<Ball>() - 1,
        Shapes::Ellipsoids(_) => columns::<Ellipsoid>() - 1,
    };
    let rays = rays(field, uploaded);
    let lists = ask(device, uploaded, (&words, index_column), &rays, capacity);
    let longest = f64::from(f32::from_bits(uploaded.params()[4]));
    let close = 1e-4 * longest;
    let mut counts = [0; 2];
    for (ray, list) in rays.iter().zip(&lists) {
        if list.trouble != 0 {
            continue;
        }
        let Gathered {
            start, end, from, ..
        } = *list;
        let what = format!("{name}, {ray:?}: {start}..{end} from {from}");
        counts[0] += 1;
        let length = f64::from(ray.1.length);
        assert!(
            start >= from && end <= length && end <= start + longest + close,
            "{what}"
        );
        let is_near = end < length.min(start + longest) - close;
        counts[1] += usize::from(is_near);
        // Only full lists drive the end nearer.
        assert!(!is_near || capacity < CAPACITIES[0], "{what}");
        for blob in 0..field.len() {
            let [c, beta, g0] = along(field, blob, ray);
            let g_within = |from: f64, to: f64| {
                let away = c.clamp(from, to.max(from)) - c;
                g0 - beta * away * away
            };
            let is_listed = list.blobs.contains(&blob);
            let g = g_within(from, end);
            assert!(is_listed || g < UNSURE, "{what} lost {blob} ({g})");
            assert!(!is_listed || g > -UNSURE, "{what} lists {blob} ({g})");
            // And the stretch begins with the first.
            let before = g_within(from, start - close);
            assert!(
                start - close <= from || before < UNSURE,
                "{what} begins behind {blob} ({before})"
            );
        }
    }
    counts
}

fn moving(mut field: BlobField) -> BlobField {
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
        shutter: [-0.3, 0.7],
    });
    field.search = Search::default();
    field
}

#[test]
fn stretches_hold_all_that_reaches_them_and_nothing_else() {
    let Some(device) = device("stretches_hold_all_that_reaches_them_and_nothing_else") else {
        return;
    };
    for kind in ["scattered", "pool", "mixed", "ellipsoids", "negative"] {
        let field = corpus::scene(kind, Kernel::Sextic, 400).field;
        let [gathered, _] = check(&device, kind, field.clone(), CAPACITIES[0]);
        assert!(gathered * 2 > RAYS, "{kind}: {gathered} rays gathered");
        let [gathered, _] = check(&device, kind, moving(field.clone()), CAPACITIES[0]);
        assert!(
            gathered * 2 > RAYS,
            "{kind}, moving: {gathered} rays gathered"
        );
    }
    // Little room: lists are full, and ends come nearer.
    let mut sums = [0; 2];
    for kind in ["pool", "mixed", "ellipsoids"] {
        let field = corpus::scene(kind, Kernel::Sextic, 400).field;
        let counts = check(&device, kind, field, 8);
        for (sum, count) in sums.iter_mut().zip(counts) {
            *sum += count;
        }
    }
    let [gathered, full] = sums;
    assert!(
        gathered > 50 && full > 20,
        "{full} of {gathered} lists were full"
    );
}
