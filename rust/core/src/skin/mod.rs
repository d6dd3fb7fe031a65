//! The skin: a mesh bound to a musculature (mathematics/binding.md), then deformed or corrected in every
//! frame (mathematics/skinning.md, One frame; mathematics/correction.md).

mod binding;
mod chunk_needs;
mod contact;
mod correction;
mod dirty;
mod frame_report;
mod garment;
mod mesh;
mod output_chunks;
mod pipeline;
mod relaxation;
mod safeguard;
mod settings;
#[expect(
    clippy::module_inception,
    reason = "the bound skin, next to the stages of a frame"
)]
mod skin;
mod skinning;
mod tissue_change;
mod welded_output;
mod workspace;

pub use self::frame_report::FrameReport;
pub use self::mesh::regional::Regional;
pub use self::mesh::rest_mesh::RestMesh;
pub use self::settings::bind::{Anchoring, MotionSource, SkinOptions, Skinning};
pub use self::settings::elasticity::{Elasticity, Energy};
pub use self::settings::segments::Segments;
pub use self::skin::Skin;
pub use self::skinning::fit_weights::WeightRows;
pub use self::skinning::linear_skin::LinearSkin;
pub use self::skinning::posed_modifier::PosedModifier;
