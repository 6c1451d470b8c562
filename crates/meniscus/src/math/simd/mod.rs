//! SIMD levels: which instruction set the engine runs on, chosen once at run time.

pub use fearless_simd::Level;

use fearless_simd::prelude::*;
use fearless_simd::{Simd, SimdBase, f32x16, u32x16};

/// A level by name, as `--simd` takes it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SimdLevel {
    /// The widest that the machine has.
    #[default]
    Auto,
    /// SSE2 on x86-64, plain scalar code elsewhere.
    Baseline,
    /// SSE2 (x86-64): what SSE4.2 machines run too.
    Sse2,
    /// AVX2 with FMA.
    Avx2,
    /// AVX-512 (Ice Lake set).
    Avx512,
    /// NEON (AArch64).
    Neon,
}

impl SimdLevel {
    /// Every level with its command-line name.
    pub const ALL: [(&'static str, Self); 6] = [
        ("auto", Self::Auto),
        ("baseline", Self::Baseline),
        ("sse2", Self::Sse2),
        ("avx2", Self::Avx2),
        ("avx512", Self::Avx512),
        ("neon", Self::Neon),
    ];

    /// The level as the engine takes it, or `None` where this machine lacks it.
    pub fn resolve(self) -> Option<Level> {
        let best = Level::new();
        match self {
            Self::Auto => Some(best),
            Self::Baseline => Some(Level::baseline()),
            #[cfg(target_arch = "x86_64")]
            Self::Sse2 => Some(Level::baseline()),
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Self::Avx2 => best.as_avx2().map(Level::Avx2),
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Self::Avx512 => best.as_avx512().map(Level::Avx512),
            #[cfg(target_arch = "aarch64")]
            Self::Neon => best.as_neon().map(Level::Neon),
            #[allow(unreachable_patterns, reason = "the other architectures' levels")]
            _ => None,
        }
    }
}

/// Runs `$body` with `$simd` bound to the token of `$level`: the one run-time dispatch. Every engine
/// is compiled once per level, so SSE4.2 runs as SSE2: it would add a quarter to the code for nothing.
#[macro_export]
macro_rules! at_level {
    ($level:expr, $simd:ident => $body:expr) => {{
        let level: $crate::math::simd::Level = $level;
        #[cfg(target_arch = "x86_64")]
        {
            if let Some($simd) = level.as_avx512() {
                $body
            } else if let Some($simd) = level.as_avx2() {
                $body
            } else if let Some($simd) = level.as_sse2() {
                $body
            } else {
                unreachable!("x86-64 has SSE2")
            }
        }
        #[cfg(not(target_arch = "x86_64"))]
        fearless_simd::dispatch!(level, $simd => $body)
    }};
}

/// The name of a resolved level, as `--stats` prints it.
pub fn level_name(level: Level) -> &'static str {
    match level {
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        Level::Sse2(_) | Level::Sse4_2(_) => "sse2",
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        Level::Avx2(_) => "avx2",
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        Level::Avx512(_) => "avx512",
        #[cfg(target_arch = "aarch64")]
        Level::Neon(_) => "neon",
        _ => "baseline",
    }
}

/// `[f(0), f(1), f(2)]`, always inlined: `array::map` is not, and what is not inlined into a
/// function compiled for a SIMD level runs without that level's instructions. Mark the closure
/// `#[inline(always)]` too.
#[inline(always)]
pub fn xyz<T>(mut f: impl FnMut(usize) -> T) -> [T; 3] {
    [f(0), f(1), f(2)]
}

/// Three splatted numbers.
#[inline(always)]
pub fn splat3<S: Simd, V: SimdBase<S, Element = f32>>(simd: S, v: [f32; 3]) -> [V; 3] {
    [
        V::splat(simd, v[0]),
        V::splat(simd, v[1]),
        V::splat(simd, v[2]),
    ]
}

/// Of sixteen lanes the index that stands beside the largest strength; of several that are as large, the
/// smallest.
#[inline(always)]
pub fn index_of_largest<S: Simd>(simd: S, strengths: f32x16<S>, indices: u32x16<S>) -> u32 {
    let largest = f32x16::splat(simd, strengths.reduce_max());
    let none = u32x16::splat(simd, u32::MAX);
    strengths
        .simd_eq(largest)
        .select(indices, none)
        .reduce_min()
}
