//! Buffers that a round of rays takes on the device; kept with the device from round to round.

use super::programs::{DEPTH_FORMAT, EVENT_FORMAT};
use super::times::Clock;
use crate::device::Device;
use crate::error::GpuError;
use meniscus::scene::PeelVariant;
use wgpu::BufferUsages as Usage;

/// Bytes of the parameters.
pub(super) const PARAMS_BYTES: u64 = 160;
pub(super) const RAY_BYTES: u64 = 64;
pub(super) const HIT_BYTES: u64 = 32;
const STATE_BYTES: u64 = 32;
const PAIR_BYTES: u64 = 8;
const GROUP_BYTES: u64 = 16;

/// What a room is made for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct RoomKind {
    pub(super) variant: PeelVariant,
    /// Rays, a multiple of those of a group.
    pub(super) slots: u32,
    pub(super) groups: u32,
    /// Balls that a ray may meet at a time.
    pub(super) capacity: u32,
}

/// The buffers.
#[derive(Debug)]
pub(super) struct Room {
    pub(super) kind: RoomKind,
    pub(super) params: wgpu::Buffer,
    pub(super) rays: wgpu::Buffer,
    pub(super) hits: wgpu::Buffer,
    pub(super) groups: wgpu::Buffer,
    pub(super) tiles: wgpu::Buffer,
    pub(super) counts: wgpu::Buffer,
    pub(super) starts: wgpu::Buffer,
    pub(super) drawing: wgpu::Buffer,
    pub(super) pairs: wgpu::Buffer,
    /// Pairs that there is room for.
    pub(super) most_pairs: u32,
    pub(super) own: Own,
    pub(super) back: wgpu::Buffer,
    pub(super) clock: Option<Clock>,
}

/// What only one variant has.
#[derive(Debug)]
pub(super) enum Own {
    /// The blobs that rays meet, and which they are.
    Tiles {
        met: [wgpu::Buffer; 2],
    },
    Sprites(Box<Layers>),
}

/// What the raster variant has.
#[derive(Debug)]
pub(super) struct Layers {
    pub(super) states: wgpu::Buffer,
    pub(super) lists: wgpu::Buffer,
    pub(super) finished: wgpu::Buffer,
    pub(super) seen: wgpu::Buffer,
    pub(super) depths: wgpu::TextureView,
    pub(super) events: wgpu::TextureView,
    /// Groups side by side in the textures.
    pub(super) across: u32,
    /// Side of the textures in pixels.
    pub(super) side: u32,
}

fn buffer(device: &Device, label: &str, size: u64, usage: Usage) -> wgpu::Buffer {
    device.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size: size.max(16),
        usage,
        mapped_at_creation: false,
    })
}

impl Room {
    /// Room for `kind`, with `most_pairs` pairs.
    pub(super) fn new(device: &Device, kind: RoomKind, most_pairs: u32) -> Result<Self, GpuError> {
        let (slots, groups) = (u64::from(kind.slots), u64::from(kind.groups));
        let bytes = slots * (RAY_BYTES + 2 * HIT_BYTES + 20 * u64::from(kind.capacity))
            + u64::from(most_pairs) * PAIR_BYTES;
        device.within_memory(bytes, || {
            let filled =
                |label, size| buffer(device, label, size, Usage::STORAGE | Usage::COPY_DST);
            let back_bytes = slots * HIT_BYTES + 4 * groups + 16 + Clock::BYTES;
            Self {
                kind,
                params: buffer(
                    device,
                    "params",
                    PARAMS_BYTES,
                    Usage::UNIFORM | Usage::COPY_DST,
                ),
                rays: filled("rays", slots * RAY_BYTES),
                hits: buffer(
                    device,
                    "hits",
                    slots * HIT_BYTES,
                    Usage::STORAGE | Usage::COPY_SRC,
                ),
                groups: filled("groups", groups * GROUP_BYTES),
                tiles: filled("tiles", 1 << 12),
                counts: filled("counts", 4 * groups),
                starts: buffer(
                    device,
                    "starts",
                    4 * (groups + 1),
                    Usage::STORAGE | Usage::COPY_SRC,
                ),
                drawing: buffer(device, "drawing", 16, Usage::STORAGE | Usage::INDIRECT),
                pairs: pairs(device, most_pairs),
                most_pairs,
                own: Own::new(device, kind, most_pairs),
                back: buffer(
                    device,
                    "back",
                    back_bytes,
                    Usage::MAP_READ | Usage::COPY_DST,
                ),
                clock: Clock::new(device),
            }
        })
    }

    /// Makes room for more pairs.
    pub(super) fn grow_pairs(&mut self, device: &Device, most: u32) -> Result<(), GpuError> {
        let bytes = u64::from(most) * (PAIR_BYTES + 4);
        self.pairs = device.within_memory(bytes, || pairs(device, most))?;
        if let Own::Sprites(layers) = &mut self.own {
            layers.seen = device.within_memory(bytes, || seen(device, most))?;
        }
        self.most_pairs = most;
        Ok(())
    }

    /// Makes room for a grid of `cells` tiles.
    pub(super) fn fit_tiles(&mut self, device: &Device, cells: usize) -> Result<(), GpuError> {
        let bytes = 4 * cells as u64;
        if self.tiles.size() < bytes {
            let usage = Usage::STORAGE | Usage::COPY_DST;
            let size = bytes.next_power_of_two();
            self.tiles = device.within_memory(size, || buffer(device, "tiles", size, usage))?;
        }
        Ok(())
    }

    /// The most pairs that an adapter has room for.
    pub(super) fn pairs_limit(device: &Device) -> u32 {
        let limits = &device.limits;
        let largest = limits
            .max_storage_buffer_binding_size
            .min(limits.max_buffer_size);
        // Events are numbered by twice the pair.
        (largest / PAIR_BYTES).min(1 << 30) as u32
    }
}

fn pairs(device: &Device, most: u32) -> wgpu::Buffer {
    buffer(
        device,
        "pairs",
        u64::from(most) * PAIR_BYTES,
        Usage::STORAGE,
    )
}

fn seen(device: &Device, most: u32) -> wgpu::Buffer {
    buffer(
        device,
        "seen",
        u64::from(most) * 4,
        Usage::STORAGE | Usage::COPY_DST,
    )
}

impl Own {
    fn new(device: &Device, kind: RoomKind, most_pairs: u32) -> Self {
        let met = u64::from(kind.slots) * u64::from(kind.capacity);
        match kind.variant {
            PeelVariant::Tiles => Self::Tiles {
                met: [16, 4].map(|bytes| buffer(device, "met", met * bytes, Usage::STORAGE)),
            },
            PeelVariant::Sprites => {
                let across = (1..).find(|a| a * a >= kind.groups).unwrap_or(1);
                let side = across * super::shader::tile(kind.variant);
                let texture = |label, format| {
                    let texture = device.device.create_texture(&wgpu::TextureDescriptor {
                        label: Some(label),
                        size: wgpu::Extent3d {
                            width: side,
                            height: side,
                            depth_or_array_layers: 1,
                        },
                        mip_level_count: 1,
                        sample_count: 1,
                        dimension: wgpu::TextureDimension::D2,
                        format,
                        usage: wgpu::TextureUsages::RENDER_ATTACHMENT
                            | wgpu::TextureUsages::TEXTURE_BINDING,
                        view_formats: &[],
                    });
                    texture.create_view(&wgpu::TextureViewDescriptor::default())
                };
                let counted = Usage::STORAGE | Usage::COPY_DST | Usage::COPY_SRC;
                Self::Sprites(Box::new(Layers {
                    states: buffer(
                        device,
                        "states",
                        u64::from(kind.slots) * STATE_BYTES,
                        Usage::STORAGE,
                    ),
                    lists: buffer(device, "lists", met * 4, Usage::STORAGE),
                    finished: buffer(device, "finished", 4 * u64::from(kind.groups), counted),
                    seen: seen(device, most_pairs),
                    depths: texture("depths", DEPTH_FORMAT),
                    events: texture("events", EVENT_FORMAT),
                    across,
                    side,
                }))
            }
        }
    }
}

/// Bytes written at once, so that what is on its way stays small.
const PORTION: usize = 16 << 20;

/// A buffer that holds `bytes`.
pub(super) fn stored(device: &Device, bytes: &[u8]) -> Result<wgpu::Buffer, GpuError> {
    let size = bytes.len() as u64;
    let made = device.within_memory(size, || {
        buffer(device, "balls", size, Usage::STORAGE | Usage::COPY_DST)
    })?;
    for (portion, bytes) in bytes.chunks(PORTION).enumerate() {
        device
            .queue
            .write_buffer(&made, (portion * PORTION) as u64, bytes);
        if bytes.len() == PORTION {
            device.queue.submit([]);
            device.wait()?;
        }
    }
    Ok(made)
}
