//! `Skin`.

use std::sync::Arc;

use numpy::{IntoPyArray, PyArray2, ndarray::Array2};
use pyo3::prelude::*;
use sinew_core::{Anchoring, ColumnMajor, MotionSource, RestMesh, SkinOptions, Skinning};

use crate::arrays::{Input, Length, Output, Shape};
use crate::elasticity::Elasticity;
use crate::errors::{into_python, value_error};
use crate::frame_report::FrameReport;
use crate::musculature::{Musculature, pose_of, tension_of};
use crate::regional::Regional;
use crate::scalars::Real;
use crate::threads::in_pool;

/// A mesh bound to a musculature in the rest pose.
#[pyclass(frozen, module = "_sinew")]
pub struct Skin {
    pub core: Arc<sinew_core::Skin>,
}

/// A method that computes a frame: `correct` or `deform`.
type Frame = fn(
    &sinew_core::Skin,
    &[ColumnMajor],
    &[f32],
    &mut [[f32; 3]],
) -> sinew_core::Result<sinew_core::FrameReport>;

#[pymethods]
impl Skin {
    #[new]
    #[pyo3(signature = (musculature, points, edges, mesh_to_armature, weight_offsets, weight_bones, weights, *,
        skinning = "LINEAR", anchoring = "BLENDED", motion_source = "SWELLING", scale_fat = false, falloff = Real::of(0.03),
        softness = Real::of(0.004), gain = Real::of(1.0), muscle_influence = None, elasticity = None, preserved_fractions = None,
        body = None, body_triangles = None, triangles = None))]
    #[allow(clippy::too_many_arguments)]
    fn new(
        py: Python<'_>,
        musculature: &Musculature,
        points: &Bound<'_, PyAny>,
        edges: &Bound<'_, PyAny>,
        mesh_to_armature: &Bound<'_, PyAny>,
        weight_offsets: &Bound<'_, PyAny>,
        weight_bones: &Bound<'_, PyAny>,
        weights: &Bound<'_, PyAny>,
        skinning: &str,
        anchoring: &str,
        motion_source: &str,
        scale_fat: bool,
        falloff: Real,
        softness: Real,
        gain: Real,
        muscle_influence: Option<&Regional>,
        elasticity: Option<&Elasticity>,
        preserved_fractions: Option<&Bound<'_, PyAny>>,
        body: Option<&Skin>,
        body_triangles: Option<&Bound<'_, PyAny>>,
        triangles: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let fractions = preserved_fractions
            .map(|array| Input::<f32>::new("preserved_fractions", array, Shape(&[Length::Any('V')])))
            .transpose()?;
        let options = SkinOptions {
            skinning: skinning_of(skinning)?,
            preserved_fractions: fractions.as_ref().map(Input::numbers).transpose()?,
            anchoring: anchoring_of(anchoring)?,
            motion_source: motion_source_of(motion_source)?,
            scales_fat: scale_fat,
            falloff_m: falloff.named("falloff")?,
            softness_m: softness.named("softness")?,
            muscle_influence: influence_of(gain.named("gain")?, muscle_influence)?,
        };
        let (four, rows) = (Length::Exactly(4), Shape(&[Length::Any('V'), Length::Exactly(3)]));
        let points = Input::<f32>::new("points", points, rows)?;
        let edges = Input::<i32>::new("edges", edges, Shape(&[Length::Any('E'), Length::Exactly(2)]))?;
        let matrix = Input::<f32>::new("mesh_to_armature", mesh_to_armature, Shape(&[four, four]))?;
        let offsets = Input::<i32>::new("weight_offsets", weight_offsets, Shape(&[Length::Any('N')]))?;
        let bones = Input::<i32>::new("weight_bones", weight_bones, Shape(&[Length::Any('W')]))?;
        let weights = Input::<f32>::new("weights", weights, Shape(&[Length::Any('W')]))?;
        let mesh = RestMesh {
            points: points.groups()?,
            edges: edges.groups()?,
            mesh_to_armature: &matrix.groups()?[0],
            weight_offsets: offsets.numbers()?,
            weight_bones: bones.numbers()?,
            weights: weights.numbers()?,
        };
        let musculature = musculature.core.clone();
        let elasticity = elasticity.map(Elasticity::core);
        let (under, over) = (
            triangles_of("body_triangles", body_triangles)?,
            triangles_of("triangles", triangles)?,
        );
        let worn = match (body, &under, &over) {
            (Some(body), Some(under), Some(over)) => {
                Some((body.core.clone(), under.groups()?, over.groups()?))
            }
            (None, None, None) => None,
            _ => {
                return Err(value_error(
                    "body, body_triangles and triangles: expected all three or none".to_owned(),
                ));
            }
        };
        let bind = || {
            let skin = sinew_core::Skin::new(musculature, &mesh, &options)?;
            match (&worn, &elasticity) {
                (Some((body, under, over)), _) => skin.worn_over(body.clone(), under, over),
                (None, Some(elasticity)) => skin.with_elasticity(&mesh, elasticity),
                (None, None) => Ok(skin),
            }
        };
        let core = in_pool(py, bind).map_err(into_python)?;
        Ok(Self { core: Arc::new(core) })
    }

    fn __len__(&self) -> usize {
        self.core.len()
    }

    #[getter]
    fn anchored(&self) -> usize {
        self.core.anchored()
    }

    #[getter]
    fn tissue_weights<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let shape = (self.core.len(), self.core.musculature().len());
        let dense = py.detach(|| self.core.tissue_weights());
        let array = Array2::from_shape_vec(shape, dense).map_err(|error| value_error(error.to_string()))?;
        Ok(array.into_pyarray(py))
    }

    fn correct<'py>(
        &self,
        py: Python<'py>,
        pose: &Bound<'py, PyAny>,
        tension: &Bound<'py, PyAny>,
        out: &Bound<'py, PyAny>,
    ) -> PyResult<FrameReport> {
        self.frame(py, pose, tension, out, sinew_core::Skin::correct)
    }

    fn deform<'py>(
        &self,
        py: Python<'py>,
        pose: &Bound<'py, PyAny>,
        tension: &Bound<'py, PyAny>,
        out: &Bound<'py, PyAny>,
    ) -> PyResult<FrameReport> {
        self.frame(py, pose, tension, out, sinew_core::Skin::deform)
    }
}

impl Skin {
    fn frame<'py>(
        &self,
        py: Python<'py>,
        pose: &Bound<'py, PyAny>,
        tension: &Bound<'py, PyAny>,
        out: &Bound<'py, PyAny>,
        compute: Frame,
    ) -> PyResult<FrameReport> {
        let musculature = self.core.musculature();
        let rows = [Length::Named('V', self.core.len()), Length::Exactly(3)];
        let (pose, tension) = (pose_of(musculature, pose)?, tension_of(musculature, tension)?);
        let mut out = Output::<f32>::new("out", out, Shape(&rows))?.view(&[&pose, &tension])?;
        let (pose, tension, out) = (pose.groups()?, tension.numbers()?, out.groups()?);
        let report = in_pool(py, || compute(&self.core, pose, tension, out)).map_err(into_python)?;
        Ok(FrameReport::new(musculature, report))
    }
}

fn triangles_of<'py>(
    name: &'static str,
    triangles: Option<&Bound<'py, PyAny>>,
) -> PyResult<Option<Input<'py, i32>>> {
    let rows = Shape(&[Length::Any('T'), Length::Exactly(3)]);
    triangles.map(|array| Input::new(name, array, rows)).transpose()
}

/// `gain` times the regional factors.
fn influence_of(gain: f64, regional: Option<&Regional>) -> PyResult<sinew_core::Regional<'_>> {
    if !(gain.is_finite() && gain >= 0.0) {
        return Err(value_error(format!(
            "gain: expected a finite number, 0 or more, got {gain}"
        )));
    }
    let regional = regional.map_or_else(Default::default, Regional::core);
    Ok(sinew_core::Regional {
        body: gain * regional.body,
        ..regional
    })
}

fn skinning_of(skinning: &str) -> PyResult<Skinning> {
    match skinning {
        "LINEAR" => Ok(Skinning::Linear),
        "PRESERVE_VOLUME" => Ok(Skinning::PreserveVolume),
        "NONE" => Ok(Skinning::None),
        _ => Err(value_error(format!(
            "skinning: expected LINEAR, PRESERVE_VOLUME or NONE, got {skinning:?}"
        ))),
    }
}

fn anchoring_of(anchoring: &str) -> PyResult<Anchoring> {
    match anchoring {
        "BLENDED" => Ok(Anchoring::Blended),
        "NEAREST" => Ok(Anchoring::Nearest),
        _ => Err(value_error(format!(
            "anchoring: expected BLENDED or NEAREST, got {anchoring:?}"
        ))),
    }
}

fn motion_source_of(motion_source: &str) -> PyResult<MotionSource> {
    match motion_source {
        "SWELLING" => Ok(MotionSource::Swelling),
        "FULL" => Ok(MotionSource::Full),
        _ => Err(value_error(format!(
            "motion_source: expected SWELLING or FULL, got {motion_source:?}"
        ))),
    }
}
