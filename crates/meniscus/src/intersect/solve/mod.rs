//! Solving for the first crossing of a ray in f32, shared by the engines that gather blobs: the ray's
//! local form, the solver with its proof, and the care that a ray's own start takes.

mod active;
mod along;
mod departure;
mod fine;
mod local;
mod search;
mod solver;
mod start;

pub(super) use active::Active;
pub(super) use fine::meets_fine_blob;
pub use local::ClippedRay;
pub(super) use local::{LocalRay, local_ray};
pub(super) use search::{Question, Search};
pub(super) use solver::{Entry, FirstCrossing, NOISE, Pending, Segment, Solver, Verdict};
pub use start::Tolerances;
pub(super) use start::{near_start, start_margin};

/// Accuracy of t that the solver aims at, in spacings.
pub(super) const T_TOLERANCE_SPACINGS: f32 = 2e-5;

/// Runs `$body` with the field's kernel, primitive and SIMD token as types: the one dispatch.
macro_rules! specialised {
    ($blobs:expr, $simd:ident, $kernel:ident, $primitive:ident => $body:expr) => {
        match &$blobs.field.shapes {
            $crate::primitive::Shapes::Balls(_) => {
                $crate::with_kernel!($blobs.field.kernel, $kernel => {
                    type $primitive = $crate::primitive::Ball;
                    $crate::at_level!($blobs.level, $simd => $body)
                })
            }
            $crate::primitive::Shapes::Ellipsoids(_) => {
                $crate::with_kernel!($blobs.field.kernel, $kernel => {
                    type $primitive = $crate::primitive::Ellipsoid;
                    $crate::at_level!($blobs.level, $simd => $body)
                })
            }
        }
    };
}
pub(super) use specialised;
