//! `PosedMusculature`.

use numpy::{Element, IntoPyArray, PyArray1, PyArrayMethods};
use pyo3::prelude::*;

use crate::errors::value_error;
use crate::frame_report::names_of;

/// The tissues in one pose.
#[pyclass(frozen, module = "_sinew")]
pub struct PosedMusculature {
    stretch: Py<PyArray1<f32>>,
    volume: Py<PyArray1<f64>>,
    /// Names of the muscles close to their minimum length.
    #[pyo3(get)]
    clamped: Vec<String>,
}

impl PosedMusculature {
    /// Converts a result of the core for `musculature`.
    pub fn new(
        py: Python<'_>,
        musculature: &sinew_core::Musculature,
        posed: sinew_core::PosedMusculature,
    ) -> PyResult<Self> {
        Ok(Self {
            stretch: read_only(py, posed.stretch.iter().map(|&stretch| stretch as f32).collect())?,
            volume: read_only(py, posed.volume)?,
            clamped: names_of(musculature, &posed.clamped),
        })
    }
}

#[pymethods]
impl PosedMusculature {
    #[getter]
    fn stretch<'py>(&self, py: Python<'py>) -> &Bound<'py, PyArray1<f32>> {
        self.stretch.bind(py)
    }

    #[getter]
    fn volume<'py>(&self, py: Python<'py>) -> &Bound<'py, PyArray1<f64>> {
        self.volume.bind(py)
    }
}

fn read_only<T: Element>(py: Python<'_>, values: Vec<T>) -> PyResult<Py<PyArray1<T>>> {
    let array = values.into_pyarray(py);
    let borrow = array
        .try_readwrite()
        .map_err(|error| value_error(error.to_string()))?;
    Ok(borrow
        .make_nonwriteable()
        .as_any()
        .cast::<PyArray1<T>>()?
        .clone()
        .unbind())
}
