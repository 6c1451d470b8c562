//! Looks that follow particles' attributes: what the particles of a field carry, on the device, and the
//! stage that blends it.

use super::field_stage::FieldProgram;
use super::sources::FieldStage;
use crate::device::Device;
use crate::error::GpuError;
use crate::uploaded::Uploaded;
use meniscus::shade::StagedColumns;
use std::sync::Arc;

/// A field's columns and its stage.
pub(super) struct Blend {
    columns: wgpu::Buffer,
    program: Arc<FieldProgram>,
}

impl Blend {
    /// `None` where the device binds too few buffers or too small ones.
    pub(super) fn new(
        device: &Device,
        uploaded: &Uploaded,
        columns: &StagedColumns,
    ) -> Result<Option<Self>, GpuError> {
        let bytes: &[u8] = bytemuck::cast_slice(&columns.bits);
        if bytes.len() as u64 > device.largest_binding() {
            return Ok(None);
        }
        let stage = FieldStage::Attributes(columns.per_particle);
        let Some(program) = device.stages.fields.get(device, uploaded, stage) else {
            return Ok(None);
        };
        let buffer = device.within_memory(bytes.len() as u64, || {
            device.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("columns"),
                size: bytes.len() as u64,
                usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        })?;
        device.queue.write_buffer(&buffer, 0, bytes);
        Ok(Some(Self {
            columns: buffer,
            program,
        }))
    }

    pub(super) fn pipeline(&self) -> &wgpu::ComputePipeline {
        &self.program.pipeline
    }

    /// Its buffers: `shared` are those before the columns.
    pub(super) fn group(
        &self,
        device: &Device,
        uploaded: &Uploaded,
        shared: [&wgpu::Buffer; 8],
    ) -> wgpu::BindGroup {
        let own = shared.into_iter().chain([&self.columns]);
        self.program.group(device, uploaded, own)
    }
}
