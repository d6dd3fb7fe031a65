//! The laws of the core, as property tests.
#![allow(clippy::unwrap_used)]

mod bake;
mod both_skinnings;
mod clamping;
mod contact;
mod correction;
mod creases;
mod curved;
mod dirty;
mod elastic;
mod ellipsoid;
mod extremes;
mod fit_bodies;
mod fit_fill;
mod fit_surface;
mod fit_tissues;
mod fixtures;
mod garments;
mod grown_pieces;
mod grown_skin;
mod influence;
mod joint_axes;
mod linear;
mod measure;

mod muscle;
mod muscle_stack;
mod reach;
mod reach_clip;
mod reach_linkage;
mod reach_poses;
mod refusal;
mod regional;
mod relaxation;
mod safeguard;
mod shown;
mod skin;
mod surface_transfer;
mod threads;
mod vertex_order;
mod welded;
