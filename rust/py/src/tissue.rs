//! `Tissue`.

use pyo3::prelude::*;
use sinew_core::{TissueDescription, TissueKind};

use crate::arrays::numbers_of;
use crate::errors::{into_python, value_error};
use crate::scalars::{Real, Whole, text_of};

/// One tissue in the rest pose.
#[pyclass(frozen, module = "_sinew")]
pub struct Tissue {
    /// The tissue of the core.
    pub core: sinew_core::Tissue,
}

#[pymethods]
impl Tissue {
    #[new]
    #[pyo3(signature = (name, kind, origin_bone, insertion_bone, centre, rotation, semi_axes,
        origin_tendon = Real::of(0.0), insertion_tendon = Real::of(0.0),
        volume_keeping = Real::of(1.0), *, via_points = None, wraps = None))]
    #[allow(clippy::too_many_arguments)]
    fn new(
        name: String,
        kind: &str,
        origin_bone: Whole,
        insertion_bone: Whole,
        centre: &Bound<'_, PyAny>,
        rotation: &Bound<'_, PyAny>,
        semi_axes: &Bound<'_, PyAny>,
        origin_tendon: Real,
        insertion_tendon: Real,
        volume_keeping: Real,
        via_points: Option<&Bound<'_, PyAny>>,
        wraps: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let description = TissueDescription {
            name,
            kind: kind_of(kind)?,
            origin_bone: origin_bone.named("origin_bone")?,
            insertion_bone: insertion_bone.named("insertion_bone")?,
            centre: numbers_of("centre", centre)?,
            rotation: numbers_of("rotation", rotation)?,
            semi_axes: numbers_of("semi_axes", semi_axes)?,
            origin_tendon_m: origin_tendon.named("origin_tendon")?,
            insertion_tendon_m: insertion_tendon.named("insertion_tendon")?,
            volume_keeping: volume_keeping.named("volume_keeping")?,
            via_points: via_points.map_or(Ok(vec![]), via_points_of)?,
            wraps: wraps.map_or(Ok(vec![]), names_of)?,
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

/// The kind of that name.
pub(crate) fn kind_of(kind: &str) -> PyResult<TissueKind> {
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

/// Pairs of a bone index and a point, from any sequence of pairs.
fn via_points_of(argument: &Bound<'_, PyAny>) -> PyResult<Vec<(i64, [f64; 3])>> {
    let refused = |_| {
        refusal(
            "via_points: expected pairs of a bone's index and a point",
            argument,
        )
    };
    let pairs = argument
        .extract::<Vec<(i64, Bound<'_, PyAny>)>>()
        .map_err(refused)?;
    let point = |(bone, point): (i64, Bound<'_, PyAny>)| Ok((bone, numbers_of("via_points", &point)?));
    pairs.into_iter().map(point).collect()
}

/// Names, from any sequence of strings but a string.
fn names_of(argument: &Bound<'_, PyAny>) -> PyResult<Vec<String>> {
    let refused = |_| refusal("wraps: expected a sequence of names", argument);
    argument.extract().map_err(refused)
}

fn refusal(expected: &str, argument: &Bound<'_, PyAny>) -> PyErr {
    value_error(format!("{expected}, got {}", text_of(argument)))
}
