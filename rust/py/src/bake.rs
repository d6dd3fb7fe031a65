//! `KeptSamples`, `MotionKeys` and `CombinationKeys`.

use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray1, PyArray2};
use pyo3::prelude::*;
use rayon::prelude::*;
use sinew_core::{ColumnMajor, PosedModifier, bake};

use crate::arrays::{Input, Length, Shape};
use crate::errors::{into_python, value_error};
use crate::scalars::{Real, Whole};
use crate::skin::Skin;
use crate::threads::in_pool;

/// A few samples of a moving skin whose cross-fade stays near all of them.
#[pyclass(frozen, module = "_sinew")]
pub struct KeptSamples {
    core: bake::KeptSamples,
}

/// The corrective keys of one motion of a joint.
#[pyclass(frozen, module = "_sinew")]
pub struct MotionKeys {
    core: bake::MotionKeys,
}

/// The corrective keys that two motions together need beyond those of each.
#[pyclass(frozen, module = "_sinew")]
pub struct CombinationKeys {
    core: bake::CombinationKeys,
}

#[pymethods]
impl KeptSamples {
    #[new]
    fn new(
        py: Python<'_>,
        skin: &Skin,
        poses: &Bound<'_, PyAny>,
        corrections: &Bound<'_, PyAny>,
        at: &Bound<'_, PyAny>,
        tolerances: &Bound<'_, PyAny>,
        candidates: &Bound<'_, PyAny>,
    ) -> PyResult<Self> {
        let input = SamplesInput::new(skin, poses, corrections, at)?;
        let list = [Length::Named('K', input.samples)];
        let tolerances = Input::<f64>::new("tolerances", tolerances, Shape(&list))?;
        let candidates = Input::<bool>::new("candidates", candidates, Shape(&list))?;
        let (poses, corrections, at) = (
            input.poses.groups()?,
            input.corrections.groups()?,
            input.at.numbers()?,
        );
        let (tolerances_m, candidates) = (tolerances.numbers()?, candidates.numbers()?);
        let core = in_pool(py, || {
            let poses = posed_modifiers(&skin.core, poses)?;
            let metric = bake::ErrorMetric::Posed(&skin.core, &poses);
            bake::Samples::new(skin.core.len(), corrections, metric, at, tolerances_m)?.keep(candidates)
        });
        Ok(Self {
            core: core.map_err(into_python)?,
        })
    }

    #[getter]
    fn places(&self) -> Vec<usize> {
        self.core.indices.clone()
    }

    #[getter]
    fn shown(&self) -> Vec<Option<usize>> {
        self.core.shown.clone()
    }

    #[getter]
    fn errors<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.core.errors_m.clone().into_pyarray(py)
    }
}

#[pymethods]
impl MotionKeys {
    #[new]
    #[pyo3(signature = (skin, poses, corrections, at, tolerance, threshold, indices = None))]
    #[allow(clippy::too_many_arguments)]
    fn new(
        py: Python<'_>,
        skin: &Skin,
        poses: &Bound<'_, PyAny>,
        corrections: &Bound<'_, PyAny>,
        at: &Bound<'_, PyAny>,
        tolerance: Real,
        threshold: Real,
        indices: Option<Vec<Whole>>,
    ) -> PyResult<Self> {
        let indices = indices
            .map(|indices| indices.into_iter().map(|index| index.named("indices")).collect())
            .transpose()?;
        let indices: Option<Vec<usize>> = indices;
        let tolerance_m = tolerance.not_negative("tolerance")?;
        let threshold_m = threshold.not_negative("threshold")?;
        let input = SamplesInput::new(skin, poses, corrections, at)?;
        let (poses, corrections, at) = (
            input.poses.groups()?,
            input.corrections.groups()?,
            input.at.numbers()?,
        );
        let tolerances_m = vec![tolerance_m; input.samples];
        let core = in_pool(py, || {
            let poses = posed_modifiers(&skin.core, poses)?;
            let metric = bake::ErrorMetric::Posed(&skin.core, &poses);
            let samples = bake::Samples::new(skin.core.len(), corrections, metric, at, &tolerances_m)?;
            match &indices {
                Some(indices) => bake::MotionKeys::at_samples(&samples, indices, threshold_m),
                None => bake::MotionKeys::new(&samples, threshold_m),
            }
        });
        Ok(Self {
            core: core.map_err(into_python)?,
        })
    }

    fn __len__(&self) -> usize {
        self.core.at().len()
    }

    #[getter]
    fn at(&self) -> Vec<f64> {
        self.core.at().to_vec()
    }

    #[getter]
    fn indices(&self) -> Vec<usize> {
        self.core.indices().to_vec()
    }

    fn correction<'py>(&self, py: Python<'py>, key: Whole) -> PyResult<Bound<'py, PyArray2<f32>>> {
        array_of_key(py, self.core.corrections(), key.named("key")?)
    }

    #[getter]
    fn error_at(&self) -> f64 {
        self.core.error_at_m
    }

    #[getter]
    fn error_between(&self) -> f64 {
        self.core.error_between_m
    }
}

#[pymethods]
impl CombinationKeys {
    #[new]
    #[allow(clippy::too_many_arguments)]
    fn new(
        py: Python<'_>,
        skin: &Skin,
        first: &MotionKeys,
        second: &MotionKeys,
        first_at: &Bound<'_, PyAny>,
        second_at: &Bound<'_, PyAny>,
        poses: &Bound<'_, PyAny>,
        corrections: &Bound<'_, PyAny>,
        tolerance: Real,
        threshold: Real,
        most: Whole,
    ) -> PyResult<Self> {
        let most: usize = most.named("most")?;
        let tolerance_m = tolerance.not_negative("tolerance")?;
        let threshold_m = threshold.not_negative("threshold")?;
        let first_at = Input::<f64>::new("first_at", first_at, Shape(&[Length::Any('F')]))?;
        let second_at = Input::<f64>::new("second_at", second_at, Shape(&[Length::Any('G')]))?;
        let rows = Length::Named('F', first_at.numbers()?.len());
        let columns = Length::Named('G', second_at.numbers()?.len());
        let bones = Length::Named('B', skin.core.musculature().skeleton().len());
        let (vertices, three, four) = (
            Length::Named('V', skin.core.len()),
            Length::Exactly(3),
            Length::Exactly(4),
        );
        let corrections = Input::<f32>::new(
            "corrections",
            corrections,
            Shape(&[rows, columns, vertices, three]),
        )?;
        let poses = Input::<f32>::new("poses", poses, Shape(&[rows, columns, bones, four, four]))?;
        let (first_at, second_at) = (first_at.numbers()?, second_at.numbers()?);
        let (corrections, poses) = (corrections.groups()?, poses.groups()?);
        let core = in_pool(py, || {
            let poses = posed_modifiers(&skin.core, poses)?;
            let grid = bake::Grid {
                first: &first.core,
                second: &second.core,
                first_at,
                second_at,
                corrections,
                metric: bake::ErrorMetric::Posed(&skin.core, &poses),
            };
            bake::CombinationKeys::new(grid, tolerance_m, threshold_m, most)
        });
        Ok(Self {
            core: core.map_err(into_python)?,
        })
    }

    fn __len__(&self) -> usize {
        self.core.corners.len()
    }

    #[getter]
    fn first_at(&self) -> Vec<f64> {
        self.core.first_at.clone()
    }

    #[getter]
    fn second_at(&self) -> Vec<f64> {
        self.core.second_at.clone()
    }

    #[getter]
    fn corners(&self) -> Vec<(usize, usize)> {
        self.core
            .corners
            .iter()
            .map(|&[row, column]| (row, column))
            .collect()
    }

    fn correction<'py>(&self, py: Python<'py>, key: Whole) -> PyResult<Bound<'py, PyArray2<f32>>> {
        array_of_key(py, &self.core.corrections, key.named("key")?)
    }

    #[getter]
    fn error_before(&self) -> f64 {
        self.core.error_before_m
    }

    #[getter]
    fn error_at(&self) -> f64 {
        self.core.error_at_m
    }

    #[getter]
    fn error_between(&self) -> f64 {
        self.core.error_between_m
    }
}

/// The checked poses and corrections of samples, and the values at which they were taken.
struct SamplesInput<'py> {
    poses: Input<'py, f32>,
    corrections: Input<'py, f32>,
    at: Input<'py, f64>,
    samples: usize,
}

impl<'py> SamplesInput<'py> {
    fn new(
        skin: &Skin,
        poses: &Bound<'py, PyAny>,
        corrections: &Bound<'py, PyAny>,
        at: &Bound<'py, PyAny>,
    ) -> PyResult<Self> {
        let at = Input::<f64>::new("at", at, Shape(&[Length::Any('K')]))?;
        let samples = at.numbers()?.len();
        let (count, bones) = (
            Length::Named('K', samples),
            Length::Named('B', skin.core.musculature().skeleton().len()),
        );
        let (vertices, three, four) = (
            Length::Named('V', skin.core.len()),
            Length::Exactly(3),
            Length::Exactly(4),
        );
        Ok(Self {
            poses: Input::new("poses", poses, Shape(&[count, bones, four, four]))?,
            corrections: Input::new("corrections", corrections, Shape(&[count, vertices, three]))?,
            at,
            samples,
        })
    }
}

/// The skin's Armature modifier in each of `poses`, which has the bones of one pose after another.
fn posed_modifiers(skin: &sinew_core::Skin, poses: &[ColumnMajor]) -> sinew_core::Result<Vec<PosedModifier>> {
    let bones = skin.musculature().skeleton().len();
    poses
        .par_chunks_exact(bones)
        .map(|pose| skin.posed_modifier(pose))
        .collect()
}

fn array_of_key<'py>(
    py: Python<'py>,
    keys: &[Vec<[f32; 3]>],
    key: usize,
) -> PyResult<Bound<'py, PyArray2<f32>>> {
    let found = keys.get(key).ok_or_else(|| {
        value_error(format!(
            "key: expected 0 to {}, got {key}",
            keys.len().saturating_sub(1)
        ))
    })?;
    let flat: Vec<f32> = found.iter().flatten().copied().collect();
    let array =
        Array2::from_shape_vec((found.len(), 3), flat).map_err(|error| value_error(error.to_string()))?;
    Ok(array.into_pyarray(py))
}
