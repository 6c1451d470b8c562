//! The shaders that build trees, compiled.

use crate::device::Device;
use crate::shader::{BuildKind, BuildStep};
use crate::stage::{Access, Bindings};
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

/// One kind of field.
#[derive(Debug)]
pub(super) struct Builder {
    pub(super) curve: Step,
    pub(super) leaves: Step,
    pub(super) nodes: Step,
    pub(super) sort: Sort,
}

/// A pipeline and its bindings.
#[derive(Debug)]
pub(super) struct Step {
    pub(super) bindings: Bindings,
    pub(super) pipeline: wgpu::ComputePipeline,
}

/// The steps of a pass of the sort, which share their bindings.
#[derive(Debug)]
pub(super) struct Sort {
    pub(super) bindings: Bindings,
    pub(super) count: wgpu::ComputePipeline,
    pub(super) scan: wgpu::ComputePipeline,
    pub(super) scatter: wgpu::ComputePipeline,
}

/// The builders of a device.
#[derive(Debug, Default)]
pub(crate) struct Builders(Mutex<HashMap<BuildKind, Arc<Builder>>>);

impl Builders {
    /// The builder of a kind.
    pub(super) fn get(&self, device: &Device, kind: BuildKind) -> Arc<Builder> {
        let mut builders = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let builder = builders
            .entry(kind)
            .or_insert_with(|| Arc::new(Builder::new(&device.device, &kind)));
        Arc::clone(builder)
    }
}

impl Builder {
    fn new(device: &wgpu::Device, kind: &BuildKind) -> Self {
        let module = |step: BuildStep| {
            device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some("accel/build"),
                source: wgpu::ShaderSource::Wgsl(kind.sources(step).into()),
            })
        };
        let raw = (0..kind.raw_chunks).map(|_| Access::Read);
        let tree = (0..kind.tree_chunks).map(|_| Access::Write);
        let step = |step: BuildStep, accesses: Vec<Access>, entry_point: &str| {
            let bindings = Bindings::new(device, entry_point, &accesses);
            let pipeline = bindings.pipeline(device, &module(step), entry_point);
            Step { bindings, pipeline }
        };
        let curve = [Access::Uniform, Access::Write, Access::Write];
        let leaves = [Access::Uniform, Access::Read, Access::Write];
        let nodes = [Access::Uniform, Access::Write];
        Self {
            curve: step(
                BuildStep::Curve,
                curve.into_iter().chain(raw.clone()).collect(),
                "place",
            ),
            leaves: step(
                BuildStep::Leaves,
                leaves.into_iter().chain(raw).chain(tree.clone()).collect(),
                "fit_leaves",
            ),
            nodes: step(
                BuildStep::Nodes,
                nodes.into_iter().chain(tree).collect(),
                "fit_nodes",
            ),
            sort: Sort::new(device, &module(BuildStep::Sort)),
        }
    }
}

impl Sort {
    fn new(device: &wgpu::Device, module: &wgpu::ShaderModule) -> Self {
        let accesses = [
            Access::Uniform,
            Access::Read,
            Access::Read,
            Access::Write,
            Access::Write,
            Access::Write,
            Access::Write,
        ];
        let bindings = Bindings::new(device, "sort", &accesses);
        let pipeline = |entry_point| bindings.pipeline(device, module, entry_point);
        let (count, scan, scatter) = (pipeline("count"), pipeline("scan"), pipeline("scatter"));
        Self {
            bindings,
            count,
            scan,
            scatter,
        }
    }
}
