//! The radix sort's buffers and passes.

use super::program::Sort;
use super::uniform;
use crate::device::Device;
use crate::stage::dispatch;

/// Keys of a block: `ROUNDS` × `DIGITS` in `shaders/accel/build/sort.wgsl`.
const BLOCK: u32 = 16 * DIGITS;

/// Values of a digit.
const DIGITS: u32 = 256;

/// Bits of a digit.
const DIGIT_BITS: u32 = 8;

/// Bits of the keys. The number of passes is even, so what is sorted ends where it began.
const KEY_BITS: u32 = 64;

/// Bytes of a key.
const KEY_BYTES: u64 = 8;

/// Storage buffers of a pass.
pub(super) const BUFFERS: u32 = 6;

/// Whether keys fit into buffers of `largest` bytes.
pub(super) fn fits(count: u32, largest: u64) -> bool {
    u64::from(count) * KEY_BYTES <= largest
}

/// Keys and values on a device.
#[derive(Debug)]
pub(super) struct Sorting {
    pub(super) keys: wgpu::Buffer,
    pub(super) values: wgpu::Buffer,
    blocks: u32,
    passes: Vec<wgpu::BindGroup>,
    bytes: u64,
}

impl Sorting {
    pub(super) fn new(device: &Device, sort: &Sort, count: u32) -> Self {
        let blocks = count.div_ceil(BLOCK);
        let mut bytes = 0;
        let mut buffer = |size: u64| {
            bytes += size;
            device.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("sort"),
                size,
                usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC,
                mapped_at_creation: false,
            })
        };
        let keys = [(); 2].map(|()| buffer(u64::from(count) * KEY_BYTES));
        let values = [(); 2].map(|()| buffer(u64::from(count) * 4));
        let counts = buffer(u64::from(blocks * DIGITS) * 4);
        let totals = buffer(u64::from(DIGITS) * 4);
        let passes = (0..KEY_BITS / DIGIT_BITS).map(|pass| {
            let params = uniform(device, [count, blocks, pass * DIGIT_BITS, 0, 0, 0, 0, 0]);
            let (from, to) = (pass as usize % 2, (pass as usize + 1) % 2);
            let buffers = [
                &params,
                &keys[from],
                &values[from],
                &keys[to],
                &values[to],
                &counts,
                &totals,
            ];
            sort.bindings.group(&device.device, buffers)
        });
        let passes = passes.collect();
        let ([keys, _], [values, _]) = (keys, values);
        Self {
            keys,
            values,
            blocks,
            passes,
            bytes,
        }
    }

    pub(super) fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Sorts the keys and their values.
    pub(super) fn run(&self, device: &Device, sort: &Sort, pass: &mut wgpu::ComputePass<'_>) {
        for group in &self.passes {
            dispatch(device, pass, &sort.count, group, self.blocks);
            dispatch(device, pass, &sort.scan, group, DIGITS);
            dispatch(device, pass, &sort.scatter, group, self.blocks);
        }
    }
}
