//! `SkinSurface`.

use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray1, PyArray2};
use pyo3::prelude::*;
use rayon::prelude::*;
use sinew_core::fit::{self, Goal, Polygons, fill, fit_all, protrusion_m, volume_m3};

use crate::arrays::{Input, Length, Shape};
use crate::errors::into_python;
use crate::placed_tissues::PlacedTissues;
use crate::polygon_mesh::PolygonMesh;
use crate::threads::in_pool;

/// Nearest points and their distances.
type NearestSkin<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray1<f64>>);

/// The skin of one mesh or several in the rest pose, for rays, inside tests and nearest points.
#[pyclass(frozen, module = "_sinew")]
pub struct SkinSurface {
    core: fit::SkinSurface,
}

#[pymethods]
impl SkinSurface {
    #[new]
    fn new(py: Python<'_>, meshes: Vec<PyRef<'_, PolygonMesh>>) -> PyResult<Self> {
        let polygons: Vec<&Polygons> = meshes.iter().map(|mesh| &mesh.core).collect();
        let core = in_pool(py, || fit::SkinSurface::new(&polygons)).map_err(into_python)?;
        Ok(Self { core })
    }

    #[getter]
    fn size(&self) -> f64 {
        self.core.size_m()
    }

    #[getter]
    fn margin(&self) -> f64 {
        self.core.margin_m()
    }

    #[getter]
    fn volume(&self, py: Python<'_>) -> f64 {
        in_pool(py, || volume_m3(&self.core))
    }

    fn distances_along<'py>(
        &self,
        py: Python<'py>,
        origins: &Bound<'py, PyAny>,
        directions: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let (origins, directions) = (rows("origins", origins)?, rows("directions", directions)?);
        let (origins, directions) = (origins.groups()?, directions.groups()?);
        let distances = in_pool(py, || self.core.distances_along(origins, directions));
        Ok(distances.map_err(into_python)?.into_pyarray(py))
    }

    fn are_inside<'py>(
        &self,
        py: Python<'py>,
        points: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArray1<bool>>> {
        let points = rows("points", points)?;
        let points = points.groups()?;
        Ok(in_pool(py, || self.core.are_inside(points)).into_pyarray(py))
    }

    fn nearest<'py>(&self, py: Python<'py>, points: &Bound<'py, PyAny>) -> PyResult<NearestSkin<'py>> {
        let points = rows("points", points)?;
        let points = points.groups()?;
        let all = in_pool(py, || self.core.nearest_to_all(points));
        let points: Vec<[f64; 3]> = all.iter().map(|nearest| nearest.point.to_array()).collect();
        let distances: Vec<f64> = all.iter().map(|nearest| nearest.distance_m).collect();
        Ok((Array2::from(points).into_pyarray(py), distances.into_pyarray(py)))
    }

    fn fit(
        &self,
        py: Python<'_>,
        tissues: &PlacedTissues,
        left_twins: &Bound<'_, PyAny>,
    ) -> PyResult<PlacedTissues> {
        let count = Length::Named('T', tissues.core.len());
        let left_twins = twins("left_twins", left_twins, count)?;
        let core = in_pool(py, || fit_all(&tissues.core, &left_twins, &self.core));
        Ok(PlacedTissues {
            core: core.map_err(into_python)?,
        })
    }

    fn fill(
        &self,
        py: Python<'_>,
        tissues: &PlacedTissues,
        volumes: &Bound<'_, PyAny>,
        fat: &Bound<'_, PyAny>,
        left_twins: &Bound<'_, PyAny>,
    ) -> PyResult<PlacedTissues> {
        let count = Length::Named('T', tissues.core.len());
        let volumes = Input::<f64>::new("volumes", volumes, Shape(&[count]))?;
        let fat = Input::<f64>::new("fat", fat, Shape(&[count]))?;
        let goals = volumes.numbers()?.iter().zip(fat.numbers()?);
        let goals: Vec<Goal> = goals
            .map(|(&volume_m3, &fat_m)| Goal { volume_m3, fat_m })
            .collect();
        let left_twins = twins("left_twins", left_twins, count)?;
        let core = in_pool(py, || fill(&tissues.core, &goals, &left_twins, &self.core));
        Ok(PlacedTissues {
            core: core.map_err(into_python)?,
        })
    }

    fn protrusions<'py>(&self, py: Python<'py>, tissues: &PlacedTissues) -> Bound<'py, PyArray1<f64>> {
        let protrusion = |tissue| protrusion_m(tissue, &self.core);
        let protrusions: Vec<f64> = in_pool(py, || tissues.core.par_iter().map(protrusion).collect());
        protrusions.into_pyarray(py)
    }
}

/// For each tissue the index of its twin; `None` where it is negative.
fn twins(name: &'static str, argument: &Bound<'_, PyAny>, count: Length) -> PyResult<Vec<Option<usize>>> {
    let twins = Input::<i32>::new(name, argument, Shape(&[count]))?;
    let twins = twins.numbers()?.iter().map(|&twin| usize::try_from(twin).ok());
    Ok(twins.collect())
}

/// An array of points or directions.
fn rows<'py>(name: &'static str, argument: &Bound<'py, PyAny>) -> PyResult<Input<'py, f64>> {
    Input::new(name, argument, Shape(&[Length::Any('N'), Length::Exactly(3)]))
}
