//! `RestSurface`, `SurfaceRegion`, `DeformedSurface` and `SkinQuality`.

use std::sync::Arc;

use numpy::{IntoPyArray, PyArray1, PyArray2, ndarray::Array2};
use pyo3::prelude::*;
use sinew_core::measure;

use crate::arrays::{Input, Length, Shape, numbers_of};
use crate::errors::{into_python, value_error};
use crate::scalars::Real;
use crate::threads::in_pool;

/// A triangulated skin in the rest pose, with which deformed states are compared.
#[pyclass(frozen, module = "_sinew")]
pub struct RestSurface {
    core: Arc<measure::RestSurface>,
}

/// A part of a surface that is measured on its own.
#[pyclass(frozen, module = "_sinew")]
pub struct SurfaceRegion {
    surface: Arc<measure::RestSurface>,
    core: measure::SurfaceRegion,
}

/// One deformed state of a surface.
#[pyclass(frozen, module = "_sinew")]
pub struct DeformedSurface {
    surface: Arc<measure::RestSurface>,
    core: measure::DeformedSurface,
}

/// The quality of one region in one deformed state.
#[pyclass(frozen, get_all, module = "_sinew")]
pub struct SkinQuality {
    union: f64,
    overlap: f64,
    inside_out: f64,
    unreadable: f64,
    volume: f64,
    edge_p50: f64,
    edge_p99: f64,
    edge_max: f64,
    area_p99: f64,
    inverted: usize,
    new_intersections: usize,
    bend_p99: f64,
}

#[pymethods]
impl RestSurface {
    #[new]
    fn new(py: Python<'_>, points: &Bound<'_, PyAny>, triangles: &Bound<'_, PyAny>) -> PyResult<Self> {
        let lists = |letter| [Length::Any(letter), Length::Exactly(3)];
        let points = Input::<f32>::new("points", points, Shape(&lists('V')))?;
        let triangles = Input::<i32>::new("triangles", triangles, Shape(&lists('F')))?;
        let (points, triangles) = (points.groups()?, triangles.groups()?);
        let core = in_pool(py, || measure::RestSurface::new(points, triangles)).map_err(into_python)?;
        Ok(Self { core: Arc::new(core) })
    }

    #[getter]
    fn rest_hits(&self) -> usize {
        self.core.rest_intersection_count()
    }

    #[pyo3(signature = (centre, radius, carried = None))]
    fn region(
        &self,
        py: Python<'_>,
        centre: &Bound<'_, PyAny>,
        radius: Real,
        carried: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Option<SurfaceRegion>> {
        let centre = numbers_of::<3>("centre", centre)?;
        let radius_m = radius.not_negative("radius")?;
        let carried = carried
            .map(|carried| {
                let length = Length::Named('V', self.core.vertex_count());
                Input::<bool>::new("carried", carried, Shape(&[length]))
            })
            .transpose()?;
        let carried = carried.as_ref().map(Input::numbers).transpose()?;
        let found = in_pool(py, || self.core.region(centre, radius_m, carried)).map_err(into_python)?;
        Ok(found.map(|core| SurfaceRegion {
            surface: self.core.clone(),
            core,
        }))
    }

    fn whole(&self, py: Python<'_>) -> SurfaceRegion {
        SurfaceRegion {
            surface: self.core.clone(),
            core: in_pool(py, || self.core.whole()),
        }
    }

    fn deformed(&self, py: Python<'_>, points: &Bound<'_, PyAny>) -> PyResult<DeformedSurface> {
        let rows = [Length::Named('V', self.core.vertex_count()), Length::Exactly(3)];
        let points = Input::<f32>::new("points", points, Shape(&rows))?;
        let points = points.groups()?;
        let core = in_pool(py, || self.core.deformed(points)).map_err(into_python)?;
        Ok(DeformedSurface {
            surface: self.core.clone(),
            core,
        })
    }
}

#[pymethods]
impl SurfaceRegion {
    fn __len__(&self) -> usize {
        self.core.faces().len()
    }

    #[getter]
    fn faces<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i32>> {
        let faces: Vec<i32> = self.core.faces().iter().map(|&face| face as i32).collect();
        faces.into_pyarray(py)
    }

    #[getter]
    fn rest_union(&self) -> f64 {
        self.core.rest_union()
    }
}

#[pymethods]
impl DeformedSurface {
    fn quality(&self, py: Python<'_>, region: &SurfaceRegion) -> PyResult<SkinQuality> {
        if !Arc::ptr_eq(&self.surface, &region.surface) {
            return Err(value_error(
                "region: expected a region of the surface that was deformed, got one of another surface"
                    .to_owned(),
            ));
        }
        Ok(in_pool(py, || self.surface.quality(&self.core, &region.core)).into())
    }

    #[getter]
    fn inverted<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<bool>> {
        self.core.inverted.clone().into_pyarray(py)
    }

    #[getter]
    fn new_intersections<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<i32>>> {
        let flat: Vec<i32> = self
            .core
            .new_intersections
            .iter()
            .flatten()
            .map(|&face| face as i32)
            .collect();
        let pairs = Array2::from_shape_vec((self.core.new_intersections.len(), 2), flat);
        Ok(pairs
            .map_err(|error| value_error(error.to_string()))?
            .into_pyarray(py))
    }

    #[getter]
    fn vertex_stretch<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f32>> {
        py.detach(|| self.surface.vertex_stretch(&self.core))
            .into_pyarray(py)
    }
}

impl From<measure::SkinQuality> for SkinQuality {
    fn from(found: measure::SkinQuality) -> Self {
        Self {
            union: found.union,
            overlap: found.overlap,
            inside_out: found.inside_out,
            unreadable: found.unreadable,
            volume: found.volume,
            edge_p50: found.edge.p50,
            edge_p99: found.edge.p99,
            edge_max: found.edge.max,
            area_p99: found.area_p99,
            inverted: found.inverted,
            new_intersections: found.new_intersections,
            bend_p99: found.bend_p99,
        }
    }
}
