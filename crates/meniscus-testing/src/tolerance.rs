//! Every tolerance of the proof, and why it is what it is.

/// A difference is excused where |F − T| ≤ this · max(1, T, Σ|wᵢ|kᵢ) all the way: f32 sums of a few
/// dozen terms of order one are good to about 1e-6, and a near tangent ray turns that into any t.
pub const FIELD: f64 = 1e-5;

/// Where F crosses T clearly, t must be right to this many spacings: a hundredth of what a pixel of a
/// close-up shows.
pub const T_SPACINGS: f64 = 1e-4;

/// … or to this many f32 units in the last place of the largest local coordinate at the hit, or of t
/// while the ray is among the blobs: f32 has no more. A far origin is no excuse, for rays are float64 …
pub const F32_ULPS: f64 = 4.0;

/// … but for this many f64 units of the origin and of t.
pub const F64_ULPS: f64 = 8.0;

/// Angle in radians between an engine's normal and −∇F at the engine's own t, for a gradient without
/// cancellation: 0.06 degrees, a tenth of what shading in 8 bits can show.
pub const NORMAL_RADIANS: f64 = 1e-3;

/// Where contributions cancel the angle may grow by Σ|wᵢ∇kᵢ|/|∇F|; past this ratio a normal is not
/// checked, because f32 does not determine it.
pub const NORMAL_CONDITION: f64 = 1e3;

/// The strongest blob may be one whose |wᵢkᵢ| is within this fraction of the largest.
pub const STRONGEST: f64 = 1e-4;

/// The oracle's own numbers: roots to this fraction of an interval between events …
pub const ORACLE_ROOT: f64 = 1e-13;

/// … and polynomial coefficients to this fraction of Σ|wᵢ| (interpolation at nine nodes multiplies
/// the rounding of float64 by less than a thousand).
pub const ORACLE_SUM: f64 = 1e-12;

/// The spacing between neighbouring f32 at `x`.
pub fn f32_ulp(x: f64) -> f64 {
    let x = (x.abs() as f32).min(f32::MAX);
    f64::from(x.next_up().min(f32::MAX)) - f64::from(x.next_up().min(f32::MAX).next_down())
}
