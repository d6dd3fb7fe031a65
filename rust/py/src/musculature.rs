//! `Musculature`.

use std::sync::Arc;

use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray1, PyArray2};
use pyo3::prelude::*;
use sinew_core::{ColumnMajor, Palette};

use crate::arrays::{Input, Length, Output, Shape};
use crate::errors::into_python;
use crate::posed_musculature::PosedMusculature;
use crate::skeleton::Skeleton;
use crate::threads::in_pool;
use crate::tissue::Tissue;

/// All tissues of one rig.
#[pyclass(frozen, module = "_sinew")]
pub struct Musculature {
    /// The musculature of the core.
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

    #[getter]
    fn ellipsoid_count(&self) -> usize {
        self.core.ellipsoids().len()
    }

    #[getter]
    fn ellipsoid_tissue<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i32>> {
        let owners = self.core.ellipsoid_tissues().iter();
        owners
            .map(|&tissue| tissue as i32)
            .collect::<Vec<_>>()
            .into_pyarray(py)
    }

    fn joints(&self, py: Python<'_>) -> Vec<(usize, (f64, f64, f64), bool)> {
        let joints = in_pool(py, || self.core.joints());
        let plain = joints
            .iter()
            .map(|joint| (joint.child, joint.axis.into(), joint.bends_one_way));
        plain.collect()
    }

    fn pose<'py>(
        &self,
        py: Python<'py>,
        pose: &Bound<'py, PyAny>,
        tension: &Bound<'py, PyAny>,
        out: &Bound<'py, PyAny>,
    ) -> PyResult<PosedMusculature> {
        let (pose, tension) = (pose_of(&self.core, pose)?, tension_of(&self.core, tension)?);
        let mut out = matrices("out", out, 'T', self.core.len())?.view(&[&pose, &tension])?;
        let (pose, tension, out) = (pose.groups()?, tension.numbers()?, out.groups()?);
        let posed = in_pool(py, || {
            let posed = self
                .core
                .pose(&Palette::new(self.core.skeleton(), pose)?, tension)?;
            write(
                posed
                    .matrices
                    .iter()
                    .map(|matrix| matrix.as_mat4().to_cols_array()),
                out,
            );
            Ok(posed)
        });
        PosedMusculature::new(py, &self.core, posed.map_err(into_python)?)
    }

    fn pose_ellipsoids<'py>(
        &self,
        py: Python<'py>,
        pose: &Bound<'py, PyAny>,
        tension: &Bound<'py, PyAny>,
        out: &Bound<'py, PyAny>,
    ) -> PyResult<()> {
        let (pose, tension) = (pose_of(&self.core, pose)?, tension_of(&self.core, tension)?);
        let mut out = matrices("out", out, 'E', self.core.ellipsoids().len())?.view(&[&pose, &tension])?;
        let (pose, tension, out) = (pose.groups()?, tension.numbers()?, out.groups()?);
        in_pool(py, || {
            let palette = Palette::new(self.core.skeleton(), pose)?;
            let matrices = self.core.pose_ellipsoids(&palette, tension)?;
            write(
                matrices.iter().map(|matrix| matrix.as_mat4().to_cols_array()),
                out,
            );
            Ok(())
        })
        .map_err(into_python)
    }

    fn path_points<'py>(&self, py: Python<'py>, pose: &Bound<'py, PyAny>) -> PyResult<Polylines<'py>> {
        let pose = pose_of(&self.core, pose)?;
        let pose = pose.groups()?;
        let paths = in_pool(py, || {
            Ok(self.core.paths(&Palette::new(self.core.skeleton(), pose)?))
        });
        let paths = paths.map_err(into_python)?;
        let points = paths.points().iter().map(|point| point.as_vec3().to_array());
        let points = Array2::from(points.collect::<Vec<_>>()).into_pyarray(py);
        let offsets = paths.offsets().iter().map(|&offset| offset as i32);
        Ok((points, offsets.collect::<Vec<_>>().into_pyarray(py)))
    }
}

/// The points of all polylines, and where each starts and ends.
type Polylines<'py> = (Bound<'py, PyArray2<f32>>, Bound<'py, PyArray1<i32>>);

/// The argument `name` as an array of `count` matrices. Messages call its length `letter`.
fn matrices<'py>(
    name: &'static str,
    argument: &Bound<'py, PyAny>,
    letter: char,
    count: usize,
) -> PyResult<Output<'py, f32>> {
    let four = Length::Exactly(4);
    Output::new(name, argument, Shape(&[Length::Named(letter, count), four, four]))
}

fn write(matrices: impl Iterator<Item = ColumnMajor>, out: &mut [ColumnMajor]) {
    out.iter_mut()
        .zip(matrices)
        .for_each(|(slot, matrix)| *slot = matrix);
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
