//! Shaders that have been compiled: kept for the fields and frames to come.

use crate::device::Device;
use crate::shader::{FIRST_CHUNK, ShaderKind, sources};
use std::collections::HashMap;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// What a ray is asked; an entry point each.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Question {
    /// Where the first crossing is.
    First,
    /// Whether there is one.
    Any,
}

/// One shader with its entry points, compiled when they are first needed.
#[derive(Debug)]
pub(crate) struct Program {
    pub(crate) group_layout: wgpu::BindGroupLayout,
    layout: wgpu::PipelineLayout,
    module: wgpu::ShaderModule,
    closest: OnceLock<wgpu::ComputePipeline>,
    occluded: OnceLock<wgpu::ComputePipeline>,
}

/// The shaders of a device.
#[derive(Debug, Default)]
pub(crate) struct Programs(Mutex<HashMap<ShaderKind, Arc<Program>>>);

impl Programs {
    /// The shader of a kind.
    pub(crate) fn get(&self, device: &Device, kind: ShaderKind) -> Arc<Program> {
        let mut programs = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let program = programs
            .entry(kind)
            .or_insert_with(|| Arc::new(Program::new(&device.device, &kind)));
        Arc::clone(program)
    }
}

impl Program {
    fn new(device: &wgpu::Device, kind: &ShaderKind) -> Self {
        let entry = |binding, ty| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: wgpu::BindingType::Buffer {
                ty,
                has_dynamic_offset: false,
                min_binding_size: None,
            },
            count: None,
        };
        let storage = |read_only| wgpu::BufferBindingType::Storage { read_only };
        let mut entries = vec![
            entry(0, wgpu::BufferBindingType::Uniform),
            entry(1, storage(true)),
            entry(2, storage(false)),
            entry(3, storage(false)),
            entry(4, storage(false)),
        ];
        entries.extend((0..kind.chunks).map(|chunk| entry(FIRST_CHUNK + chunk, storage(true))));
        let group_layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("trace"),
            entries: &entries,
        });
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("trace"),
            bind_group_layouts: &[Some(&group_layout)],
            immediate_size: 0,
        });
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("intersect/particles"),
            source: wgpu::ShaderSource::Wgsl(sources(kind).into()),
        });
        Self {
            group_layout,
            layout,
            module,
            closest: OnceLock::new(),
            occluded: OnceLock::new(),
        }
    }

    /// What answers a question.
    pub(crate) fn pipeline(&self, device: &Device, question: Question) -> &wgpu::ComputePipeline {
        let (slot, entry_point) = match question {
            Question::First => (&self.closest, "closest"),
            Question::Any => (&self.occluded, "occluded"),
        };
        slot.get_or_init(|| {
            device
                .device
                .create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                    label: Some(entry_point),
                    layout: Some(&self.layout),
                    module: &self.module,
                    entry_point: Some(entry_point),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    cache: None,
                })
        })
    }
}
