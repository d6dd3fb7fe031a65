//! `Musculature`.

use std::sync::Arc;

use pyo3::prelude::*;
use sinew_core::Palette;

use crate::arrays::{Input, Length, Output, Shape};
use crate::errors::into_python;
use crate::posed_musculature::PosedMusculature;
use crate::skeleton::Skeleton;
use crate::threads::in_pool;
use crate::tissue::Tissue;

/// All tissues of one rig.
#[pyclass(frozen, module = "_sinew")]
pub struct Musculature {
    /// The core's.
    pub core: Arc<sinew_core::Musculature>,
}

#[pymethods]
impl Musculature {
    #[new]
    fn new(skeleton: &Skeleton, tissues: Vec<PyRef<'_, Tissue>>) -> PyResult<Self> {
        let tissues = tissues.iter().map(|tissue| tissue.core.clone()).collect();
        let core = sinew_core::Musculature::new(skeleton.core.clone(), tissues).map_err(into_python)?;
        Ok(Self { core: Arc::new(core) })
    }

    fn __len__(&self) -> usize {
        self.core.len()
    }

    fn pose<'py>(
        &self,
        py: Python<'py>,
        pose: &Bound<'py, PyAny>,
        tension: &Bound<'py, PyAny>,
        out: &Bound<'py, PyAny>,
    ) -> PyResult<PosedMusculature> {
        let matrix = [
            Length::Named('T', self.core.len()),
            Length::Exactly(4),
            Length::Exactly(4),
        ];
        let (pose, tension) = (pose_of(&self.core, pose)?, tension_of(&self.core, tension)?);
        let mut out = Output::<f32>::new("out", out, Shape(&matrix))?.view(&[&pose, &tension])?;
        let (pose, tension, out) = (pose.groups()?, tension.numbers()?, out.groups()?);
        let posed = in_pool(py, || {
            let posed = self
                .core
                .pose(&Palette::new(self.core.skeleton(), pose)?, tension)?;
            for (place, matrix) in out.iter_mut().zip(&posed.matrices) {
                *place = matrix.as_mat4().to_cols_array();
            }
            Ok(posed)
        });
        PosedMusculature::new(py, &self.core, posed.map_err(into_python)?)
    }
}

/// The argument `pose` for a rig of `musculature`.
pub fn pose_of<'py>(
    musculature: &sinew_core::Musculature,
    pose: &Bound<'py, PyAny>,
) -> PyResult<Input<'py, f32>> {
    let bones = Length::Named('B', musculature.skeleton().len());
    Input::new(
        "pose",
        pose,
        Shape(&[bones, Length::Exactly(4), Length::Exactly(4)]),
    )
}

/// The argument `tension` for `musculature`.
pub fn tension_of<'py>(
    musculature: &sinew_core::Musculature,
    tension: &Bound<'py, PyAny>,
) -> PyResult<Input<'py, f32>> {
    Input::new(
        "tension",
        tension,
        Shape(&[Length::Named('T', musculature.len())]),
    )
}
