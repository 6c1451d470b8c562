//! Shaders that have been compiled: kept for the fields and frames to come.

use crate::device::Device;
use crate::shader::{CROSSINGS, ShaderKind, sources};
use crate::stage::{Access, Bindings};
use std::collections::HashMap;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// What a ray is asked; an entry point each.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Question {
    /// Where the first crossing is.
    First,
    /// Whether there is one.
    Any,
    /// Where all of them are.
    All,
}

impl Question {
    /// Records that a ray is answered with.
    pub(crate) fn records(self) -> u32 {
        match self {
            Self::First | Self::Any => 1,
            Self::All => CROSSINGS,
        }
    }
}

/// One shader with its entry points, compiled when they are first needed.
#[derive(Debug)]
pub(crate) struct Program {
    pub(crate) bindings: Bindings,
    module: wgpu::ShaderModule,
    closest: OnceLock<wgpu::ComputePipeline>,
    occluded: OnceLock<wgpu::ComputePipeline>,
    crossings: OnceLock<wgpu::ComputePipeline>,
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
        let mut accesses = vec![
            Access::Uniform,
            Access::Read,
            Access::Write,
            Access::Write,
            Access::Write,
        ];
        accesses.extend((0..kind.chunks).map(|_| Access::Read));
        let bindings = Bindings::new(device, "trace", &accesses);
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("intersect/particles"),
            source: wgpu::ShaderSource::Wgsl(sources(kind).into()),
        });
        Self {
            bindings,
            module,
            closest: OnceLock::new(),
            occluded: OnceLock::new(),
            crossings: OnceLock::new(),
        }
    }

    /// What answers a question.
    pub(crate) fn pipeline(&self, device: &Device, question: Question) -> &wgpu::ComputePipeline {
        let (slot, entry_point) = match question {
            Question::First => (&self.closest, "closest"),
            Question::Any => (&self.occluded, "occluded"),
            Question::All => (&self.crossings, "crossings"),
        };
        slot.get_or_init(|| {
            self.bindings
                .pipeline(&device.device, &self.module, entry_point)
        })
    }
}
