//! Stages that look at a field's particles where rays hit: their bindings and pipelines.

use super::sources::FieldStage;
use crate::device::Device;
use crate::shader::ShaderKind;
use crate::stage::{Access, Bindings};
use crate::uploaded::Uploaded;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

/// First binding of the field's buffers.
pub(super) const FIRST_CHUNK: u32 = 14;

impl FieldStage {
    /// Bindings before the field's buffers, by number: those of all stages that it needs, looks in the place
    /// of rays, the tree's parameters, columns.
    fn accesses(self) -> &'static [(u32, Access)] {
        match self {
            Self::Attributes(_) => &[
                (0, Access::Uniform),
                (1, Access::Read),
                (2, Access::Write),
                (3, Access::Write),
                (4, Access::Write),
                (7, Access::Uniform),
                (8, Access::Write),
                (12, Access::Uniform),
                (13, Access::Read),
            ],
            Self::Derivatives => &[
                (0, Access::Uniform),
                (1, Access::Read),
                (3, Access::Write),
                (4, Access::Write),
                (7, Access::Uniform),
                (9, Access::Write),
                (10, Access::Write),
                (12, Access::Uniform),
            ],
        }
    }

    /// Storage buffers beside the field's.
    fn buffers(self) -> u32 {
        let accesses = self.accesses().iter();
        accesses
            .filter(|(_, access)| *access != Access::Uniform)
            .count() as u32
    }
}

/// Such a stage for a kind of field.
#[derive(Debug)]
pub(super) struct FieldProgram {
    stage: FieldStage,
    bindings: Bindings,
    pub(super) pipeline: wgpu::ComputePipeline,
}

/// Stages that have been compiled.
#[derive(Debug, Default)]
pub(super) struct FieldPrograms(Mutex<HashMap<(ShaderKind, FieldStage), Arc<FieldProgram>>>);

impl FieldPrograms {
    /// The stage for a field; `None` where the device binds too few buffers.
    pub(super) fn get(
        &self,
        device: &Device,
        uploaded: &Uploaded,
        stage: FieldStage,
    ) -> Option<Arc<FieldProgram>> {
        let chunks = uploaded.placed().chunks.buffers.len() as u32;
        if stage.buffers() + chunks > device.limits.max_storage_buffers_per_shader_stage {
            return None;
        }
        let kind = ShaderKind {
            chunks,
            ..uploaded.kind()
        };
        let device = &device.device;
        let mut programs = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let program = programs.entry((kind, stage)).or_insert_with(|| {
            let chunks = (FIRST_CHUNK..).take(chunks as usize);
            let chunks = chunks.map(|binding| (binding, Access::Read));
            let accesses: Vec<_> = stage.accesses().iter().copied().chain(chunks).collect();
            let entry = stage.entry_point();
            let bindings = Bindings::at(device, entry, &accesses);
            let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(entry),
                source: wgpu::ShaderSource::Wgsl(stage.sources(&kind).into()),
            });
            let pipeline = bindings.pipeline(device, &module, entry);
            Arc::new(FieldProgram {
                stage,
                bindings,
                pipeline,
            })
        });
        Some(Arc::clone(program))
    }
}

impl FieldProgram {
    /// Its buffers: `own` are those before the field's, in the order of its bindings.
    pub(super) fn group<'b>(
        &self,
        device: &Device,
        uploaded: &'b Uploaded,
        own: impl IntoIterator<Item = &'b wgpu::Buffer>,
    ) -> wgpu::BindGroup {
        let numbers = self.stage.accesses().iter().map(|&(binding, _)| binding);
        let chunks = (FIRST_CHUNK..).zip(&uploaded.placed().chunks.buffers);
        let bindings = &self.bindings;
        bindings.group_at(&device.device, numbers.zip(own).chain(chunks))
    }
}
