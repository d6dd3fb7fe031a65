//! Fitting under the skin and surface transfer (docs/mathematics/fitting.md, Fit under the skin; Surface transfer).
//!
//! Input is the rest pose, in one space, in metres. Results do not depend on the order of meshes, faces or tissues, nor on
//! the number of threads. Wilhelms 1997, sec. 4, places muscles by bones alone; here the skin also bounds them.

mod belly;
mod body_grid;
mod bvh;
mod clearance;
mod face_tree;
mod fill;
mod growing;
mod mirrored_fit;
mod placed_tissue;
mod polygons;
mod skin_surface;
mod surface_transfer;
mod triangle;
mod via_points;

pub(crate) use face_tree::FaceTree;

pub use belly::fit;
pub use body_grid::volume_m3;
pub use clearance::protrusion_m;
pub use fill::fill;
pub use growing::Goal;
pub use mirrored_fit::fit_all;
pub use placed_tissue::{PlacedTissue, Placement};
pub use polygons::{PolygonMesh, Polygons};
pub use skin_surface::{NearestSkin, SkinSurface};
pub use surface_transfer::SurfaceTransfer;
