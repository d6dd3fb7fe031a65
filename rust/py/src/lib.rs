//! The Rust core of Sinew as the Python module `_sinew`. The stub `_sinew.pyi` documents it.

mod arrays;
mod bake;
mod elasticity;
mod errors;
mod frame_report;
mod functions;
mod grown_skin;
mod linear_skin;
mod linkage;
mod measure;
mod motion;
mod musculature;
mod path;
mod placed_tissues;
mod polygon_mesh;
mod posed_musculature;
mod reach;
mod regional;
mod scalars;
mod shown;
mod skeleton;
mod skin;
mod skin_surface;
mod surface_transfer;
mod threads;
mod tissue;
/// The module and its exports.
#[pyo3::pymodule]
mod _sinew {
    #[pymodule_export]
    use super::bake::{CombinationKeys, KeptSamples, MotionKeys};
    #[pymodule_export]
    use super::elasticity::Elasticity;
    #[pymodule_export]
    use super::errors::SinewError;
    #[pymodule_export]
    use super::frame_report::FrameReport;
    #[pymodule_export]
    use super::functions::nearest_on_ellipsoid;
    #[pymodule_export]
    use super::grown_skin::GrownSkin;
    #[pymodule_export]
    use super::grown_skin::Progress;
    #[pymodule_export]
    use super::linear_skin::LinearSkin;
    #[pymodule_export]
    use super::linkage::{Linkage, joint_angles, joint_rotation};
    #[pymodule_export]
    use super::measure::{DeformedSurface, RestSurface, SkinQuality, SurfaceRegion};
    #[pymodule_export]
    use super::motion::SkinMotion;
    #[pymodule_export]
    use super::musculature::Musculature;
    #[pymodule_export]
    use super::path::{Path, nearest_on_segment};
    #[pymodule_export]
    use super::placed_tissues::PlacedTissues;
    #[pymodule_export]
    use super::polygon_mesh::PolygonMesh;
    #[pymodule_export]
    use super::posed_musculature::PosedMusculature;
    #[pymodule_export]
    use super::reach::{Goal, Reached, reach_clip, reach_once};
    #[pymodule_export]
    use super::regional::Regional;
    #[pymodule_export]
    use super::shown::ShownTissues;
    #[pymodule_export]
    use super::skeleton::Skeleton;
    #[pymodule_export]
    use super::skin::Skin;
    #[pymodule_export]
    use super::skin_surface::SkinSurface;
    #[pymodule_export]
    use super::surface_transfer::SurfaceTransfer;
    #[pymodule_export]
    use super::threads::set_thread_count;
    #[pymodule_export]
    use super::tissue::Tissue;

    #[pymodule_init]
    fn init(_module: &pyo3::Bound<'_, pyo3::types::PyModule>) -> pyo3::PyResult<()> {
        super::threads::enlist_this_thread();
        Ok(())
    }

    #[pymodule_export]
    #[allow(non_upper_case_globals)]
    const __version__: &str = env!("CARGO_PKG_VERSION");
}
