//! `Regional`.

use pyo3::prelude::*;

use crate::arrays::{Input, Length, Shape};
use crate::scalars::Real;

/// A setting of the skin: a value for the whole body, times a factor per bone, times a factor per vertex.
/// `Skin` checks it against mesh and rig.
#[pyclass(frozen, skip_from_py_object, module = "_sinew")]
#[derive(Clone)]
pub struct Regional {
    body: f64,
    bones: Option<Vec<f32>>,
    vertices: Option<Vec<f32>>,
}

#[pymethods]
impl Regional {
    #[new]
    #[pyo3(signature = (body = Real::of(1.0), bones = None, vertices = None))]
    fn new(
        body: Real,
        bones: Option<&Bound<'_, PyAny>>,
        vertices: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        Ok(Self {
            body: body.named("body")?,
            bones: one_each("bones", bones, Length::Any('B'))?,
            vertices: one_each("vertices", vertices, Length::Any('V'))?,
        })
    }
}

impl Regional {
    /// One value for the whole body.
    pub fn of_body(body: f64) -> Self {
        Self {
            body,
            bones: None,
            vertices: None,
        }
    }

    /// A view for the core.
    pub fn core(&self) -> sinew_core::Regional<'_> {
        sinew_core::Regional {
            body: self.body,
            bones: self.bones.as_deref(),
            vertices: self.vertices.as_deref(),
        }
    }
}

/// The argument `name` as `length` finite numbers; `None` if there is none.
pub fn one_each(
    name: &'static str,
    argument: Option<&Bound<'_, PyAny>>,
    length: Length,
) -> PyResult<Option<Vec<f32>>> {
    let Some(argument) = argument else { return Ok(None) };
    let input = Input::<f32>::new(name, argument, Shape(&[length]))?;
    Ok(Some(input.numbers()?.to_vec()))
}
