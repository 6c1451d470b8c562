//! The arithmetic of leaves as the device does it, against the CPU's twins at fixed points: kernels,
//! blobs along a line, metrics.

use crate::batch::{HitRecord, RayRecord};
use crate::chunks::{Chunks, Word};
use crate::device::Device;
use crate::pack::{blob_words, pack};
use crate::readback;
use crate::shader::{FieldMotion, ShaderKind, WORKGROUP, sources};
use crate::stage::dispatch;
use crate::test_device::device;
use crate::tracer::TracerOptions;
use meniscus::accel::particles::ParticleTree;
use meniscus::kernel::{Kernel, KernelShape, Octic, Quartic, Sextic, Wyvill};
use meniscus::primitive::{Ball, Ellipsoid, Primitive, Shapes};
use meniscus::scene::Builder;
use meniscus_testing::corpus;

/// Asks the leaf's functions instead of tracing: blob `length` of the first leaf, g in the time.
const ENTRY: &str = "
@compute @workgroup_size(WORKGROUP)
fn leaf_math(@builtin(global_invocation_id) id: vec3u) {
    ray = rays[id.x];
    let at = params.leaves_at + LEAF_HEADER_WORDS + u32(ray.length) * BLOB_WORDS;
    let head = heap(at);
    let g = ray.since_middle_secs;
    let line = blob_along(at, head, ray.origin, ray.direction);
    let y = blob_transform(at, head, ray.origin);
    hits[id.x] = HitRecord(
        bitcast<u32>(kernel_of_g(vec4f(g)).x), line.c, line.beta, bitcast<u32>(line.g0),
        blob_transform_transposed(at, head, y), bitcast<u32>(kernel_slope(g)),
    );
}
";

/// Half the distance of numbers next to 1.
const UNIT: f32 = f32::EPSILON / 2.0;

/// What may differ, in units of the last place of what went in: a handful of roundings.
const UNITS: f32 = 16.0;

const RAYS: usize = 256;

/// What one ray asks.
struct Question {
    w: [f32; 3],
    d: [f32; 3],
    g: f32,
    blob: usize,
}

impl Question {
    fn new(i: usize, blobs: usize) -> Self {
        let turn = |k: f32| (k * i as f32).sin();
        let d = glam::Vec3::new(turn(1.3), turn(2.1) + 0.01, turn(0.7)).normalize();
        Self {
            w: [turn(0.9), turn(1.7), turn(2.9)].map(|x| 0.1 * x),
            d: d.to_array(),
            g: i as f32 / (RAYS - 1) as f32,
            blob: i % blobs,
        }
    }

    fn record(&self) -> RayRecord {
        let mut record = [0; 16];
        record[..3].copy_from_slice(&self.w.map(f32::to_bits));
        record[3] = (self.blob as f32).to_bits();
        record[8..11].copy_from_slice(&self.d.map(f32::to_bits));
        record[11] = self.g.to_bits();
        record
    }
}

fn ask(
    device: &Device,
    kind: &ShaderKind,
    leaves_at: u32,
    words: &[Word],
    questions: &[Question],
) -> Vec<HitRecord> {
    let program = device.programs.get(device, *kind);
    let wgpu = &device.device;
    let module = wgpu.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("leaf math"),
        source: wgpu::ShaderSource::Wgsl((sources(kind) + ENTRY).into()),
    });
    let pipeline = program.bindings.pipeline(wgpu, &module, "leaf_math");
    let field = Chunks::new(device, words.len(), 4, TracerOptions::default()).expect("it fits");
    field.write(device, words).expect("the device works");
    use wgpu::BufferUsages as Usage;
    let buffer = |size: usize, usage| {
        wgpu.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: size as u64,
            usage: usage | Usage::COPY_DST,
            mapped_at_creation: false,
        })
    };
    let params = buffer(48, Usage::UNIFORM);
    let rays = buffer(RAYS * 64, Usage::STORAGE);
    let hits = buffer(RAYS * 32, Usage::STORAGE | Usage::COPY_SRC);
    let lists = [(); 2].map(|()| buffer(16, Usage::STORAGE));
    let back = buffer(RAYS * 32, Usage::MAP_READ);
    let mut numbers = [0_u32; 12];
    numbers[6] = leaves_at;
    let records: Vec<RayRecord> = questions.iter().map(Question::record).collect();
    device
        .queue
        .write_buffer(&params, 0, bytemuck::cast_slice(&numbers));
    device
        .queue
        .write_buffer(&rays, 0, bytemuck::cast_slice(&records));
    let buffers = [&params, &rays, &hits, &lists[0], &lists[1]];
    let group = program
        .bindings
        .group(wgpu, buffers.into_iter().chain(&field.buffers));
    let mut encoder = wgpu.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        dispatch(
            device,
            &mut pass,
            &pipeline,
            &group,
            RAYS as u32 / WORKGROUP,
        );
    }
    encoder.copy_buffer_to_buffer(&hits, 0, &back, 0, (RAYS * 32) as u64);
    device.queue.submit([encoder.finish()]);
    readback::read(device, &back, (RAYS * 32) as u64, |view| {
        bytemuck::cast_slice::<u8, HitRecord>(view).to_vec()
    })
    .expect("the device works")
}

fn check<K: KernelShape, P: Primitive>(device: &Device, kernel: Kernel, set: &str) {
    let scene = corpus::scene(set, kernel, 60);
    let field = scene.field;
    let tree = ParticleTree::build(&field, Builder::Morton);
    let packed = pack(&field, &tree).expect("it is small");
    let kind = ShaderKind {
        kernel,
        ellipsoids: matches!(field.shapes, Shapes::Ellipsoids(_)),
        motion: FieldMotion::Still,
        chunks: 1,
        chunk_bits: 23,
        stack: 64,
    };
    let first = packed.leaves_at as usize;
    let blobs = packed.words[first][3] as usize;
    let questions: Vec<Question> = (0..RAYS).map(|i| Question::new(i, blobs)).collect();
    let answers = ask(device, &kind, packed.leaves_at, &packed.words, &questions);
    for (question, answer) in questions.iter().zip(answers) {
        let Question { w, d, g, blob } = *question;
        let head = first + 2 + blob * blob_words::<P>(FieldMotion::Still);
        let mut columns = [0.0_f32; 6];
        for (k, column) in columns[..P::COLUMNS].iter_mut().enumerate() {
            // Behind the place.
            let at = 3 + k;
            *column = f32::from_bits(packed.words[head + at / 4][at % 4]);
        }
        let columns = &columns[..P::COLUMNS];
        let line = P::along(columns, w, d);
        let y = P::transform(columns, w);
        let z = P::transform_transposed(columns, y);
        let size = glam::Vec3::from(w).length();
        let steepest = columns.iter().map(|a| a * a).sum::<f32>();
        let number = |i: usize| f32::from_bits(answer[i]);
        // What is compared, what is expected, how large what went in was.
        let pairs = [
            ("k", number(0), K::of_g(g), 1.0),
            ("dk/dg", number(7), K::slope(g), 4.0),
            ("c", number(1), line.c, size * steepest / line.beta),
            ("beta", number(2), line.beta, steepest),
            ("g0", number(3), line.g0, 1.0 + steepest * size * size),
            ("x", number(4), z[0], steepest * size),
            ("y", number(5), z[1], steepest * size),
            ("z", number(6), z[2], steepest * size),
        ];
        for (name, ours, theirs, scale) in pairs {
            let off = (ours - theirs).abs();
            assert!(
                off <= UNITS * UNIT * scale,
                "{kernel:?} {set} {name}: {ours}, not {theirs}, of {scale}"
            );
        }
    }
}

#[test]
fn leaves_reckon_as_on_the_cpu() {
    let Some(device) = device("leaves_reckon_as_on_the_cpu") else {
        return;
    };
    check::<Quartic, Ball>(&device, Kernel::Quartic, "pool");
    check::<Sextic, Ellipsoid>(&device, Kernel::Sextic, "ellipsoids");
    check::<Octic, Ball>(&device, Kernel::Octic, "mixed");
    check::<Wyvill, Ellipsoid>(&device, Kernel::Wyvill, "ellipsoids");
}
