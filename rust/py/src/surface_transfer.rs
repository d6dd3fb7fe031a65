//! `SurfaceTransfer`.

use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray1, PyArray2, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::prelude::*;
use sinew_core::fit;

use crate::arrays::{Input, Length, Shape};
use crate::errors::{into_python, value_error};
use crate::polygon_mesh::PolygonMesh;
use crate::scalars::Real;
use crate::threads::in_pool;

/// Surface transfer: for each vertex of a new surface, the nearest point of the old one and its values.
#[pyclass(frozen, module = "_sinew")]
pub struct SurfaceTransfer {
    core: fit::SurfaceTransfer,
}

#[pymethods]
impl SurfaceTransfer {
    #[new]
    fn new(py: Python<'_>, old: &PolygonMesh, new: &PolygonMesh, max_distance: Real) -> PyResult<Self> {
        let max_distance_m = max_distance.not_negative("max_distance")?;
        let core = in_pool(py, || {
            fit::SurfaceTransfer::new(&old.core, &new.core, max_distance_m)
        });
        Ok(Self {
            core: core.map_err(into_python)?,
        })
    }

    #[getter]
    fn is_near<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<bool>> {
        self.core.is_near().to_vec().into_pyarray(py)
    }

    #[getter]
    fn nearest_faces<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i32>> {
        signed(self.core.nearest_faces()).into_pyarray(py)
    }

    #[getter]
    fn nearest_corners<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i32>> {
        signed(&self.core.nearest_corners()).into_pyarray(py)
    }

    fn mixed<'py>(&self, py: Python<'py>, values: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let shape = [Length::Named('C', self.core.corner_count()), Length::Any('W')];
        let input = Input::<f32>::new("values", values, Shape(&shape))?;
        let width = values.cast::<PyUntypedArray>()?.shape()[1];
        let numbers = input.numbers()?;
        let mixed = in_pool(py, || self.core.mixed(numbers, width)).map_err(into_python)?;
        let rows = Array2::from_shape_vec((self.core.vertex_count(), width), mixed);
        Ok(rows
            .map_err(|error| value_error(error.to_string()))?
            .into_pyarray(py))
    }
}

fn signed(numbers: &[u32]) -> Vec<i32> {
    numbers.iter().map(|&number| number as i32).collect()
}
