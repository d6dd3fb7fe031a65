//! `Path` and `nearest_on_segment`.

use glam::DVec3;
use pyo3::prelude::*;

use crate::arrays::{Input, Length, Shape, numbers_of};
use crate::errors::value_error;
use crate::scalars::Real;

/// A polyline with its arc length.
#[pyclass(frozen, module = "_sinew")]
pub struct Path {
    core: sinew_core::Polyline,
}

#[pymethods]
impl Path {
    #[new]
    fn new(points: &Bound<'_, PyAny>) -> PyResult<Self> {
        let rows = [Length::Any('N'), Length::Exactly(3)];
        let points = Input::<f64>::new("points", points, Shape(&rows))?;
        let points: &[[f64; 3]] = points.groups()?;
        if points.is_empty() {
            return Err(value_error("points: expected one or more, got none".to_owned()));
        }
        let mut core = sinew_core::Polyline::default();
        points
            .iter()
            .for_each(|&point| core.line_to(DVec3::from_array(point)));
        Ok(Self { core })
    }

    #[getter]
    fn length(&self) -> f64 {
        self.core.length()
    }

    fn at(&self, length: Real) -> PyResult<(f64, f64, f64)> {
        Ok(self.core.at(length.named("length")?).into())
    }

    fn nearest_length(&self, point: &Bound<'_, PyAny>) -> PyResult<f64> {
        let point = DVec3::from_array(numbers_of("point", point)?);
        Ok(self.core.nearest_length(point))
    }
}

/// The point of a segment nearest to a point, and how far along the segment it is.
#[pyfunction]
pub fn nearest_on_segment(
    point: &Bound<'_, PyAny>,
    start: &Bound<'_, PyAny>,
    end: &Bound<'_, PyAny>,
) -> PyResult<((f64, f64, f64), f64)> {
    let [point, start, end] = [
        numbers_of("point", point)?,
        numbers_of("start", start)?,
        numbers_of("end", end)?,
    ]
    .map(DVec3::from_array);
    let (nearest, fraction) = sinew_core::nearest_on_segment(point, start, end);
    Ok((nearest.into(), fraction))
}
