//! The laws of the core, as property tests.
#![allow(clippy::unwrap_used)]

mod bake;
mod bodies;
mod clamping;
mod collision;
mod contact;
mod correction;
mod creases;
mod curved;
mod curved_rig;
mod elastic;
mod ellipsoid;
mod extremes;
mod grown_ellipsoids;
mod grown_pieces;
mod grown_skin;
mod influence;
mod joint_axes;
mod linear;
mod measure;
mod muscle;
mod order;
mod reach;
mod reach_clip;
mod reach_linkage;
mod reach_poses;
mod reach_rig;
mod refusal;
mod regional;
mod relaxation;
mod rig;
mod shown;
mod skin;
mod threads;
mod unchanged;
