//! The stages' pipelines, compiled when they are first needed and kept with the device.

use super::field_stage::FieldPrograms;
use super::sources::StageModule;
use crate::device::Device;
use crate::stage::{Access, Bindings};
use meniscus::scene::IntegratorKind;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// Storage buffers that a stage binds.
pub(crate) const STAGE_BUFFERS: u32 = 10;

/// Bindings of all stages, in order.
const ACCESSES: [Access; 12] = [
    Access::Uniform,
    Access::Read,
    Access::Write,
    Access::Write,
    Access::Write,
    Access::Write,
    Access::Write,
    Access::Uniform,
    Access::Write,
    Access::Write,
    Access::Write,
    Access::Write,
];

/// What all integrators share.
#[derive(Debug)]
pub(crate) struct Common {
    pub(crate) bindings: Bindings,
    pub(crate) begin: wgpu::ComputePipeline,
    pub(crate) solids: wgpu::ComputePipeline,
    pub(crate) clip: wgpu::ComputePipeline,
    pub(crate) merge: wgpu::ComputePipeline,
}

/// The stages of a device.
#[derive(Debug, Default)]
pub(crate) struct StagePrograms {
    common: OnceLock<Common>,
    integrators: Mutex<HashMap<IntegratorKind, Arc<wgpu::ComputePipeline>>>,
    pub(super) fields: FieldPrograms,
}

fn compiled(device: &wgpu::Device, module: StageModule) -> wgpu::ShaderModule {
    device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("stages"),
        source: wgpu::ShaderSource::Wgsl(module.sources().into()),
    })
}

impl StagePrograms {
    pub(crate) fn common(&self, device: &Device) -> &Common {
        self.common.get_or_init(|| {
            let device = &device.device;
            let bindings = Bindings::new(device, "stages", &ACCESSES);
            let begin = compiled(device, StageModule::Begin);
            let surfaces = compiled(device, StageModule::Surfaces);
            Common {
                begin: bindings.pipeline(device, &begin, "begin"),
                solids: bindings.pipeline(device, &surfaces, "solids"),
                clip: bindings.pipeline(device, &surfaces, "clip"),
                merge: bindings.pipeline(device, &surfaces, "merge"),
                bindings,
            }
        })
    }

    pub(crate) fn integrator(
        &self,
        device: &Device,
        kind: IntegratorKind,
    ) -> Arc<wgpu::ComputePipeline> {
        let common = self.common(device);
        let mut integrators = (self.integrators.lock()).unwrap_or_else(PoisonError::into_inner);
        let pipeline = integrators.entry(kind).or_insert_with(|| {
            let module = compiled(&device.device, StageModule::Integrator(kind));
            Arc::new(common.bindings.pipeline(&device.device, &module, "shade"))
        });
        Arc::clone(pipeline)
    }
}
