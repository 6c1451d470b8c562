//! Stages of engine `peel` on fixed rays, against all balls looked at one by one in f64: tiles' lists lose no
//! ball that a ray meets and hold none that their tile excludes, kernel spheres end rays where they should,
//! and sprites are culled only where no ray sees them before.

use super::Clipping;
use super::balls::Balls;
use super::programs::Solve;
use super::room::{Own, Room, RoomKind};
use super::round::{self, Call};
use super::shader::tile;
use super::slots::{Eye, Seen, Slots};
use super::sprites;
use super::view::View;
use crate::device::Device;
use crate::readback;
use crate::test_device::device;
use glam::{DAffine3, DVec3};
use meniscus::accel::Engine;
use meniscus::frame::Blobs;
use meniscus::kernel::Kernel;
use meniscus::math::ray::Side;
use meniscus::math::simd::Level;
use meniscus::primitive::Shapes;
use meniscus::scene::camera::Camera;
use meniscus::scene::{EngineSettings, PeelVariant};
use meniscus_testing::corpus;
use std::collections::HashMap;

const SIZE: [u32; 2] = [40, 32];
const MOST_PAIRS: u32 = 1 << 16;
/// Rays lie this far from their pixels' centres at most.
const JITTER: f64 = 0.4;
/// Margin of films, in pixels, and relative ones of radii and distances, twice the shaders'.
const FILM: f64 = 0.05;
const RADIUS: f64 = 2e-5;
const DISTANCE: f64 = 1e-5;

/// What a device's stages left in its buffers.
struct Left {
    pairs: Vec<[u32; 2]>,
    starts: Vec<usize>,
    states: Vec<[u32; 8]>,
    seen: Vec<u32>,
}

/// One eye's rays of one field.
struct Round<'a> {
    blobs: &'a Blobs,
    radii: &'a [f32],
    eye: Eye,
    rays: Vec<Seen>,
    slots: Slots,
    side: u32,
    left: Left,
}

fn words(device: &Device, buffer: &wgpu::Buffer, count: usize) -> Vec<u32> {
    let bytes = 4 * count as u64;
    let back = device.device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: bytes,
        usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let mut encoder = device
        .device
        .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    encoder.copy_buffer_to_buffer(buffer, 0, &back, 0, bytes);
    device.queue.submit([encoder.finish()]);
    let read = |view: &[u8]| bytemuck::cast_slice::<u8, u32>(view).to_vec();
    readback::read(device, &back, bytes, read).expect("the device works")
}

fn triples<const N: usize>(words: &[u32]) -> Vec<[u32; N]> {
    let parts = words.chunks_exact(N);
    parts
        .map(|part| part.try_into().expect("N of them"))
        .collect()
}

impl<'a> Round<'a> {
    fn new(device: &Device, blobs: &'a Blobs, camera: &Camera) -> Self {
        let Shapes::Balls(radii) = &blobs.field.shapes else {
            panic!("the sets are balls");
        };
        let variant = blobs.settings.peel;
        let side = tile(variant);
        let balls = Balls::upload(device, blobs, radii, Clipping::Own).expect("it fits");
        let eye = Eye {
            view: View::new(camera, &DAffine3::IDENTITY),
            field_origin: blobs.field.origin,
            bounds: balls.bounds,
            side: blobs.field.side(camera.eye - blobs.field.origin),
        };
        let pixels = (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| [x, y]));
        let asked: Vec<_> = pixels
            .map(|[x, y]| {
                let turn = f64::from(x * 31 + y * 17);
                let off = [JITTER * turn.sin(), JITTER * (1.7 * turn).cos()];
                camera.ray([f64::from(x) + 0.5 + off[0], f64::from(y) + 0.5 + off[1]])
            })
            .collect();
        let (mut rays, mut others, mut later) = (Vec::new(), Vec::new(), Vec::new());
        eye.sort(&asked, &mut rays, &mut others);
        assert!(others.is_empty(), "all rays are the eye's");
        let kind = RoomKind {
            variant,
            slots: 64 * side * side,
            groups: 64,
            capacity: 64,
        };
        let slots = Slots::lay_out(&eye, &rays, side, kind.groups as usize, &mut later);
        assert!(later.is_empty(), "there is room for all rays");
        let mut room = Room::new(device, kind, MOST_PAIRS).expect("it fits");
        let readable = |words: u32| {
            device.device.create_buffer(&wgpu::BufferDescriptor {
                label: None,
                size: 4 * u64::from(words),
                usage: wgpu::BufferUsages::STORAGE
                    | wgpu::BufferUsages::COPY_SRC
                    | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        };
        room.pairs = readable(2 * MOST_PAIRS);
        if let Own::Sprites(layers) = &mut room.own {
            layers.states = readable(8 * kind.slots);
            layers.seen = readable(MOST_PAIRS);
        }
        let program = device.peel.programs.get(device, balls.kind);
        let call = Call {
            device,
            program: &program,
            balls: &balls,
            params: balls.params(&eye, &slots, &room),
            slots: &slots,
        };
        let mut encoder = round::begin(&mut room, &call).expect("the device works");
        if let Solve::Sprites(programs) = &program.solve {
            sprites::begin(&mut room, &call, programs, &mut encoder);
        }
        device.queue.submit([encoder.finish()]);
        let starts = words(device, &room.starts, slots.groups.len() + 1);
        let listed = *starts.last().expect("there is an end") as usize;
        assert!(
            listed > 0 && listed <= MOST_PAIRS as usize,
            "{listed} pairs"
        );
        let (states, seen) = match &room.own {
            Own::Sprites(layers) => (
                words(device, &layers.states, 8 * slots.records.len()),
                words(device, &layers.seen, listed),
            ),
            Own::Tiles { .. } => (Vec::new(), Vec::new()),
        };
        let left = Left {
            pairs: triples(&words(device, &room.pairs, 2 * listed)),
            starts: starts.iter().map(|&start| start as usize).collect(),
            states: triples(&states),
            seen,
        };
        Self {
            blobs,
            radii,
            eye,
            rays,
            slots,
            side,
            left,
        }
    }

    /// A ball's centre from the eye, and its radius.
    fn ball(&self, ball: usize) -> (DVec3, f64) {
        let center = self.blobs.field.center(ball).as_dvec3();
        let eye = self.eye.view.eye - self.eye.field_origin;
        (center - eye, f64::from(self.radii[ball]))
    }

    /// Pairs of a group.
    fn list(&self, group: usize) -> std::ops::Range<usize> {
        self.left.starts[group]..self.left.starts[group + 1]
    }

    /// Slots of a group that have rays, and these.
    fn slots_of(&self, group: usize) -> impl Iterator<Item = (usize, &Seen)> {
        let area = (self.side * self.side) as usize;
        let slots = group * area..(group + 1) * area;
        slots.filter_map(|slot| Some((slot, self.rays.get(self.slots.rays[slot])?)))
    }

    /// Where a sphere around a ball's centre is entered and left, from where the ray's clipped part
    /// begins, and how far inside the sphere it comes, in parts of its radius.
    fn along(&self, ray: &Seen, ball: usize, radius: f64) -> [f64; 3] {
        let (center, _) = self.ball(ball);
        let eye = self.eye.view.eye - self.eye.field_origin;
        let center = center + eye - ray.clipped.origin;
        let c = center.dot(ray.clipped.direction);
        let aside = (center - ray.clipped.direction * c).length() / radius;
        let half = radius * (1.0 - aside * aside).max(0.0).sqrt();
        [c - half, c + half, 1.0 - aside]
    }

    /// Whether a ball lies wholly outside the tile of a group, margins added to both.
    fn is_excluded(&self, group: usize, ball: usize) -> bool {
        let (center, radius) = self.ball(ball);
        let radius = radius * (1.0 + RADIUS) + DISTANCE * center.length();
        let map = self.eye.view.film_from_direction;
        let depth = map.row(2);
        let [x, y] = [0, 1].map(|axis| {
            let tile = self.slots.grid_at[axis] + self.slots.groups[group][axis] as i32;
            f64::from(tile * self.side as i32)
        });
        let margin = FILM + self.slots.jitter;
        let planes = [
            map.row(0) - depth * (x - margin),
            map.row(1) - depth * (y - margin),
            depth * (x + f64::from(self.side) + margin) - map.row(0),
            depth * (y + f64::from(self.side) + margin) - map.row(1),
        ];
        let reach = |plane: DVec3| plane.dot(center) + radius * plane.length();
        // Balls next to the plane through the eye are seen all over the film.
        let is_before = depth.dot(center) > 1.01 * radius * depth.length();
        reach(depth) < 0.0 || is_before && planes.into_iter().any(|plane| reach(plane) < 0.0)
    }

    /// Checks the tiles' lists; how many pairs there are, and how many are left out.
    fn check_lists(&self, what: &str) -> [usize; 2] {
        let balls = self.radii.len();
        for group in 0..self.slots.groups.len() {
            let listed: HashMap<usize, f32> = (self.left.pairs[self.list(group)].iter())
                .map(|&[nearest, ball]| (ball as usize, f32::from_bits(nearest)))
                .collect();
            assert_eq!(
                listed.len(),
                self.list(group).len(),
                "{what}: one pair per ball"
            );
            for (_, ray) in self.slots_of(group) {
                for ball in 0..balls {
                    let [_, leave, inside] = self.along(ray, ball, f64::from(self.radii[ball]));
                    let is_met = inside > 1e-6 && leave > 0.0;
                    assert!(!is_met || listed.contains_key(&ball), "{what} lost {ball}");
                }
            }
            for (&ball, &nearest) in &listed {
                assert!(!self.is_excluded(group, ball), "{what} lists {ball}");
                let (center, radius) = self.ball(ball);
                let distance = center.length();
                let exact = (distance - radius).max(0.0);
                let least = exact - RADIUS * radius - DISTANCE * distance;
                let nearest = f64::from(nearest);
                assert!(
                    nearest <= exact && nearest >= least,
                    "{what}: {nearest}, not {exact}"
                );
            }
            let sorted = self.left.pairs[self.list(group)]
                .windows(2)
                .all(|w| w[0] < w[1]);
            assert!(sorted, "{what}: the list of {group} is out of order");
        }
        [
            self.left.pairs.len(),
            balls * self.slots.groups.len() - self.left.pairs.len(),
        ]
    }

    /// Where a ray certainly meets a ball that is solid by itself, and whether that is clear.
    fn kernel_sphere(&self, ray: &Seen) -> (Option<f64>, bool) {
        let field = &self.blobs.field;
        let (mut end, mut is_clear) = (None::<f64>, true);
        if field.has_negative_weights() || self.eye.side == Side::Inside {
            return (end, is_clear);
        }
        for ball in 0..self.radii.len() {
            let level = f64::from(field.threshold) / f64::from(field.weights[ball]);
            let Some(q) = field.kernel.q_at(level) else {
                continue;
            };
            let radius = f64::from(self.radii[ball]) * q.sqrt();
            let [enter, _, inside] = self.along(ray, ball, radius);
            let length = f64::from(ray.clipped.length);
            is_clear &= inside.abs() > 1e-4 && enter.abs() > 1e-4 * radius;
            if inside > 0.0 && enter > 0.0 && enter < length {
                end = Some(end.map_or(enter, |end| end.min(enter)));
            }
        }
        (end, is_clear)
    }

    /// Checks how far rays look and which sprites are culled; how many rays end at kernel spheres, and how
    /// many sprites are culled.
    fn check_sprites(&self, what: &str) -> [usize; 2] {
        let mut ended = 0;
        let near = 1e-3 * f64::from(self.blobs.field.spacing);
        for group in 0..self.slots.groups.len() {
            for (slot, ray) in self.slots_of(group) {
                let (end, is_clear) = self.kernel_sphere(ray);
                let state = self.left.states[slot];
                let found = f64::from(f32::from_bits(state[3]));
                let expected = end.unwrap_or(f64::from(ray.clipped.length));
                ended += usize::from(end.is_some());
                if is_clear {
                    assert!(
                        (found - expected).abs() < near,
                        "{what}: {found}, not {expected}"
                    );
                    assert_eq!(state[6] != 0, end.is_some(), "{what}");
                }
            }
            for pair in self.list(group) {
                let ball = self.left.pairs[pair][1] as usize;
                let (mut must, mut may) = (false, false);
                for (slot, ray) in self.slots_of(group) {
                    let [enter, leave, inside] = self.along(ray, ball, f64::from(self.radii[ball]));
                    let end = f64::from(f32::from_bits(self.left.states[slot][3]));
                    must |= inside > 1e-5 && leave > near && enter < end - near;
                    may |= inside > -1e-5 && leave > -near && enter < end + near;
                }
                let is_seen = self.left.seen[pair] != 0;
                assert!(!must || is_seen, "{what}: {ball} is culled");
                assert!(may || !is_seen, "{what}: {ball} is not culled");
            }
        }
        [
            ended,
            self.left.seen.iter().filter(|&&seen| seen == 0).count(),
        ]
    }
}

#[test]
fn lists_and_culling_lose_nothing_and_hold_nothing_else() {
    let Some(device) = device("lists_and_culling_lose_nothing_and_hold_nothing_else") else {
        return;
    };
    let mut sums = [0; 4];
    for kind in ["scattered", "pool", "mixed", "negative"] {
        for peel in [PeelVariant::Tiles, PeelVariant::Sprites] {
            let field = corpus::scene(kind, Kernel::Wyvill, 400).field;
            let settings = EngineSettings {
                peel,
                ..EngineSettings::default()
            };
            let blobs = Blobs::build_with(field, Engine::Particles, settings, Level::new());
            let bounds = blobs.field.bounds();
            let [min, max] = [bounds.min, bounds.max].map(|corner| corner.as_dvec3());
            let middle = blobs.field.origin + 0.5 * (min + max);
            let size = (max - min).length();
            let away = DVec3::new(0.3, 0.5, 1.0).normalize();
            // From outside, from near, from among the balls.
            for (far, fov) in [(1.2, 45_f64), (0.4, 100.0), (0.1, 90.0)] {
                let eye = middle + away * far * size;
                let camera = Camera::new(eye, middle, DVec3::Y, fov.to_radians(), SIZE);
                let round = Round::new(&device, &blobs, &camera.expect("a camera"));
                let what = format!("{kind} {peel:?} from {far}");
                let [listed, left_out] = round.check_lists(&what);
                sums[0] += listed;
                sums[1] += left_out;
                if peel == PeelVariant::Sprites {
                    let [ended, culled] = round.check_sprites(&what);
                    sums[2] += ended;
                    sums[3] += culled;
                }
            }
        }
    }
    // There was something to find, to leave out, to end and to cull.
    assert!(sums.iter().all(|&sum| sum > 1000), "{sums:?}");
}
