//! The laws of the core, as properties.
#![allow(clippy::unwrap_used)]

mod clamping;
mod correction;
mod elastic;
mod ellipsoid;
mod influence;
mod muscle;
mod refusal;
mod rig;
mod skin;
mod threads;
