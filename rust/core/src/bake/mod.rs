//! Keeping a moving skin as few shapes: which samples of it are needed, and how they are blended (ALGORITHM 11).
//!
//! Nothing here knows bones: a sample is what a skin's corrections are at one value of something that rises, a frame or
//! the angle of a joint. Same bits on any number of threads.

mod combination;
mod corrective;
mod error_metric;
mod reduce;

pub use combination::{CombinationKeys, Grid};
pub use corrective::MotionKeys;
pub use error_metric::ErrorMetric;
pub use reduce::{KeptSamples, Samples};
