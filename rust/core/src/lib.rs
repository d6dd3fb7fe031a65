//! The core of Sinew: characters with ellipsoid muscles.
//!
//! A [`Skeleton`] in a pose gives a [`Palette`]; a [`Musculature`] of [`Tissue`]s stands on it, and a [`Skin`] bound to that in
//! the rest pose follows every frame. All spaces are the armature's own, in metres, unless a name says mesh; f64 at
//! setup and bind, f32 per vertex. Same input, same bits, on any number of threads.
//!
//! Sources: the 2001 thesis ("thesis") and J. Wilhelms, "Animals with Anatomy" (1997), as corrected in the project's
//! ALGORITHM.

pub mod bake;
mod chain;
mod course;
pub mod ellipsoid;
pub mod error;
pub mod joint_axes;
pub mod measure;
pub mod muscle;
pub mod musculature;
mod path;
pub mod pose;
pub mod posing;
pub mod reach;
pub mod shown;
pub mod skin;
mod smooth;
pub mod surface;
pub mod tissue;
mod wrap;

pub use ellipsoid::nearest_on_ellipsoid;
pub use error::{Error, Result};
pub use joint_axes::MuscleJoint;
pub use musculature::Musculature;
pub use pose::{ColumnMajor, Palette, Skeleton};
pub use posing::{MusclePaths, PosedMusculature};
pub use shown::{AngleOrder, Delta, ShownTissue, Transform};
pub use skin::{
    Anchoring, Carrying, Elasticity, Energy, FrameReport, LinearSkin, PosedModifier, Regional, RestMesh,
    Segments, Skin, SkinOptions, Skinning, WeightRows,
};
pub use surface::{GrowOptions, GrowReport, GrownSkin, Progress, SkinBones, grow};
pub use tissue::{Tissue, TissueDescription, TissueKind};
