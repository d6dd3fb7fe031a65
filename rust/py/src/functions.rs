//! Functions of the module that belong to no class.

use numpy::{IntoPyArray, PyArray2, ndarray::Array2};
use pyo3::prelude::*;
use sinew_core::Error;

use crate::arrays::{Input, Length, Shape, numbers_of};
use crate::errors::{into_python, value_error};

/// Nearest points on the surface of an ellipsoid at the origin with axes along x, y, z.
#[pyfunction]
pub fn nearest_on_ellipsoid<'py>(
    py: Python<'py>,
    semi_axes: &Bound<'py, PyAny>,
    points: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let semi_axes = positive(numbers_of::<3>("semi_axes", semi_axes)?)?;
    let points = Input::<f64>::new("points", points, Shape(&[Length::Any('N'), Length::Exactly(3)]))?;
    let points = points.groups::<3>()?;
    let nearest =
        |point: &[f64; 3]| sinew_core::nearest_on_ellipsoid(semi_axes.into(), (*point).into()).to_array();
    let flat: Vec<f64> = py.detach(|| points.iter().flat_map(nearest).collect());
    let array =
        Array2::from_shape_vec((points.len(), 3), flat).map_err(|error| value_error(error.to_string()))?;
    Ok(array.into_pyarray(py))
}

fn positive(semi_axes: [f64; 3]) -> PyResult<[f64; 3]> {
    match semi_axes.into_iter().find(|&found| found <= 0.0) {
        None => Ok(semi_axes),
        Some(found) => Err(into_python(Error::Value {
            thing: "semi_axes".to_owned(),
            quantity: "a semi-axis",
            found,
            limit: "above 0",
        })),
    }
}
