//! Looks that follow particles' attributes: what the particles of a field carry, on the device, and the
//! stage that blends it.

use super::sources::attribute_sources;
use crate::device::Device;
use crate::error::GpuError;
use crate::shader::ShaderKind;
use crate::stage::{Access, Bindings};
use crate::uploaded::Uploaded;
use meniscus::shade::StagedColumns;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

/// Bindings of the stage before the field's buffers, by number: those of all stages that it needs, the
/// looks in the place of rays, the tree's parameters, the columns.
const ACCESSES: [(u32, Access); 9] = [
    (0, Access::Uniform),
    (1, Access::Read),
    (2, Access::Write),
    (3, Access::Write),
    (4, Access::Write),
    (7, Access::Uniform),
    (8, Access::Write),
    (12, Access::Uniform),
    (13, Access::Read),
];
/// First binding of the field's buffers.
pub(super) const FIRST_CHUNK: u32 = 14;
/// Storage buffers beside those.
const BUFFERS: u32 = 6;

/// The stage for a kind of field and a number of columns.
#[derive(Debug)]
struct BlendProgram {
    bindings: Bindings,
    pipeline: wgpu::ComputePipeline,
}

/// Stages that have been compiled.
#[derive(Debug, Default)]
pub(super) struct BlendPrograms(Mutex<HashMap<(ShaderKind, u32), Arc<BlendProgram>>>);

impl BlendPrograms {
    fn get(&self, device: &wgpu::Device, kind: ShaderKind, columns: u32) -> Arc<BlendProgram> {
        let mut programs = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let program = programs.entry((kind, columns)).or_insert_with(|| {
            let chunks = (FIRST_CHUNK..).take(kind.chunks as usize);
            let accesses = chunks.map(|binding| (binding, Access::Read));
            let accesses: Vec<_> = ACCESSES.into_iter().chain(accesses).collect();
            let bindings = Bindings::at(device, "attributes", &accesses);
            let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some("shade/attributes"),
                source: wgpu::ShaderSource::Wgsl(attribute_sources(&kind, columns).into()),
            });
            let pipeline = bindings.pipeline(device, &module, "attributes");
            Arc::new(BlendProgram { bindings, pipeline })
        });
        Arc::clone(program)
    }
}

/// A field's columns and its stage.
pub(super) struct Blend {
    columns: wgpu::Buffer,
    program: Arc<BlendProgram>,
}

impl Blend {
    /// `None` where the device binds too few buffers or too small ones.
    pub(super) fn new(
        device: &Device,
        uploaded: &Uploaded,
        columns: &StagedColumns,
    ) -> Result<Option<Self>, GpuError> {
        let bytes: &[u8] = bytemuck::cast_slice(&columns.bits);
        let chunks = uploaded.placed().chunks.buffers.len() as u32;
        let most = device.limits.max_storage_buffers_per_shader_stage;
        if BUFFERS + chunks > most || bytes.len() as u64 > device.largest_binding() {
            return Ok(None);
        }
        let kind = ShaderKind {
            chunks,
            ..uploaded.kind()
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
        let programs = &device.stages.blends;
        Ok(Some(Self {
            columns: buffer,
            program: programs.get(&device.device, kind, columns.per_particle),
        }))
    }

    pub(super) fn pipeline(&self) -> &wgpu::ComputePipeline {
        &self.program.pipeline
    }

    /// Its buffers: `shared` are those before the columns, in the order of [`ACCESSES`].
    pub(super) fn group(
        &self,
        device: &Device,
        uploaded: &Uploaded,
        shared: [&wgpu::Buffer; 8],
    ) -> wgpu::BindGroup {
        let own = shared.into_iter().chain([&self.columns]);
        let own = ACCESSES.iter().map(|&(binding, _)| binding).zip(own);
        let chunks = (FIRST_CHUNK..).zip(&uploaded.placed().chunks.buffers);
        let bindings = &self.program.bindings;
        bindings.group_at(&device.device, own.chain(chunks))
    }
}
