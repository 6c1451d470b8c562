//! What every engine, SIMD level and backend is tested against: scene corpus, ray sets, the float64
//! oracle and the rule that excuses a difference.

pub mod corpus;
pub mod data;
pub mod examine;
pub mod excuse;
pub mod image;
pub mod oracle;
pub mod random;
pub mod rays;
pub mod suite;
pub mod tolerance;
pub mod turning;
