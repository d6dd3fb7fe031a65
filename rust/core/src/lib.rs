//! The core of Sinew: characters with ellipsoid muscles.
//!
//! A [`Skeleton`] in a pose gives a [`Palette`]; a [`Musculature`] of [`Tissue`]s stands on it, and a [`Skin`] bound to that in
//! the rest pose follows every frame. All spaces are the armature's own, in metres, unless a name says mesh; f64 at
//! setup and bind, f32 per vertex. Same input, same bits, on any number of threads.
//!
//! Sources: the 2001 thesis ("thesis") and J. Wilhelms, "Animals with Anatomy" (1997), as corrected in the project's
//! ALGORITHM.

pub mod bake;
pub mod ellipsoid;
pub mod error;
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
pub use muscles::joint_axes::MuscleJoint;
pub use muscles::musculature::Musculature;
pub use muscles::posing::{MusclePaths, PosedMusculature};
pub use muscles::shown::{AngleOrder, Delta, ShownTissue, Transform};
pub use muscles::tissue::{Tissue, TissueDescription, TissueKind};
pub use pose::{ColumnMajor, Palette, Skeleton};
pub use skin::{
    AnchorMode, Anchoring, Elasticity, Energy, FrameReport, LinearSkin, PosedModifier, Regional, RestMesh,
    Segments, Skin, SkinOptions, Skinning, WeightRows,
};
pub use surface::{GrowOptions, GrowReport, GrownSkin, Progress, SkinBones, grow};
