//! The core of Sinew: characters whose skin is moved by ellipsoid muscles.
//!
//! A [`Skeleton`] in a pose gives a [`Palette`]. A [`Musculature`] is a list of [`Tissue`]s on that skeleton.
//! A [`Skin`] is bound to a musculature in the rest pose and deforms in every frame.
//!
//! Conventions: armature space and metres, unless a name says mesh space or has another unit as its suffix;
//! angles in radians; f64 at setup and bind, f32 per vertex in a frame. The same input gives the same bits on
//! any number of threads.
//!
//! Comments cite the pages of `docs/mathematics/` in the repository as `mathematics/<page>, <section>`. "The
//! thesis" is G. Arabacı, Bilkent University, 2001; `mathematics/references.md` lists all literature.

pub mod bake;
pub mod ellipsoid;
pub mod error;
mod faults;
pub mod fit;
mod math;
pub mod measure;
pub mod muscles;
mod parallel;
pub mod pose;
pub mod reach;
pub mod skin;
pub mod surface;

pub use ellipsoid::nearest_on_ellipsoid;
pub use error::{Error, Result};
pub use math::segment::nearest_on_segment;
pub use muscles::display_delta::{AngleOrder, Delta, ShownTissue, Transform};
pub use muscles::joint_axes::MuscleJoint;
pub use muscles::musculature::Musculature;
pub use muscles::polyline::Polyline;
pub use muscles::posing::{MusclePaths, PosedMusculature};
pub use muscles::tissue::{Tissue, TissueDescription, TissueKind};
pub use pose::{ColumnMajor, Palette, Skeleton};
pub use skin::{
    Anchoring, Elasticity, Energy, FrameReport, LinearSkin, MotionSource, PosedModifier, Regional, RestMesh,
    Segments, Skin, SkinOptions, Skinning, WeightRows,
};
pub use surface::{GrowOptions, GrowReport, GrownSkin, Progress, SkinBones, grow};
