//! One step of work on a device: a compute pipeline and what its buffers are.

use crate::device::Device;

/// What a shader does with a buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Access {
    /// A few numbers that all invocations share.
    Uniform,
    /// Read.
    Read,
    /// Read and written.
    Write,
}

impl Access {
    pub(crate) fn layout(self, binding: u32) -> wgpu::BindGroupLayoutEntry {
        let storage = |read_only| wgpu::BufferBindingType::Storage { read_only };
        wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: wgpu::BindingType::Buffer {
                ty: match self {
                    Self::Uniform => wgpu::BufferBindingType::Uniform,
                    Self::Read => storage(true),
                    Self::Write => storage(false),
                },
                has_dynamic_offset: false,
                min_binding_size: None,
            },
            count: None,
        }
    }
}

/// Bindings of a shader.
#[derive(Debug)]
pub(crate) struct Bindings {
    group: wgpu::BindGroupLayout,
    pipeline: wgpu::PipelineLayout,
}

impl Bindings {
    /// Those numbered from 0.
    pub(crate) fn new(device: &wgpu::Device, label: &str, accesses: &[Access]) -> Self {
        let numbered: Vec<_> = (0..).zip(accesses.iter().copied()).collect();
        Self::at(device, label, &numbered)
    }

    /// Those with numbers of their own.
    pub(crate) fn at(device: &wgpu::Device, label: &str, accesses: &[(u32, Access)]) -> Self {
        let entries: Vec<_> = (accesses.iter())
            .map(|&(binding, access)| access.layout(binding))
            .collect();
        let group = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some(label),
            entries: &entries,
        });
        let pipeline = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(label),
            bind_group_layouts: &[Some(&group)],
            immediate_size: 0,
        });
        Self { group, pipeline }
    }

    /// The buffers for a step, numbered from 0.
    pub(crate) fn group<'b>(
        &self,
        device: &wgpu::Device,
        buffers: impl IntoIterator<Item = &'b wgpu::Buffer>,
    ) -> wgpu::BindGroup {
        self.group_at(device, (0..).zip(buffers))
    }

    /// The buffers for a step.
    pub(crate) fn group_at<'b>(
        &self,
        device: &wgpu::Device,
        buffers: impl IntoIterator<Item = (u32, &'b wgpu::Buffer)>,
    ) -> wgpu::BindGroup {
        let entries: Vec<_> = (buffers.into_iter())
            .map(|(binding, buffer)| wgpu::BindGroupEntry {
                binding,
                resource: buffer.as_entire_binding(),
            })
            .collect();
        device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &self.group,
            entries: &entries,
        })
    }

    /// The pipeline of an entry point.
    pub(crate) fn pipeline(
        &self,
        device: &wgpu::Device,
        module: &wgpu::ShaderModule,
        entry_point: &str,
    ) -> wgpu::ComputePipeline {
        device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(entry_point),
            layout: Some(&self.pipeline),
            module,
            entry_point: Some(entry_point),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        })
    }
}

/// Runs `groups` workgroups, numbered as shaders reckon: line by line, since one line has a largest length.
pub(crate) fn dispatch(
    device: &Device,
    pass: &mut wgpu::ComputePass<'_>,
    pipeline: &wgpu::ComputePipeline,
    group: &wgpu::BindGroup,
    groups: u32,
) {
    pass.set_pipeline(pipeline);
    pass.set_bind_group(0, group, &[]);
    let width = groups.clamp(1, device.limits.max_compute_workgroups_per_dimension);
    pass.dispatch_workgroups(width, groups.div_ceil(width), 1);
}
