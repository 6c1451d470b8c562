//! How long the stages take by the device's own clock.

use crate::device::Device;

/// Stages of engine `peel`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Stage {
    /// Lists of balls per tile.
    Lists,
    /// Passes that draw sprites.
    Sprites,
    /// Lists of pixels, intervals, surfaces.
    Solve,
}

/// Device time by stage, in seconds; 0 where the device keeps none.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StageSecs {
    /// Making the lists of balls per tile.
    pub lists: f64,
    /// Drawing sprites; none where lists are walked.
    pub sprites: f64,
    /// Finding surfaces.
    pub solve: f64,
}

impl StageSecs {
    /// All of it.
    pub fn total(&self) -> f64 {
        self.lists + self.sprites + self.solve
    }

    fn add(&mut self, stage: Stage, seconds: f64) {
        match stage {
            Stage::Lists => self.lists += seconds,
            Stage::Sprites => self.sprites += seconds,
            Stage::Solve => self.solve += seconds,
        }
    }
}

impl std::ops::AddAssign for StageSecs {
    fn add_assign(&mut self, other: Self) {
        self.lists += other.lists;
        self.sprites += other.sprites;
        self.solve += other.solve;
    }
}

impl std::ops::Div<f64> for StageSecs {
    type Output = Self;

    fn div(self, by: f64) -> Self {
        Self {
            lists: self.lists / by,
            sprites: self.sprites / by,
            solve: self.solve / by,
        }
    }
}

/// Passes that can be timed between two readings.
const PASSES: u32 = 512;

const STAMP_BYTES: u64 = 8;

/// Takes the times of passes.
#[derive(Debug)]
pub(super) struct Clock {
    set: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    taken: Vec<Stage>,
}

impl Clock {
    /// A clock, where the device has one.
    pub(super) fn new(device: &Device) -> Option<Self> {
        device.has_timestamps.then(|| Self {
            set: device.device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("times"),
                ty: wgpu::QueryType::Timestamp,
                count: 2 * PASSES,
            }),
            resolved: device.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("times"),
                size: 2 * u64::from(PASSES) * STAMP_BYTES,
                usage: wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
                mapped_at_creation: false,
            }),
            taken: Vec::new(),
        })
    }

    /// The number of the next pass, which belongs to `stage`; `None`: there are too many.
    fn next(&mut self, stage: Stage) -> Option<u32> {
        let number = self.taken.len() as u32;
        (number < PASSES).then(|| {
            self.taken.push(stage);
            number
        })
    }

    /// What a compute pass has to write.
    pub(super) fn compute(&mut self, stage: Stage) -> Option<wgpu::ComputePassTimestampWrites<'_>> {
        self.next(stage)
            .map(|number| wgpu::ComputePassTimestampWrites {
                query_set: &self.set,
                beginning_of_pass_write_index: Some(2 * number),
                end_of_pass_write_index: Some(2 * number + 1),
            })
    }

    /// What a render pass has to write.
    pub(super) fn render(&mut self, stage: Stage) -> Option<wgpu::RenderPassTimestampWrites<'_>> {
        self.next(stage)
            .map(|number| wgpu::RenderPassTimestampWrites {
                query_set: &self.set,
                beginning_of_pass_write_index: Some(2 * number),
                end_of_pass_write_index: Some(2 * number + 1),
            })
    }

    /// Most bytes of the stamps.
    pub(super) const BYTES: u64 = 2 * PASSES as u64 * STAMP_BYTES;

    /// Has the stamps written to `back` at `at`; returns their bytes.
    pub(super) fn resolve(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        back: &wgpu::Buffer,
        at: u64,
    ) -> u64 {
        let count = 2 * self.taken.len() as u32;
        let bytes = u64::from(count) * STAMP_BYTES;
        if count > 0 {
            encoder.resolve_query_set(&self.set, 0..count, &self.resolved, 0);
            encoder.copy_buffer_to_buffer(&self.resolved, 0, back, at, bytes);
        }
        bytes
    }

    /// Adds the times between the stamps to their stages, and starts anew.
    pub(super) fn read(&mut self, device: &Device, stamps: &[u8], seconds: &mut StageSecs) {
        let period = f64::from(device.queue.get_timestamp_period()) * 1e-9;
        let stamp = |number: usize| {
            let at = number * STAMP_BYTES as usize;
            let bytes = stamps.get(at..at + STAMP_BYTES as usize);
            bytes.map_or(0, bytemuck::pod_read_unaligned::<u64>)
        };
        for (number, stage) in self.taken.drain(..).enumerate() {
            let ticks = stamp(2 * number + 1).saturating_sub(stamp(2 * number));
            seconds.add(stage, ticks as f64 * period);
        }
    }
}
