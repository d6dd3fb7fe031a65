//! Representing a moving skin by few shapes: which samples are needed, and how they are blended
//! (mathematics/baking.md).
//!
//! Nothing here depends on bones. A sample is the corrections of a skin at one value of an increasing
//! parameter: a frame, or the angle of a joint. The same input gives the same bits on any number of threads.

mod combination;
mod corrective;
mod error_metric;
mod reduce;

pub use combination::{CombinationKeys, Grid};
pub use corrective::MotionKeys;
pub use error_metric::ErrorMetric;
pub use reduce::{KeptSamples, Samples};
