//! `LinearSkin`.

use numpy::{IntoPyArray, PyArray1};
use pyo3::prelude::*;
use sinew_core::RestMesh;

use crate::arrays::{Input, Length, Output, Shape};
use crate::errors::{into_python, value_error};
use crate::scalars::{Real, Whole};
use crate::skeleton::Skeleton;
use crate::threads::in_pool;

const THREE: Length = Length::Exactly(3);
const FOUR: Length = Length::Exactly(4);

/// A mesh with linear blend skinning.
#[pyclass(frozen, module = "_sinew")]
pub struct LinearSkin {
    core: sinew_core::LinearSkin,
}

/// Offsets, bones and weights.
type Rows<'py> = (
    Bound<'py, PyArray1<i32>>,
    Bound<'py, PyArray1<i32>>,
    Bound<'py, PyArray1<f32>>,
);

#[pymethods]
impl LinearSkin {
    #[new]
    fn new(
        py: Python<'_>,
        skeleton: &Skeleton,
        points: &Bound<'_, PyAny>,
        mesh_to_armature: &Bound<'_, PyAny>,
        weight_offsets: &Bound<'_, PyAny>,
        weight_bones: &Bound<'_, PyAny>,
        weights: &Bound<'_, PyAny>,
    ) -> PyResult<Self> {
        let points = Input::<f32>::new("points", points, Shape(&[Length::Any('V'), THREE]))?;
        let matrix = Input::<f32>::new("mesh_to_armature", mesh_to_armature, Shape(&[FOUR, FOUR]))?;
        let offsets = Input::<i32>::new("weight_offsets", weight_offsets, Shape(&[Length::Any('N')]))?;
        let bones = Input::<i32>::new("weight_bones", weight_bones, Shape(&[Length::Any('W')]))?;
        let weights = Input::<f32>::new("weights", weights, Shape(&[Length::Any('W')]))?;
        let mesh = RestMesh {
            points: points.groups()?,
            edges: &[],
            mesh_to_armature: &matrix.groups()?[0],
            weight_offsets: offsets.numbers()?,
            weight_bones: bones.numbers()?,
            weights: weights.numbers()?,
        };
        let skeleton = skeleton.core.clone();
        let core = in_pool(py, || sinew_core::LinearSkin::new(skeleton, &mesh)).map_err(into_python)?;
        Ok(Self { core })
    }

    fn __len__(&self) -> usize {
        self.core.len()
    }

    fn deform(
        &self,
        py: Python<'_>,
        pose: &Bound<'_, PyAny>,
        offsets: &Bound<'_, PyAny>,
        out: &Bound<'_, PyAny>,
    ) -> PyResult<()> {
        let (pose, offsets) = (self.pose(pose)?, self.vertices("offsets", offsets)?);
        let mut out = Output::<f32>::new("out", out, Shape(&self.rows()))?.view(&[&pose, &offsets])?;
        let (pose, offsets, out) = (pose.groups()?, offsets.groups()?, out.groups()?);
        in_pool(py, || self.core.deform(pose, offsets, out)).map_err(into_python)
    }

    fn correct(
        &self,
        py: Python<'_>,
        pose: &Bound<'_, PyAny>,
        target: &Bound<'_, PyAny>,
        out: &Bound<'_, PyAny>,
    ) -> PyResult<usize> {
        let (pose, target) = (self.pose(pose)?, self.vertices("target", target)?);
        let mut out = Output::<f32>::new("out", out, Shape(&self.rows()))?.view(&[&pose, &target])?;
        let (pose, target, out) = (pose.groups()?, target.groups()?, out.groups()?);
        in_pool(py, || self.core.correct(pose, target, out)).map_err(into_python)
    }

    fn fit<'py>(
        &self,
        py: Python<'py>,
        poses: &Bound<'py, PyAny>,
        targets: &Bound<'py, PyAny>,
        most: Whole,
        hold: Real,
    ) -> PyResult<Rows<'py>> {
        let most: usize = most.named("most")?;
        if most == 0 {
            return Err(value_error(
                "most: expected 1 bone per vertex or more, got 0".to_owned(),
            ));
        }
        let hold = hold.not_negative("hold")?;
        let bones = Length::Named('B', self.core.skeleton().len());
        let poses = Input::<f32>::new("poses", poses, Shape(&[Length::Any('F'), bones, FOUR, FOUR]))?;
        let [vertices, three] = self.rows();
        let targets = Input::<f32>::new("targets", targets, Shape(&[Length::Any('F'), vertices, three]))?;
        let (poses, targets) = (poses.groups()?, targets.groups()?);
        let found = in_pool(py, || self.core.fitted(poses, targets, most, hold)).map_err(into_python)?;
        Ok((
            found.offsets.into_pyarray(py),
            found.bones.into_pyarray(py),
            found.weights.into_pyarray(py),
        ))
    }
}

impl LinearSkin {
    fn rows(&self) -> [Length; 2] {
        [Length::Named('V', self.core.len()), THREE]
    }

    fn pose<'py>(&self, pose: &Bound<'py, PyAny>) -> PyResult<Input<'py, f32>> {
        let bones = Length::Named('B', self.core.skeleton().len());
        Input::new("pose", pose, Shape(&[bones, FOUR, FOUR]))
    }

    fn vertices<'py>(&self, name: &'static str, argument: &Bound<'py, PyAny>) -> PyResult<Input<'py, f32>> {
        Input::new(name, argument, Shape(&self.rows()))
    }
}
