//! Random numbers, scattering and lights as the device's stages have them, against their CPU twins.

use super::picture::PictureRecord;
use super::programs::StagePrograms;
use super::sources::StageModule;
use crate::device::Device;
use crate::readback;
use crate::shader::WORKGROUP;
use crate::stage::dispatch;
use crate::test_device::device;
use glam::{DVec3, Vec3};
use meniscus::film::Region;
use meniscus::frame::{Environment, Frame, FrameSettings, Light};
use meniscus::kernel::Kernel;
use meniscus::math::ray::Side;
use meniscus::math::sampling::{PixelFilter, PixelSampler};
use meniscus::render::{SampleBlock, StagedPicture};
use meniscus::scene::camera::Camera;
use meniscus::scene::{Background, IntegratorKind, IntegratorSettings, Scene};
use meniscus::shade::{ShadeSettings, Shader};
use meniscus_testing::corpus;
use std::sync::Arc;

/// Questions of each test.
const COUNT: usize = 1 << 14;

/// Answers in the place of `Seen`, 12 words.
type Answer = [u32; 12];

const SAMPLING: &str = "
@compute @workgroup_size(WORKGROUP)
fn probe(@builtin(global_invocation_id) id: vec3u) {
    let asked = questions[id.x];
    let given = bitcast<vec3u>(asked.origin);
    let sampler = pixel_sampler(given.xy, given.z, asked.flags);
    let draw = asked.side_of;
    let one = draw_1d(sampler, draw);
    let two = draw_2d(sampler, draw);
    let many = draw_2d_of(sampler, draw, 37u, draw % 37u);
    seen[id.x] = Seen(vec3f(one, two), 0u, vec3f(many, 0.0), 0u, cosine_lobe(two), 0u);
}
";

const SCATTERING: &str = "
@compute @workgroup_size(WORKGROUP)
fn probe(@builtin(global_invocation_id) id: vec3u) {
    let asked = questions[id.x];
    let bsdf = bsdf_of(material_of(asked.side_of), 0.0, asked.direction_low.xy);
    let density = bsdf_density(bsdf, asked.origin, asked.direction);
    let sample = bsdf_sample(bsdf, asked.origin, asked.t_max, asked.origin_low.xy);
    let drawn = select(-1.0, sample.density, sample.is_there);
    seen[id.x] = Seen(
        bsdf_evaluate(bsdf, asked.origin, asked.direction), bitcast<u32>(density),
        sample.light, bitcast<u32>(drawn), sample.weight, 0u,
    );
}
";

const LIGHTS: &str = "
@compute @workgroup_size(WORKGROUP)
fn probe(@builtin(global_invocation_id) id: vec3u) {
    let asked = questions[id.x];
    let drawn = draw_light(asked.origin, asked.t_max, asked.origin_low.xy);
    let sample = drawn.sample;
    var all = vec3f(0.0);
    for (var i = 0u; i < picture.emitter_count; i++) {
        all += escaped(emitter_of(i), asked.direction);
    }
    let density = select(-1.0, sample.density, sample.is_there);
    seen[id.x] =
        Seen(sample.weight, bitcast<u32>(density), sample.towards, bitcast<u32>(sample.distance), all, 0u);
}
";

/// Numbers that look random, in [0, 1).
fn number(question: usize, which: u32) -> f32 {
    let mut sampler = PixelSampler::new([question as u32, which], 0, 7);
    sampler.next_1d() as f32
}

/// A question of 16 words.
fn question(origin: [u32; 4], low: [u32; 4], direction: [u32; 4], more: [u32; 4]) -> [u32; 16] {
    let mut record = [0; 16];
    for (row, given) in record
        .chunks_exact_mut(4)
        .zip([origin, low, direction, more])
    {
        row.copy_from_slice(&given);
    }
    record
}

fn bits(v: Vec3, w: u32) -> [u32; 4] {
    [v.x.to_bits(), v.y.to_bits(), v.z.to_bits(), w]
}

/// Asks an entry point that stands behind the sources of `path`.
fn ask(
    device: &Device,
    entry: &str,
    picture: &PictureRecord,
    questions: &[[u32; 16]],
) -> Vec<Answer> {
    use wgpu::BufferUsages as Usage;
    let wgpu = &device.device;
    let buffer = |size: usize, usage| {
        wgpu.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: size.max(128) as u64,
            usage,
            mapped_at_creation: false,
        })
    };
    let given = |bytes: &[u8], usage| {
        let made = buffer(bytes.len(), usage | Usage::COPY_DST);
        device.queue.write_buffer(&made, 0, bytes);
        made
    };
    let block = SampleBlock {
        region: Region::full(8, 8),
        samples: 0..1,
    };
    let record = picture.of(&block, 0, questions.len() as u32);
    let seen_bytes = questions.len() * 48;
    let buffers = [
        given(bytemuck::cast_slice(&record), Usage::UNIFORM),
        given(bytemuck::cast_slice(&picture.words), Usage::STORAGE),
        buffer(128, Usage::STORAGE),
        given(bytemuck::cast_slice(questions), Usage::STORAGE),
        buffer(128, Usage::STORAGE),
        buffer(seen_bytes, Usage::STORAGE | Usage::COPY_SRC),
        buffer(128, Usage::STORAGE),
        buffer(128, Usage::UNIFORM),
        buffer(128, Usage::STORAGE),
        buffer(128, Usage::STORAGE),
        buffer(128, Usage::STORAGE),
        buffer(128, Usage::STORAGE),
    ];
    let programs = StagePrograms::default();
    let common = programs.common(device);
    let text = StageModule::Integrator(IntegratorKind::Path).sources() + entry;
    let module = wgpu.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("probe"),
        source: wgpu::ShaderSource::Wgsl(text.into()),
    });
    let pipeline = common.bindings.pipeline(wgpu, &module, "probe");
    let group = common.bindings.group(wgpu, &buffers);
    let back = buffer(seen_bytes, Usage::MAP_READ | Usage::COPY_DST);
    let mut encoder = wgpu.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        let groups = questions.len() as u32 / WORKGROUP;
        dispatch(device, &mut pass, &pipeline, &group, groups);
    }
    encoder.copy_buffer_to_buffer(&buffers[5], 0, &back, 0, seen_bytes as u64);
    device.queue.submit([encoder.finish()]);
    readback::read(device, &back, seen_bytes as u64, |view| {
        bytemuck::cast_slice::<u8, Answer>(view).to_vec()
    })
    .expect("the device works")
}

/// A surface of every kind of look, and every kind of light.
fn frame() -> Frame {
    let mut text = "[[surface]]\nfile = \"set.npy\"\n".to_owned();
    for (i, material) in [
        "type = \"diffuse\"",
        "type = \"glossy\"\nroughness = 0.4",
        "type = \"plastic\"\nroughness = 0",
        "type = \"metal\"\nroughness = 0.3",
        "type = \"metal\"\nroughness = 0.05",
        "type = \"mirror\"",
        "type = \"glass\"",
        "type = \"glass\"\nroughness = 0.5",
        "type = \"foam\"\ntranslucency = 0.3",
    ]
    .iter()
    .enumerate()
    {
        text += &format!("[material.m{i}]\n{material}\n[[sphere]]\nmaterial = \"m{i}\"\n");
    }
    text += "
[[light]]
type = \"sun\"
direction = [1, 2, 1]
angle = 20
[[light]]
type = \"point\"
position = [1, 2, 3]
[[light]]
type = \"sphere\"
position = [-2, 1, 0]
radius = 0.5
[[light]]
type = \"rectangle\"
position = [0, 4, 0]
edges = [[1, 0, 0], [0, 0, 1]]
[[light]]
type = \"sky\"
";
    let scene: Scene = meniscus::scene::file::parse(&text, "test").expect("the scene is sound");
    let field = corpus::scene("pool", Kernel::Sextic, 50).field;
    let mut frame = Frame::build(&scene, vec![field], &FrameSettings::default()).expect("sound");
    let texels = (0..32 * 16).map(|i| [0.1 + 0.01 * (i % 37) as f32; 3]);
    let axes = [DVec3::X, DVec3::Y, DVec3::NEG_Z];
    frame.lights.push(Light::Environment {
        environment: Arc::new(Environment::new(32, texels.collect(), axes, 0.7)),
        scale: [1.0, 0.5, 0.25],
    });
    frame
}

fn shader(frame: &Frame) -> Shader<'_> {
    let settings = ShadeSettings {
        integrator: IntegratorSettings {
            kind: IntegratorKind::Path,
            ..IntegratorSettings::default()
        },
        background: Background::Sky,
        eye: DVec3::splat(9.0),
        ..ShadeSettings::default()
    };
    Shader::new(frame, &settings)
}

fn picture(shader: &Shader<'_>) -> (PictureRecord, DVec3) {
    let shading = shader.staged().expect("stages know all of it");
    let origin = shading.origin;
    let camera = Camera::new(DVec3::splat(9.0), DVec3::ZERO, DVec3::Y, 1.0, [8, 8]);
    let record = PictureRecord::new(&StagedPicture {
        shading,
        camera: camera.expect("it sees something"),
        filter: PixelFilter::default(),
        spp: 4,
        seed: 1,
        shutter_secs: [0.0; 2],
        eye_side: Side::Outside,
    });
    (record, origin)
}

#[test]
fn random_numbers_are_the_same_to_the_last_bit() {
    let Some(device) = device("random_numbers_are_the_same_to_the_last_bit") else {
        return;
    };
    let frame = frame();
    let shader = shader(&frame);
    let (picture, _) = picture(&shader);
    let of = |i: usize| {
        let i = i as u32;
        let sample = if i.is_multiple_of(5) {
            70_000 + i
        } else {
            i % 4096
        };
        ([i.wrapping_mul(77) % 4096, i / 3], sample, i % 13, i % 61)
    };
    let questions: Vec<_> = (0..COUNT)
        .map(|i| {
            let ([x, y], sample, seed, draw) = of(i);
            let direction = bits(Vec3::ZERO, draw);
            question([x, y, sample, 0], [0, 0, 0, seed], direction, [0; 4])
        })
        .collect();
    let answers = ask(&device, SAMPLING, &picture, &questions);
    for (i, answer) in answers.iter().enumerate() {
        let (pixel, sample, seed, draw) = of(i);
        let mut sampler = PixelSampler::new(pixel, sample, seed);
        let mut at = || {
            sampler.skip_to(draw);
            sampler
        };
        let one = at().next_1d() as f32;
        let two = at().next_2d().map(|u| u as f32);
        let of_many = at().next_2d_of(37).nth((draw % 37) as usize);
        let of_many = of_many.expect("there are 37").map(|u| u as f32);
        let found = |k: usize| f32::from_bits(answer[k]);
        assert_eq!([found(0), found(1), found(2)], [one, two[0], two[1]], "{i}");
        assert_eq!([found(4), found(5)], of_many, "{i}");
        let lobe = meniscus::math::sampling::cosine_hemisphere(DVec3::Z, at().next_2d());
        let off = DVec3::new(found(8).into(), found(9).into(), found(10).into()).distance(lobe);
        assert!(off < 1e-3, "{i}: {off}");
    }
}

/// How far numbers may be from each other: f32 against f64, where a small difference of large ones is not
/// the rule.
fn is_near(ours: f32, theirs: f64, scale: f64) -> bool {
    let theirs = theirs as f32;
    (f64::from(ours) - f64::from(theirs)).abs() <= 2e-3 * f64::from(theirs.abs()) + scale
}

#[test]
fn surfaces_scatter_as_on_the_cpu() {
    let Some(device) = device("surfaces_scatter_as_on_the_cpu") else {
        return;
    };
    let frame = frame();
    let shader = shader(&frame);
    let (picture, _) = picture(&shader);
    let surfaces = frame.instances.len() as u32;
    let of = |i: usize| {
        let direction = |which: u32, least: f32| {
            let z = least + (1.0 - least) * number(i, which);
            let angle = std::f32::consts::TAU * number(i, which + 1);
            let radius = (1.0 - z * z).max(0.0).sqrt();
            Vec3::new(radius * angle.cos(), radius * angle.sin(), z).normalize()
        };
        let surface = 1 + i as u32 % (surfaces - 1);
        let view = direction(0, 0.02);
        let mut light = direction(2, 0.02);
        if i.is_multiple_of(3) {
            light.z = -light.z;
        }
        let choice = number(i, 4);
        let u = [number(i, 5), number(i, 6)];
        let indices = if i.is_multiple_of(2) {
            [1.0, 1.5]
        } else {
            [1.5, 1.0]
        };
        (surface, view, light, choice, u, indices)
    };
    let questions: Vec<_> = (0..COUNT)
        .map(|i| {
            let (surface, view, light, choice, [u, v], [n, m]) = of(i);
            question(
                bits(view, choice.to_bits()),
                bits(Vec3::new(u, v, 0.0), 0),
                bits(light, surface),
                bits(Vec3::new(n, m, 0.0), 0),
            )
        })
        .collect();
    let answers = ask(&device, SCATTERING, &picture, &questions);
    let mut off = 0;
    for (i, answer) in answers.iter().enumerate() {
        let (surface, view, light, choice, u, indices) = of(i);
        let indices = indices.map(f64::from);
        let [view, light] = [view, light].map(Vec3::as_dvec3);
        let (value, density) = shader
            .scattered(surface, indices, [view, light])
            .expect("it is no sheet");
        let drawn =
            shader.draw_scattered(surface, indices, view, f64::from(choice), u.map(f64::from));
        let found = |k: usize| f32::from_bits(answer[k]);
        let mut is_same = (0..3).all(|k| is_near(found(k), f64::from(value[k]), 1e-5));
        is_same &= is_near(found(3), density, 1e-5);
        is_same &= match drawn {
            None => found(7) < 0.0,
            Some(drawn) => {
                let towards = DVec3::new(found(4).into(), found(5).into(), found(6).into());
                towards.distance(drawn.towards) < 1e-3
                    && (0..3).all(|k| is_near(found(8 + k), f64::from(drawn.weight[k]), 1e-4))
                    && (if drawn.density.is_infinite() {
                        found(7) > 1e38
                    } else {
                        // Sharp lobes are steep: a direction off by its rounding is elsewhere on them.
                        (f64::from(found(7)) / drawn.density - 1.0).abs() < 2e-2
                    })
            }
        };
        off += u32::from(!is_same);
    }
    // Where a random number lies next to a limit, one goes this way and one that.
    assert!(off * 2000 <= COUNT as u32, "{off} of {COUNT}");
}

#[test]
fn lights_are_drawn_as_on_the_cpu() {
    let Some(device) = device("lights_are_drawn_as_on_the_cpu") else {
        return;
    };
    let frame = frame();
    let shader = shader(&frame);
    let (picture, origin) = picture(&shader);
    let of = |i: usize| {
        let place = Vec3::new(number(i, 0), number(i, 1), number(i, 2)) * 2.0 - 1.0;
        let towards = Vec3::new(number(i, 3), number(i, 4), number(i, 5)) * 2.0 - 1.0;
        let choice = number(i, 6);
        (
            place,
            towards.normalize(),
            choice,
            [number(i, 7), number(i, 8)],
        )
    };
    let questions: Vec<_> = (0..COUNT)
        .map(|i| {
            let (place, towards, choice, [u, v]) = of(i);
            question(
                bits(place, choice.to_bits()),
                bits(Vec3::new(u, v, 0.0), 0),
                bits(towards, 0),
                [0; 4],
            )
        })
        .collect();
    let answers = ask(&device, LIGHTS, &picture, &questions);
    let mut off = 0;
    for (i, answer) in answers.iter().enumerate() {
        let (place, towards, choice, u) = of(i);
        let point = origin + place.as_dvec3();
        let drawn = shader.draw_light(point, f64::from(choice), u.map(f64::from));
        let all = shader.escaped(towards.as_dvec3());
        let found = |k: usize| f32::from_bits(answer[k]);
        let mut is_same = (0..3).all(|k| is_near(found(8 + k), f64::from(all[k]), 1e-5));
        is_same &= match drawn {
            None => found(3) < 0.0,
            Some(drawn) => {
                let way = DVec3::new(found(4).into(), found(5).into(), found(6).into());
                let is_far = |ours: f32, theirs: f64| {
                    theirs.is_infinite() && ours > 1e38 || is_near(ours, theirs, 1e-5)
                };
                way.distance(drawn.towards) < 1e-3
                    && (0..3).all(|k| is_near(found(k), f64::from(drawn.weight[k]), 1e-4))
                    && is_far(found(3), drawn.density)
                    && is_far(found(7), drawn.distance)
            }
        };
        off += u32::from(!is_same);
    }
    assert!(off * 500 <= COUNT as u32, "{off} of {COUNT}");
}
