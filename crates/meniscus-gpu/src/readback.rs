//! What a device wrote, read on this side.

use crate::device::Device;
use crate::error::GpuError;
use std::sync::mpsc;
use std::time::Duration;

/// How long work may take before the device counts as lost.
const PATIENCE: Duration = Duration::from_secs(120);

/// Bytes of two timestamps.
pub(crate) const TIME_BYTES: u64 = 16;

/// Waits for everything sent, then calls `visit` with the first `bytes` bytes of a buffer that can be mapped.
pub(crate) fn read<T>(
    device: &Device,
    buffer: &wgpu::Buffer,
    bytes: u64,
    visit: impl FnOnce(&[u8]) -> T,
) -> Result<T, GpuError> {
    let (sender, receiver) = mpsc::channel();
    buffer.map_async(wgpu::MapMode::Read, 0..bytes, move |result| {
        // Nobody waits any more where the receiver is gone.
        let _ = sender.send(result);
    });
    device.wait()?;
    // Another thread's wait may be the one that delivers.
    match receiver.recv_timeout(PATIENCE) {
        Ok(Ok(())) => {}
        Ok(Err(error)) => return Err(device.lost(error.to_string())),
        Err(_) => return Err(device.lost("it gives no answer".to_owned())),
    }
    let seen = {
        let view = buffer
            .get_mapped_range(0..bytes)
            .map_err(|error| device.lost(error.to_string()))?;
        visit(&view)
    };
    buffer.unmap();
    Ok(seen)
}

/// A device's clock at the beginning and the end of a pass.
#[derive(Debug)]
pub(crate) struct Clock {
    set: wgpu::QuerySet,
    resolved: wgpu::Buffer,
}

impl Clock {
    /// `None` where the device keeps no time.
    pub(crate) fn new(device: &Device) -> Option<Self> {
        use wgpu::BufferUsages as Usage;
        device.has_timestamps.then(|| Self {
            set: device.device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("times"),
                ty: wgpu::QueryType::Timestamp,
                count: 2,
            }),
            resolved: device.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("times"),
                size: TIME_BYTES,
                usage: Usage::QUERY_RESOLVE | Usage::COPY_SRC,
                mapped_at_creation: false,
            }),
        })
    }

    /// For the pass that is to be timed.
    pub(crate) fn writes(&self) -> wgpu::ComputePassTimestampWrites<'_> {
        wgpu::ComputePassTimestampWrites {
            query_set: &self.set,
            beginning_of_pass_write_index: Some(0),
            end_of_pass_write_index: Some(1),
        }
    }

    /// For the first of several passes that are to be timed together.
    pub(crate) fn beginning(&self) -> wgpu::ComputePassTimestampWrites<'_> {
        wgpu::ComputePassTimestampWrites {
            end_of_pass_write_index: None,
            ..self.writes()
        }
    }

    /// For the last of them.
    pub(crate) fn end(&self) -> wgpu::ComputePassTimestampWrites<'_> {
        wgpu::ComputePassTimestampWrites {
            beginning_of_pass_write_index: None,
            ..self.writes()
        }
    }

    /// Copies both times to a place in a buffer.
    pub(crate) fn copy_to(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        buffer: &wgpu::Buffer,
        at: u64,
    ) {
        encoder.resolve_query_set(&self.set, 0..2, &self.resolved, 0);
        encoder.copy_buffer_to_buffer(&self.resolved, 0, buffer, at, TIME_BYTES);
    }

    /// Seconds between both times.
    pub(crate) fn seconds(device: &Device, bytes: &[u8]) -> f64 {
        let mut times = [0_u64; 2];
        bytemuck::cast_slice_mut(&mut times).copy_from_slice(bytes);
        let ticks = times[1].saturating_sub(times[0]) as f64;
        ticks * f64::from(device.queue.get_timestamp_period()) * 1e-9
    }
}
