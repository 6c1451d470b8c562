//! Words over as many buffers as it takes, since a binding has a largest size.

use crate::device::Device;
use crate::error::GpuError;
use crate::tracer::TracerOptions;

/// 16 bytes.
pub(crate) type Word = [u32; 4];

/// Bytes of a word.
pub(crate) const WORD_BYTES: u64 = size_of::<Word>() as u64;

/// Words of the largest chunk as a power of two: 2 GiB.
const MOST_CHUNK_BITS: u32 = 27;

/// Bytes written at once, so that what is on its way stays small.
const PORTION: usize = 16 << 20;

/// Words on a device.
#[derive(Debug)]
pub(crate) struct Chunks {
    pub(crate) buffers: Vec<wgpu::Buffer>,
    /// Words per full buffer, as a power of two.
    pub(crate) bits: u32,
    pub(crate) words: usize,
}

impl Chunks {
    /// Buffers for `words`, no more than the device binds beside `others`.
    pub(crate) fn new(
        device: &Device,
        words: usize,
        others: u32,
        options: TracerOptions,
    ) -> Result<Self, GpuError> {
        let bits = chunk_bits(device, options);
        let chunk_words = 1_usize << bits;
        let count = words.div_ceil(chunk_words);
        let bytes = words as u64 * WORD_BYTES;
        let limits = &device.limits;
        let most = limits
            .max_storage_buffers_per_shader_stage
            .saturating_sub(others);
        if count > most as usize || u32::try_from(words).is_err() {
            let message = format!(
                "it takes {count} buffers of {} bytes and can bind {most}",
                chunk_words as u64 * WORD_BYTES
            );
            return Err(device.too_large(bytes, message));
        }
        use wgpu::BufferUsages as Usage;
        let buffers = device.within_memory(bytes, || {
            let chunks = (0..count).map(|chunk| {
                let held = (words - chunk * chunk_words).min(chunk_words);
                device.device.create_buffer(&wgpu::BufferDescriptor {
                    label: Some("field"),
                    size: held as u64 * WORD_BYTES,
                    usage: Usage::STORAGE | Usage::COPY_DST | Usage::COPY_SRC,
                    mapped_at_creation: false,
                })
            });
            chunks.collect()
        })?;
        Ok(Self {
            buffers,
            bits,
            words,
        })
    }

    /// Writes all words.
    pub(crate) fn write(&self, device: &Device, words: &[Word]) -> Result<(), GpuError> {
        for (buffer, words) in self.buffers.iter().zip(words.chunks(1 << self.bits)) {
            let bytes: &[u8] = bytemuck::cast_slice(words);
            for (portion, bytes) in bytes.chunks(PORTION).enumerate() {
                let at = (portion * PORTION) as u64;
                device.queue.write_buffer(buffer, at, bytes);
                if bytes.len() == PORTION {
                    device.queue.submit([]);
                    device.wait()?;
                }
            }
        }
        Ok(())
    }

    /// Memory taken.
    pub(crate) fn bytes(&self) -> u64 {
        self.words as u64 * WORD_BYTES
    }
}

/// Words per buffer, as a power of two.
fn chunk_bits(device: &Device, options: TracerOptions) -> u32 {
    let largest = device
        .largest_binding()
        .min(options.largest_chunk_bytes.unwrap_or(u64::MAX));
    (largest / WORD_BYTES).max(1).ilog2().min(MOST_CHUNK_BITS)
}
