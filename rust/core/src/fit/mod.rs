//! Fitting under the skin: rays, inside tests and nearest points of a skin at rest, how thick a tissue may be in its place,
//! and what one surface takes over from another.
//!
//! Everything is the rest pose, in one space, in metres. Nothing found depends on the order of meshes, faces or tissues, nor on
//! the number of threads. Wilhelms 1997, sec. 4, places muscles by bones alone; here the skin bounds them too.

mod belly;
mod bvh;
mod detour;
mod face_tree;
mod pairs;
mod placed_tissue;
mod polygons;
mod room;
mod skin_surface;
mod transfer;
mod triangle;

pub use belly::fit;
pub use pairs::fit_all;
pub use placed_tissue::{PlacedTissue, Placement};
pub use polygons::{PolygonMesh, Polygons};
pub use room::protrusion_m;
pub use skin_surface::{NearestSkin, SkinSurface};
pub use transfer::SurfaceTransfer;
