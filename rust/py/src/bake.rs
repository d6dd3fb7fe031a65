//! `KeptSamples`, `MotionKeys` and `CombinationKeys`.

use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray1, PyArray2};
use pyo3::prelude::*;
use sinew_core::bake;

use crate::arrays::{Input, Length, Shape};
use crate::errors::{into_python, value_error};
use crate::threads::in_pool;

/// Which samples of a moving skin are kept.
#[pyclass(frozen, module = "_sinew")]
pub struct KeptSamples {
    core: bake::KeptSamples,
}

/// The corrective keys of one motion of a joint.
#[pyclass(frozen, module = "_sinew")]
pub struct MotionKeys {
    core: bake::MotionKeys,
}

/// The corrective keys of two motions at once.
#[pyclass(frozen, module = "_sinew")]
pub struct CombinationKeys {
    core: bake::CombinationKeys,
}

#[pymethods]
impl KeptSamples {
    #[new]
    fn new(
        py: Python<'_>,
        corrections: &Bound<'_, PyAny>,
        at: &Bound<'_, PyAny>,
        tolerances: &Bound<'_, PyAny>,
        candidates: &Bound<'_, PyAny>,
    ) -> PyResult<Self> {
        let input = SamplesInput::new(corrections, at)?;
        let list = [Length::Named('K', input.samples)];
        let tolerances = Input::<f64>::new("tolerances", tolerances, Shape(&list))?;
        let candidates = Input::<bool>::new("candidates", candidates, Shape(&list))?;
        let (corrections, at) = (input.corrections.groups()?, input.at.numbers()?);
        let (tolerances_m, candidates) = (tolerances.numbers()?, candidates.numbers()?);
        let core = in_pool(py, || {
            bake::Samples::new(input.vertices, corrections, at, tolerances_m)?.keep(candidates)
        });
        Ok(Self {
            core: core.map_err(into_python)?,
        })
    }

    #[getter]
    fn places(&self) -> Vec<usize> {
        self.core.places.clone()
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
    fn new(
        py: Python<'_>,
        corrections: &Bound<'_, PyAny>,
        at: &Bound<'_, PyAny>,
        tolerance: f64,
        threshold: f64,
    ) -> PyResult<Self> {
        let input = SamplesInput::new(corrections, at)?;
        let (corrections, at) = (input.corrections.groups()?, input.at.numbers()?);
        let tolerances_m = vec![tolerance; input.samples];
        let core = in_pool(py, || {
            let samples = bake::Samples::new(input.vertices, corrections, at, &tolerances_m)?;
            bake::MotionKeys::new(&samples, threshold)
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

    fn correction<'py>(&self, py: Python<'py>, key: usize) -> PyResult<Bound<'py, PyArray2<f32>>> {
        array_of_key(py, self.core.corrections(), key)
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
        first: &MotionKeys,
        second: &MotionKeys,
        first_at: &Bound<'_, PyAny>,
        second_at: &Bound<'_, PyAny>,
        corrections: &Bound<'_, PyAny>,
        tolerance: f64,
        threshold: f64,
        most: usize,
    ) -> PyResult<Self> {
        let first_at = Input::<f64>::new("first_at", first_at, Shape(&[Length::Any('F')]))?;
        let second_at = Input::<f64>::new("second_at", second_at, Shape(&[Length::Any('G')]))?;
        let shape = [
            Length::Named('F', first_at.numbers()?.len()),
            Length::Named('G', second_at.numbers()?.len()),
            Length::Named('V', first.core.vertices()),
            Length::Exactly(3),
        ];
        let corrections = Input::<f32>::new("corrections", corrections, Shape(&shape))?;
        let grid = bake::Grid {
            first: &first.core,
            second: &second.core,
            first_at: first_at.numbers()?,
            second_at: second_at.numbers()?,
            corrections: corrections.groups()?,
        };
        let core = in_pool(py, || {
            bake::CombinationKeys::new(grid, tolerance, threshold, most)
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

    fn correction<'py>(&self, py: Python<'py>, key: usize) -> PyResult<Bound<'py, PyArray2<f32>>> {
        array_of_key(py, &self.core.corrections, key)
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

/// Corrections of samples, checked, and the values they were taken at.
struct SamplesInput<'py> {
    corrections: Input<'py, f32>,
    at: Input<'py, f64>,
    samples: usize,
    vertices: usize,
}

impl<'py> SamplesInput<'py> {
    fn new(corrections: &Bound<'py, PyAny>, at: &Bound<'py, PyAny>) -> PyResult<Self> {
        let at = Input::<f64>::new("at", at, Shape(&[Length::Any('K')]))?;
        let samples = at.numbers()?.len();
        let shape = [Length::Named('K', samples), Length::Any('V'), Length::Exactly(3)];
        let input = Input::<f32>::new("corrections", corrections, Shape(&shape))?;
        let (_, vertices, _) = corrections.getattr("shape")?.extract::<(usize, usize, usize)>()?;
        Ok(Self {
            corrections: input,
            at,
            samples,
            vertices,
        })
    }
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
