//! `GrownSkin` and `Progress`.

use std::sync::Arc;

use numpy::ndarray::Array2;
use numpy::{Element, IntoPyArray, PyArray1, PyArray2};
use pyo3::prelude::*;
use sinew_core::{GrowOptions, SkinBones, grow};

use crate::arrays::{Input, Length, Shape};
use crate::errors::{into_python, value_error};
use crate::musculature::Musculature;
use crate::scalars::{Real, Whole};
use crate::threads::in_pool;

/// The progress of a long computation, read and cancelled from another thread.
#[pyclass(frozen, module = "_sinew")]
pub struct Progress {
    core: Arc<sinew_core::Progress>,
}

#[pymethods]
impl Progress {
    #[new]
    fn new() -> Self {
        Self { core: Arc::default() }
    }

    #[getter]
    fn done(&self) -> f64 {
        self.core.done()
    }

    fn cancel(&self) {
        self.core.cancel();
    }
}

/// A skin grown over all tissues in the rest pose.
#[pyclass(frozen, module = "_sinew")]
pub struct GrownSkin {
    points: Py<PyArray2<f32>>,
    quads: Py<PyArray2<i32>>,
    weight_offsets: Py<PyArray1<i32>>,
    weight_bones: Py<PyArray1<i32>>,
    weights: Py<PyArray1<f32>>,
    /// Edge length of a voxel, m.
    #[pyo3(get)]
    voxel: f64,
    /// Names of the tissues that were thickened.
    #[pyo3(get)]
    thickened: Vec<String>,
    /// Number of connected pieces.
    #[pyo3(get)]
    pieces: usize,
    /// Quality of the worst face.
    #[pyo3(get)]
    worst_quality: f64,
    /// Largest distance by which the anatomy protrudes from the skin, m.
    #[pyo3(get)]
    protrusion: f64,
    /// The tissue that protrudes most.
    #[pyo3(get)]
    protruding: Option<String>,
}

#[pymethods]
impl GrownSkin {
    #[new]
    #[pyo3(signature = (musculature, skin_thickness, bone_lengths, weight_bones, *, resolution = Whole::of(83), thickness = Real::of(0.0),
        smoothing = Whole::of(5), radius = Whole::of(1), decay = Real::of(1.0), faces = None, symmetric = true, largest_only = false,
        memory_limit_mb = Real::of(2000.0), progress = None))]
    #[allow(clippy::too_many_arguments)]
    fn new(
        py: Python<'_>,
        musculature: &Musculature,
        skin_thickness: &Bound<'_, PyAny>,
        bone_lengths: &Bound<'_, PyAny>,
        weight_bones: &Bound<'_, PyAny>,
        resolution: Whole,
        thickness: Real,
        smoothing: Whole,
        radius: Whole,
        decay: Real,
        faces: Option<Whole>,
        symmetric: bool,
        largest_only: bool,
        memory_limit_mb: Real,
        progress: Option<&Progress>,
    ) -> PyResult<Self> {
        let options = GrowOptions {
            resolution: resolution.named("resolution")?,
            thickness_m: thickness.named("thickness")?,
            smoothing: smoothing.named("smoothing")?,
            radius: radius.named("radius")?,
            decay: decay.named("decay")?,
            faces: faces.map(|faces| faces.named("faces")).transpose()?,
            symmetric,
            largest_only,
            memory_limit_bytes: memory_limit_mb.named("memory_limit_mb")? * 1e6,
        };
        let core = &musculature.core;
        let (tissues, bones) = (
            Length::Named('T', core.len()),
            Length::Named('B', core.skeleton().len()),
        );
        let thickness_m = Input::<f32>::new("skin_thickness", skin_thickness, Shape(&[tissues]))?;
        let lengths = Input::<f32>::new("bone_lengths", bone_lengths, Shape(&[bones]))?;
        let weight_bones = Input::<i32>::new("weight_bones", weight_bones, Shape(&[bones]))?;
        let weight_bones = weight_bones_of(weight_bones.numbers()?, core.skeleton().len())?;
        let progress = progress.map(|progress| progress.core.clone()).unwrap_or_default();
        let (thickness_m, lengths_m) = (thickness_m.numbers()?, lengths.numbers()?);
        let grown = in_pool(py, || {
            let bones = SkinBones {
                lengths_m,
                weight_bones: &weight_bones,
            };
            grow(core, thickness_m, bones, &options, &progress)
        });
        Self::from_core(py, core, grown.map_err(into_python)?)
    }

    fn __len__(&self, py: Python<'_>) -> PyResult<usize> {
        self.points.bind(py).len()
    }

    #[getter]
    fn points<'py>(&self, py: Python<'py>) -> &Bound<'py, PyArray2<f32>> {
        self.points.bind(py)
    }

    #[getter]
    fn quads<'py>(&self, py: Python<'py>) -> &Bound<'py, PyArray2<i32>> {
        self.quads.bind(py)
    }

    #[getter]
    fn weight_offsets<'py>(&self, py: Python<'py>) -> &Bound<'py, PyArray1<i32>> {
        self.weight_offsets.bind(py)
    }

    #[getter]
    fn weight_bones<'py>(&self, py: Python<'py>) -> &Bound<'py, PyArray1<i32>> {
        self.weight_bones.bind(py)
    }

    #[getter]
    fn weights<'py>(&self, py: Python<'py>) -> &Bound<'py, PyArray1<f32>> {
        self.weights.bind(py)
    }
}

impl GrownSkin {
    fn from_core(
        py: Python<'_>,
        musculature: &sinew_core::Musculature,
        grown: sinew_core::GrownSkin,
    ) -> PyResult<Self> {
        let name = |tissue: usize| musculature.tissues()[tissue].name().to_owned();
        let report = grown.report;
        Ok(Self {
            points: Array2::from(grown.points).into_pyarray(py).unbind(),
            quads: Array2::from(grown.quads).into_pyarray(py).unbind(),
            weight_offsets: array(py, grown.weights.offsets),
            weight_bones: array(py, grown.weights.bones),
            weights: array(py, grown.weights.weights),
            voxel: report.voxel_m,
            thickened: report.thickened.into_iter().map(name).collect(),
            pieces: report.pieces,
            worst_quality: report.worst_quality,
            protrusion: report.protrusion_m,
            protruding: report.protruding.map(name),
        })
    }
}

fn array<T: Element>(py: Python<'_>, values: Vec<T>) -> Py<PyArray1<T>> {
    values.into_pyarray(py).unbind()
}

fn weight_bones_of(found: &[i32], bones: usize) -> PyResult<Vec<usize>> {
    let checked = found.iter().enumerate().map(|(position, &bone)| {
        usize::try_from(bone).map_err(|_| {
            value_error(format!(
                "weight_bones: entry {position} is {bone}, outside 0..{bones} (bones)"
            ))
        })
    });
    checked.collect()
}
