//! Pipelines of engine `peel`, compiled when they are first needed and kept with the device.

use super::shader::{PeelKind, PeelModule, peel_sources};
use crate::device::Device;
use meniscus::scene::PeelVariant;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

/// Format of depths along a ray.
pub(super) const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
/// Format of events.
pub(super) const EVENT_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R32Uint;

/// Those that make lists.
#[derive(Debug)]
pub(super) struct Lists {
    pub(super) count: wgpu::ComputePipeline,
    pub(super) scan: wgpu::ComputePipeline,
    pub(super) fill: wgpu::ComputePipeline,
    pub(super) sort: wgpu::ComputePipeline,
}

/// Those that find surfaces.
#[derive(Debug)]
pub(super) enum Solve {
    Tiles(wgpu::ComputePipeline),
    Sprites(Box<Sprites>),
}

/// Those of the raster variant.
#[derive(Debug)]
pub(super) struct Sprites {
    pub(super) kernel_sphere: wgpu::RenderPipeline,
    pub(super) begin: wgpu::ComputePipeline,
    pub(super) mark: wgpu::RenderPipeline,
    pub(super) next_event: wgpu::RenderPipeline,
    pub(super) advance: wgpu::ComputePipeline,
}

/// All of a kind.
#[derive(Debug)]
pub(super) struct Program {
    pub(super) lists: Lists,
    pub(super) solve: Solve,
}

/// Those of a device.
#[derive(Debug, Default)]
pub(crate) struct Programs(Mutex<HashMap<PeelKind, Arc<Program>>>);

impl Programs {
    /// Those of a kind.
    pub(super) fn get(&self, device: &Device, kind: PeelKind) -> Arc<Program> {
        let mut programs = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let program = programs
            .entry(kind)
            .or_insert_with(|| Arc::new(Program::new(&device.device, kind)));
        Arc::clone(program)
    }
}

impl Program {
    fn new(device: &wgpu::Device, kind: PeelKind) -> Self {
        let module = |module| {
            device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some("peel"),
                source: wgpu::ShaderSource::Wgsl(peel_sources(&kind, module).into()),
            })
        };
        let compute = |module: &wgpu::ShaderModule, entry_point| {
            device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(entry_point),
                layout: None,
                module,
                entry_point: Some(entry_point),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            })
        };
        let bins = module(PeelModule::Bins);
        let lists = Lists {
            count: compute(&bins, "count"),
            scan: compute(&module(PeelModule::Scan), "scan"),
            fill: compute(&bins, "fill"),
            sort: compute(&module(PeelModule::Sort), "sort"),
        };
        let solve = match kind.variant {
            PeelVariant::Tiles => Solve::Tiles(compute(&module(PeelModule::Tiled), "closest")),
            PeelVariant::Sprites => {
                let sprites = module(PeelModule::Sprites);
                let slots = module(PeelModule::Slots);
                Solve::Sprites(Box::new(Sprites {
                    kernel_sphere: raster(
                        device,
                        &sprites,
                        ["every_sprite", "kernel_sphere"],
                        Output::Depth,
                    ),
                    begin: compute(&slots, "begin"),
                    mark: raster(device, &sprites, ["every_sprite", "mark"], Output::Nothing),
                    next_event: raster(
                        device,
                        &sprites,
                        ["visible_sprite", "next_event"],
                        Output::Event,
                    ),
                    advance: compute(&slots, "advance"),
                }))
            }
        };
        Self { lists, solve }
    }
}

/// What a fragment leaves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Output {
    /// The least depth.
    Depth,
    /// Nothing: it writes to buffers.
    Nothing,
    /// The least depth and its event.
    Event,
}

fn raster(
    device: &wgpu::Device,
    module: &wgpu::ShaderModule,
    [vertex, fragment]: [&str; 2],
    output: Output,
) -> wgpu::RenderPipeline {
    let event = [Some(wgpu::ColorTargetState {
        format: EVENT_FORMAT,
        blend: None,
        write_mask: wgpu::ColorWrites::ALL,
    })];
    let is_kept = output != Output::Nothing;
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(fragment),
        layout: None,
        vertex: wgpu::VertexState {
            module,
            entry_point: Some(vertex),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: &[],
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: Some(wgpu::DepthStencilState {
            format: DEPTH_FORMAT,
            depth_write_enabled: Some(is_kept),
            depth_compare: Some(match is_kept {
                true => wgpu::CompareFunction::Less,
                false => wgpu::CompareFunction::Always,
            }),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState::default(),
        }),
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module,
            entry_point: Some(fragment),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: if output == Output::Event { &event } else { &[] },
        }),
        multiview_mask: None,
        cache: None,
    })
}
