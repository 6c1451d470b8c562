//! Trees that are built where they are walked: blobs sorted along a Hilbert curve, sixteen to a leaf,
//! eight to a node, all full. Twin of `accel/particles` with builder `morton`, but for the curve and the
//! shape: where both are known from the number of blobs alone, a level is one dispatch, nothing is
//! counted or linked, and the host learns no more than the box around everything.

mod blobs;
mod levels;
mod program;
mod sort;

pub(crate) use program::Builders;

use crate::chunks::{Chunks, Word};
use crate::device::Device;
use crate::error::GpuError;
use crate::readback::{self, Clock, TIME_BYTES};
use crate::shader::{BuildKind, FieldMotion, WORKGROUP};
use crate::stage::dispatch;
use crate::tracer::TracerOptions;
use crate::uploaded::Placed;
use blobs::{RawBlobs, raw_words};
use glam::Vec3;
use levels::Levels;
use meniscus::accel::cells::layout::LANES;
use meniscus::accel::particles::{FINEST_PART, Measures, WORN};
use meniscus::field::BlobField;
use meniscus::math::aabb::Aabb;
use meniscus::primitive::Shapes;
use program::Builder;
use sort::Sorting;
use std::sync::Arc;

/// Bits per axis of a place on the curve.
const CURVE_BITS: u32 = 19;

/// Storage buffers of a leaf's step beside blobs and tree.
const LEAF_BUFFERS: u32 = 2;

/// Bytes of a vec4.
const CORNER_BYTES: u64 = 16;

/// A tree on a device, and what it is built from.
#[derive(Debug)]
pub(crate) struct BuiltTree {
    kind: BuildKind,
    builder: Arc<Builder>,
    blobs: u32,
    levels: Levels,
    raw: Chunks,
    sorting: Sorting,
    boxes: wgpu::Buffer,
    back: wgpu::Buffer,
    clock: Option<Clock>,
    curve_params: wgpu::Buffer,
    leaves_params: wgpu::Buffer,
    curve: wgpu::BindGroup,
    leaves: wgpu::BindGroup,
    /// With the number of nodes, from the lowest level to the root.
    nodes: Vec<(wgpu::BindGroup, u32)>,
    /// When it was built.
    cost_when_built: f32,
}

/// What a build or a refit has come to.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Fitted {
    /// Box around all supports while the shutter is open.
    pub(crate) bounds: Aabb,
    /// Mean radius of the supports.
    pub(crate) typical_support: f32,
    /// Boxes that a ray that meets `bounds` meets, by the surface area heuristic.
    cost: f32,
    /// The device's own time in seconds; 0 where it keeps none.
    pub(crate) device_secs: f64,
}

/// A few numbers that all invocations share.
fn uniform(device: &Device, numbers: [u32; 8]) -> wgpu::Buffer {
    let buffer = device.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("numbers"),
        size: size_of_val(&numbers) as u64,
        usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    device
        .queue
        .write_buffer(&buffer, 0, bytemuck::cast_slice(&numbers));
    buffer
}

/// Whether a device can build the tree of these blobs: its keys have to fit into one buffer each, and boxes
/// of shapes that turn are the processor's.
pub(crate) fn can_build(device: &Device, field: &BlobField) -> bool {
    let count = u32::try_from(field.len()).unwrap_or(u32::MAX);
    let bindings = device.limits.max_storage_buffers_per_shader_stage;
    sort::fits(count, device.largest_binding())
        && bindings >= sort::BUFFERS
        && FieldMotion::of(field) != FieldMotion::Turns
}

impl BuiltTree {
    /// Buffers for the tree of `field`, which has blobs, and the words of the tree itself: nothing is in
    /// them yet.
    pub(crate) fn new(
        device: &Device,
        field: &BlobField,
        options: TracerOptions,
    ) -> Result<(Self, Placed), GpuError> {
        let count = field.len() as u32;
        let levels = Levels::over(count);
        let motion = FieldMotion::of(field);
        let moves = motion.moves();
        let mut kind = BuildKind {
            ellipsoids: matches!(field.shapes, Shapes::Ellipsoids(_)),
            moves,
            raw_chunks: 1,
            tree_chunks: 1,
            chunk_bits: 0,
        };
        let raw = Chunks::new(
            device,
            raw_words(field) * field.len(),
            LEAF_BUFFERS + 1,
            options,
        )?;
        kind.raw_chunks = raw.buffers.len() as u32;
        let leaves_at = levels.nodes() as usize * crate::pack::node_words(moves);
        let leaf_words = match field.shapes {
            Shapes::Balls(_) => crate::pack::leaf_words::<meniscus::primitive::Ball>(motion),
            Shapes::Ellipsoids(_) => {
                crate::pack::leaf_words::<meniscus::primitive::Ellipsoid>(motion)
            }
        };
        let words = leaves_at + levels.leaves as usize * leaf_words;
        let tree = Chunks::new(device, words, LEAF_BUFFERS + kind.raw_chunks, options)?;
        kind.tree_chunks = tree.buffers.len() as u32;
        kind.chunk_bits = tree.bits;
        let builder = device.builders.get(device, kind);

        let box_bytes = u64::from(kind.box_words()) * CORNER_BYTES;
        let bytes = u64::from(levels.boxes()) * box_bytes;
        use wgpu::BufferUsages as Usage;
        let buffer = |label, size, usage| {
            device.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size,
                usage,
                mapped_at_creation: false,
            })
        };
        let (boxes, back, sorting) = device.within_memory(bytes, || {
            (
                buffer("boxes", bytes, Usage::STORAGE | Usage::COPY_SRC),
                buffer(
                    "back",
                    box_bytes + TIME_BYTES,
                    Usage::MAP_READ | Usage::COPY_DST,
                ),
                Sorting::new(device, &builder.sort, count),
            )
        })?;
        let curve_params = uniform(device, [0; 8]);
        let leaves_params = uniform(device, [0; 8]);
        let curve = builder.curve.bindings.group(
            &device.device,
            [&curve_params, &sorting.keys, &sorting.values]
                .into_iter()
                .chain(&raw.buffers),
        );
        let leaves = builder.leaves.bindings.group(
            &device.device,
            [&leaves_params, &sorting.values, &boxes]
                .into_iter()
                .chain(&raw.buffers)
                .chain(&tree.buffers),
        );
        let nodes = levels.iter().map(|level| {
            let params = uniform(
                device,
                [
                    level.count,
                    level.first,
                    level.below,
                    level.below_reference,
                    level.below_boxes,
                    level.boxes_at,
                    0,
                    0,
                ],
            );
            let buffers = [&params, &boxes].into_iter().chain(&tree.buffers);
            let group = builder.nodes.bindings.group(&device.device, buffers);
            (group, level.count)
        });
        let nodes = nodes.collect();
        let placed = Placed {
            leaves_at: leaves_at as u32,
            stack: levels.most_waiting(),
            chunks: tree,
        };
        let tree = Self {
            kind,
            builder,
            blobs: count,
            levels,
            raw,
            sorting,
            boxes,
            back,
            clock: Clock::new(device),
            curve_params,
            leaves_params,
            curve,
            leaves,
            nodes,
            cost_when_built: 0.0,
        };
        Ok((tree, placed))
    }

    /// Memory taken beside the tree itself.
    pub(crate) fn bytes(&self) -> u64 {
        self.raw.bytes() + self.sorting.bytes() + self.boxes.size()
    }

    /// Whether a field can take this one's place.
    pub(crate) fn suits(&self, field: &BlobField) -> bool {
        field.len() as u64 == u64::from(self.blobs)
            && FieldMotion::of(field) != FieldMotion::Turns
            && field.motion.is_some() == self.kind.moves
            && matches!(field.shapes, Shapes::Ellipsoids(_)) == self.kind.ellipsoids
    }

    /// Builds the tree of `field`.
    pub(crate) fn build(
        &mut self,
        device: &Device,
        field: &BlobField,
        placed: &Placed,
    ) -> Result<Fitted, GpuError> {
        let measures = self.send(device, field, placed)?;
        let fitted = self.run(device, &measures, true)?;
        self.cost_when_built = fitted.cost;
        Ok(fitted)
    }

    /// Fits the tree to blobs that have moved a little, or builds it anew where its boxes have become so
    /// much larger that a new tree is worth it: the rule of
    /// [`ParticleTree::is_worn`](meniscus::accel::particles::ParticleTree::is_worn). Returns whether it
    /// was built.
    pub(crate) fn refit(
        &mut self,
        device: &Device,
        field: &BlobField,
        placed: &Placed,
    ) -> Result<(Fitted, bool), GpuError> {
        let measures = self.send(device, field, placed)?;
        let fitted = self.run(device, &measures, false)?;
        if fitted.cost <= WORN * self.cost_when_built {
            return Ok((fitted, false));
        }
        let built = self.run(device, &measures, true)?;
        self.cost_when_built = built.cost;
        let device_secs = fitted.device_secs + built.device_secs;
        Ok((
            Fitted {
                device_secs,
                ..built
            },
            true,
        ))
    }

    /// Sends the blobs.
    fn send(
        &self,
        device: &Device,
        field: &BlobField,
        placed: &Placed,
    ) -> Result<Measures, GpuError> {
        device.check()?;
        let measures = Measures::of(field);
        let RawBlobs {
            words,
            places: [low, high],
        } = RawBlobs::of(field);
        self.raw.write(device, &words)?;
        let last = ((1_u32 << CURVE_BITS) - 1) as f32;
        let extent = (high - low).max_element();
        // One scale for all axes; 0 where there is no extent.
        let scale = if extent > 0.0 { last / extent } else { 0.0 };
        let [x, y, z] = low.to_array().map(f32::to_bits);
        let numbers = [x, y, z, scale.to_bits(), self.blobs, 0, 0, 0];
        let queue = &device.queue;
        queue.write_buffer(&self.curve_params, 0, bytemuck::cast_slice(&numbers));
        let half_shutter = field
            .motion
            .as_ref()
            .map_or(0.0, meniscus::field::Motion::half_shutter_secs);
        let numbers = [
            self.blobs,
            self.levels.leaves,
            placed.leaves_at,
            measures.pad.to_bits(),
            measures.least_extent.to_bits(),
            FINEST_PART.to_bits(),
            (half_shutter as f32).to_bits(),
            0,
        ];
        queue.write_buffer(&self.leaves_params, 0, bytemuck::cast_slice(&numbers));
        Ok(measures)
    }

    /// Sorts the blobs, if they shall be sorted, and fits leaves and nodes.
    fn run(&self, device: &Device, measures: &Measures, sorts: bool) -> Result<Fitted, GpuError> {
        let mut encoder = device
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                label: Some("build"),
                timestamp_writes: self.clock.as_ref().map(Clock::writes),
            });
            let builder = &self.builder;
            if sorts {
                let groups = self.blobs.div_ceil(WORKGROUP);
                let pipeline = &builder.curve.pipeline;
                dispatch(device, &mut pass, pipeline, &self.curve, groups);
                self.sorting.run(device, &builder.sort, &mut pass);
            }
            let groups = self.levels.leaves.div_ceil(WORKGROUP / LANES as u32);
            let pipeline = &builder.leaves.pipeline;
            dispatch(device, &mut pass, pipeline, &self.leaves, groups);
            for (group, count) in &self.nodes {
                let groups = count.div_ceil(WORKGROUP);
                dispatch(device, &mut pass, &builder.nodes.pipeline, group, groups);
            }
        }
        let box_bytes = u64::from(self.kind.box_words()) * CORNER_BYTES;
        let root_at = u64::from(self.levels.boxes() - 1) * box_bytes;
        encoder.copy_buffer_to_buffer(&self.boxes, root_at, &self.back, 0, box_bytes);
        let mut bytes = box_bytes;
        if let Some(clock) = &self.clock {
            clock.copy_to(&mut encoder, &self.back, box_bytes);
            bytes += TIME_BYTES;
        }
        device.queue.submit([encoder.finish()]);
        readback::read(device, &self.back, bytes, |view| {
            let (corners, times) = view.split_at(box_bytes as usize);
            let mut root = [[0.0_f32; 4]; 4];
            let read: &mut [u8] = bytemuck::cast_slice_mut(&mut root);
            read[..corners.len()].copy_from_slice(corners);
            let mut bounds = Aabb::EMPTY;
            for ends in root.chunks_exact(2).take(corners.len() / 32) {
                bounds = bounds.union(Aabb {
                    min: Vec3::from_slice(&ends[0]),
                    max: Vec3::from_slice(&ends[1]),
                });
            }
            let area = Aabb {
                min: Vec3::from_slice(&root[0]),
                max: Vec3::from_slice(&root[1]),
            };
            Fitted {
                bounds,
                typical_support: measures.typical_support,
                cost: root[0][3] / area.half_area().max(f32::MIN_POSITIVE),
                device_secs: match self.clock {
                    Some(_) => Clock::seconds(device, times),
                    None => 0.0,
                },
            }
        })
    }
}

/// What stands in a field's buffers, read back: for tests.
pub(crate) fn read_words(device: &Device, chunks: &Chunks) -> Result<Vec<Word>, GpuError> {
    let mut words: Vec<Word> = Vec::with_capacity(chunks.words);
    for buffer in &chunks.buffers {
        let back = device.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("back"),
            size: buffer.size(),
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let mut encoder = device
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.copy_buffer_to_buffer(buffer, 0, &back, 0, buffer.size());
        device.queue.submit([encoder.finish()]);
        readback::read(device, &back, buffer.size(), |view| {
            words.extend_from_slice(bytemuck::cast_slice(view));
        })?;
    }
    Ok(words)
}
