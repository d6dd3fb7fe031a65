//! The laws of the core, as properties.
#![allow(clippy::unwrap_used)]

mod clamping;
mod correction;
mod curved;
mod curved_rig;
mod elastic;
mod ellipsoid;
mod grown_skin;
mod influence;
mod muscle;
mod refusal;
mod rig;
mod skin;
mod threads;
