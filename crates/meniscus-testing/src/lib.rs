//! What every engine, SIMD level and backend is tested against: scene corpus, ray sets, the float64
//! oracle and the rule that excuses a difference.

pub mod data;
