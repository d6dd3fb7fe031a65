//! `PolygonMesh`.

use pyo3::prelude::*;
use sinew_core::ColumnMajor;
use sinew_core::fit::{self, Polygons};

use crate::arrays::{Input, Length, Shape};
use crate::errors::into_python;
use crate::threads::in_pool;

/// The polygons of a mesh, in one space.
#[pyclass(frozen, module = "_sinew")]
pub struct PolygonMesh {
    /// The mesh of the core.
    pub core: Polygons,
}

#[pymethods]
impl PolygonMesh {
    #[new]
    #[pyo3(signature = (points, corners, face_offsets, to_space = None))]
    fn new(
        py: Python<'_>,
        points: &Bound<'_, PyAny>,
        corners: &Bound<'_, PyAny>,
        face_offsets: &Bound<'_, PyAny>,
        to_space: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let rows = [Length::Any('V'), Length::Exactly(3)];
        let points = Input::<f32>::new("points", points, Shape(&rows))?;
        let corners = Input::<i32>::new("corners", corners, Shape(&[Length::Any('C')]))?;
        let offsets = Input::<i32>::new("face_offsets", face_offsets, Shape(&[Length::Any('O')]))?;
        let four = [Length::Exactly(4), Length::Exactly(4)];
        let to_space = to_space
            .map(|matrix| Input::<f32>::new("to_space", matrix, Shape(&four)))
            .transpose()?;
        let matrix: Option<&[ColumnMajor]> = to_space.as_ref().map(Input::groups).transpose()?;
        let mesh = fit::PolygonMesh {
            points: points.groups()?,
            corners: corners.numbers()?,
            face_offsets: offsets.numbers()?,
            to_space: matrix.and_then(<[_]>::first),
        };
        let core = in_pool(py, || Polygons::new(&mesh)).map_err(into_python)?;
        Ok(Self { core })
    }

    fn __len__(&self) -> usize {
        self.core.len()
    }
}
