//! `Tissue`.

use pyo3::prelude::*;
use sinew_core::{TissueDescription, TissueKind};

use crate::arrays::numbers_of;
use crate::errors::{into_python, value_error};

/// One ellipsoid tissue in the rest pose.
#[pyclass(frozen, module = "_sinew")]
pub struct Tissue {
    /// The core's.
    pub core: sinew_core::Tissue,
}

#[pymethods]
impl Tissue {
    #[new]
    #[pyo3(signature = (name, kind, origin_bone, insertion_bone, centre, rotation, semi_axes,
        origin_tendon = 0.0, insertion_tendon = 0.0, volume_keeping = 1.0))]
    #[allow(clippy::too_many_arguments)]
    fn new(
        name: String,
        kind: &str,
        origin_bone: i64,
        insertion_bone: i64,
        centre: &Bound<'_, PyAny>,
        rotation: &Bound<'_, PyAny>,
        semi_axes: &Bound<'_, PyAny>,
        origin_tendon: f64,
        insertion_tendon: f64,
        volume_keeping: f64,
    ) -> PyResult<Self> {
        let description = TissueDescription {
            name,
            kind: kind_of(kind)?,
            origin_bone,
            insertion_bone,
            centre: numbers_of("centre", centre)?,
            rotation: numbers_of("rotation", rotation)?,
            semi_axes: numbers_of("semi_axes", semi_axes)?,
            origin_tendon_m: origin_tendon,
            insertion_tendon_m: insertion_tendon,
            volume_keeping,
        };
        Ok(Self {
            core: sinew_core::Tissue::new(description).map_err(into_python)?,
        })
    }

    #[getter]
    fn name(&self) -> &str {
        self.core.name()
    }

    #[getter]
    fn volume(&self) -> f64 {
        self.core.volume()
    }
}

fn kind_of(kind: &str) -> PyResult<TissueKind> {
    match kind {
        "MUSCLE" => Ok(TissueKind::Muscle),
        "BONE" => Ok(TissueKind::Bone),
        "STUFFING" => Ok(TissueKind::Stuffing),
        "SPHERE" => Ok(TissueKind::Sphere),
        _ => Err(value_error(format!(
            "kind: expected MUSCLE, BONE, STUFFING or SPHERE, got {kind:?}"
        ))),
    }
}
