//! The raster variant: layers of sprites, nearest first, until every ray is answered.

use super::field::PeelWork;
use super::programs::Sprites;
use super::room::{Layers, Own, Room};
use super::round::Call;
use super::times::{Clock, Stage};
use crate::error::GpuError;
use std::time::{Duration, Instant};

/// Layers that are drawn before the device is asked whether all is done.
const FIRST_LAYERS: u32 = 8;
const MOST_LAYERS_AT_ONCE: u32 = 128;
/// Drivers reset cards after some seconds; a submission shall take a part of one.
const LONGEST: Duration = Duration::from_millis(300);
/// A ray that has more events than this is answered otherwise.
const MOST_LAYERS: u64 = 1 << 14;

/// Slots per workgroup.
const LANES: u32 = 64;

/// Draws until all rays are answered; returns an encoder for what comes after.
pub(super) fn run(
    room: &mut Room,
    call: &Call<'_>,
    programs: &Sprites,
    mut encoder: wgpu::CommandEncoder,
    work: &mut PeelWork,
) -> Result<wgpu::CommandEncoder, GpuError> {
    begin(room, call, programs, &mut encoder);
    let slots = call.slots.records.len() as u32;
    let mut at_once = FIRST_LAYERS;
    let mut drawn = 0;
    loop {
        let Own::Sprites(layers) = &room.own else {
            return Ok(encoder);
        };
        let mut clock = room.clock.take();
        let painter = Painter {
            room,
            call,
            layers,
            programs,
        };
        painter.layers(at_once, &mut encoder, &mut clock);
        let bytes = 4 * call.slots.groups.len() as u64;
        encoder.copy_buffer_to_buffer(&layers.finished, 0, &room.back, 0, bytes);
        room.clock = clock;
        drawn += u64::from(at_once);
        let start = Instant::now();
        let mut finished = 0;
        call.send(room, encoder, bytes.next_multiple_of(8), work, |bytes| {
            let counts = bytes.chunks_exact(4).take(call.slots.groups.len());
            finished = counts.map(bytemuck::pod_read_unaligned::<u32>).sum();
        })?;
        encoder = call.encoder();
        if finished == slots || drawn >= MOST_LAYERS {
            break;
        }
        if start.elapsed() < LONGEST / 4 {
            at_once = (2 * at_once).min(MOST_LAYERS_AT_ONCE);
        } else if start.elapsed() > LONGEST {
            at_once = (at_once / 2).max(1);
        }
    }
    work.layers += drawn;
    Ok(encoder)
}

/// Finds out how far each ray has to look, and which sprites are seen at all before that.
pub(super) fn begin(
    room: &mut Room,
    call: &Call<'_>,
    programs: &Sprites,
    encoder: &mut wgpu::CommandEncoder,
) {
    let mut clock = room.clock.take();
    if let Own::Sprites(layers) = &room.own {
        encoder.clear_buffer(&layers.finished, 0, None);
        encoder.clear_buffer(&layers.seen, 0, None);
        let painter = Painter {
            room,
            call,
            layers,
            programs,
        };
        painter.begin(encoder, &mut clock);
    }
    room.clock = clock;
}

struct Painter<'a> {
    room: &'a Room,
    call: &'a Call<'a>,
    layers: &'a Layers,
    programs: &'a Sprites,
}

/// Depths at the start of a pass.
const NOTHING: wgpu::LoadOp<f32> = wgpu::LoadOp::Clear(1.0);

impl Painter<'_> {
    fn begin(&self, encoder: &mut wgpu::CommandEncoder, clock: &mut Option<Clock>) {
        let numbers = match self.call.balls.has_kernel_spheres {
            true => Some(&[0, 1, 5, 6, 7, 8, 10][..]),
            false => None,
        };
        self.draw(
            encoder,
            clock,
            &self.programs.kernel_sphere,
            (numbers, false),
        );
        self.compute(
            encoder,
            clock,
            &self.programs.begin,
            &[0, 1, 2, 8, 12, 14, 17],
        );
        self.draw(
            encoder,
            clock,
            &self.programs.mark,
            (Some(&[0, 1, 5, 7, 8, 10, 12, 15]), false),
        );
    }

    fn layers(&self, count: u32, encoder: &mut wgpu::CommandEncoder, clock: &mut Option<Clock>) {
        for _ in 0..count {
            self.draw(
                encoder,
                clock,
                &self.programs.next_event,
                (Some(&[0, 1, 5, 7, 8, 10, 12, 14, 19]), true),
            );
            self.compute(
                encoder,
                clock,
                &self.programs.advance,
                &[0, 1, 2, 5, 6, 7, 12, 13, 14, 17, 18],
            );
        }
    }

    /// Draws all sprites with what `numbers` bind; without them only clears.
    fn draw(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        clock: &mut Option<Clock>,
        pipeline: &wgpu::RenderPipeline,
        (numbers, with_events): (Option<&[u32]>, bool),
    ) {
        let events = [Some(wgpu::RenderPassColorAttachment {
            view: &self.layers.events,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations {
                load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                store: wgpu::StoreOp::Store,
            },
        })];
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("sprites"),
            color_attachments: if with_events { &events } else { &[] },
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.layers.depths,
                depth_ops: Some(wgpu::Operations {
                    load: NOTHING,
                    store: wgpu::StoreOp::Store,
                }),
                stencil_ops: None,
            }),
            timestamp_writes: clock
                .as_mut()
                .and_then(|clock| clock.render(Stage::Sprites)),
            occlusion_query_set: None,
            multiview_mask: None,
        });
        if let Some(numbers) = numbers {
            let bound = self
                .call
                .bind(&pipeline.get_bind_group_layout(0), self.room, numbers);
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, &bound, &[]);
            pass.draw_indirect(&self.room.drawing, 0);
        }
    }

    fn compute(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        clock: &mut Option<Clock>,
        pipeline: &wgpu::ComputePipeline,
        numbers: &[u32],
    ) {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("slots"),
            timestamp_writes: clock.as_mut().and_then(|clock| clock.compute(Stage::Solve)),
        });
        let groups = (self.call.slots.records.len() as u32).div_ceil(LANES);
        self.call
            .dispatch(&mut pass, pipeline, (self.room, numbers), groups);
    }
}
