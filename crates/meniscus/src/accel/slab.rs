//! A ray as box tests want it.

/// A ray prepared for slab tests, in local f32 coordinates with a unit direction.
#[derive(Debug, Clone, Copy)]
pub struct SlabRay {
    /// Start.
    pub origin: [f32; 3],
    /// 1/direction, with zero components replaced by tiny ones so that no NaN arises.
    pub inverse: [f32; 3],
    /// Largest parameter of interest.
    pub t_max: f32,
}

impl SlabRay {
    /// A ray from a unit direction.
    pub fn new(origin: [f32; 3], direction: [f32; 3], t_max: f32) -> Self {
        let inverse = direction.map(|d| {
            let d = if d.abs() < 1e-18 {
                1e-18_f32.copysign(d)
            } else {
                d
            };
            1.0 / d
        });
        Self {
            origin,
            inverse,
            t_max,
        }
    }
}
