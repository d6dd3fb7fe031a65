//! `PlacedTissues`.

use glam::{DQuat, DVec3};
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray1, PyArray2};
use pyo3::prelude::*;
use sinew_core::fit::{PlacedTissue, Placement};

use crate::arrays::{Input, Length, Shape};
use crate::errors::{into_python, value_error};
use crate::tissue::kind_of;

/// Tissues placed on a body, before or after the fit under the skin.
#[pyclass(frozen, module = "_sinew")]
pub struct PlacedTissues {
    /// The tissues of the core.
    pub core: Vec<PlacedTissue>,
}

#[pymethods]
impl PlacedTissues {
    #[new]
    #[pyo3(signature = (kinds, centres, rotations, semi_axes, tendons, via_offsets, via_points))]
    #[allow(clippy::too_many_arguments)]
    fn new(
        kinds: Vec<String>,
        centres: &Bound<'_, PyAny>,
        rotations: &Bound<'_, PyAny>,
        semi_axes: &Bound<'_, PyAny>,
        tendons: &Bound<'_, PyAny>,
        via_offsets: &Bound<'_, PyAny>,
        via_points: &Bound<'_, PyAny>,
    ) -> PyResult<Self> {
        let count = Length::Named('T', kinds.len());
        let rows = |length| [count, Length::Exactly(length)];
        let centres = Input::<f64>::new("centres", centres, Shape(&rows(3)))?;
        let rotations = Input::<f64>::new("rotations", rotations, Shape(&rows(4)))?;
        let semi_axes = Input::<f64>::new("semi_axes", semi_axes, Shape(&rows(3)))?;
        let tendons = Input::<f64>::new("tendons", tendons, Shape(&rows(2)))?;
        let offsets = Length::Named('O', kinds.len() + 1);
        let offsets = Input::<i32>::new("via_offsets", via_offsets, Shape(&[offsets]))?;
        let points = [Length::Any('P'), Length::Exactly(3)];
        let points = Input::<f64>::new("via_points", via_points, Shape(&points))?;
        let (centres, rotations): (&[[f64; 3]], &[[f64; 4]]) = (centres.groups()?, rotations.groups()?);
        let (semi_axes, tendons): (&[[f64; 3]], &[[f64; 2]]) = (semi_axes.groups()?, tendons.groups()?);
        let (offsets, points) = (offsets.numbers()?, points.groups()?);
        require_offsets(offsets, points.len())?;
        let mut core = Vec::with_capacity(kinds.len());
        for (index, kind) in kinds.iter().enumerate() {
            let [w, x, y, z] = rotations[index];
            let range = offsets[index] as usize..offsets[index + 1] as usize;
            let at = Placement {
                kind: kind_of(kind)?,
                centre: DVec3::from_array(centres[index]),
                rotation: DQuat::from_xyzw(x, y, z, w),
                semi_axes: DVec3::from_array(semi_axes[index]),
                origin_tendon_m: tendons[index][0],
                insertion_tendon_m: tendons[index][1],
                via_points: points[range].iter().copied().map(DVec3::from_array).collect(),
            };
            core.push(PlacedTissue::new(at, || format!("Tissue {index}")).map_err(into_python)?);
        }
        Ok(Self { core })
    }

    fn __len__(&self) -> usize {
        self.core.len()
    }

    #[getter]
    fn centres<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        self.rows(py, |at| at.centre.to_array())
    }

    #[getter]
    fn rotations<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        self.rows(py, |at| {
            let [x, y, z, w] = at.rotation.to_array();
            [w, x, y, z]
        })
    }

    #[getter]
    fn semi_axes<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        self.rows(py, |at| at.semi_axes.to_array())
    }

    #[getter]
    fn tendons<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        self.rows(py, |at| [at.origin_tendon_m, at.insertion_tendon_m])
    }

    #[getter]
    fn via_offsets<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i32>> {
        let mut offsets = vec![0];
        let mut end = 0;
        for tissue in &self.core {
            end += tissue.placement().via_points.len() as i32;
            offsets.push(end);
        }
        offsets.into_pyarray(py)
    }

    #[getter]
    fn via_points<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        let points = self.core.iter().flat_map(|tissue| &tissue.placement().via_points);
        let points: Vec<[f64; 3]> = points.map(|point| point.to_array()).collect();
        Array2::from(points).into_pyarray(py)
    }
}

impl PlacedTissues {
    fn rows<'py, const N: usize>(
        &self,
        py: Python<'py>,
        row: impl Fn(&Placement) -> [f64; N],
    ) -> Bound<'py, PyArray2<f64>> {
        let rows: Vec<[f64; N]> = self.core.iter().map(|tissue| row(tissue.placement())).collect();
        Array2::from(rows).into_pyarray(py)
    }
}

fn require_offsets(offsets: &[i32], limit: usize) -> PyResult<()> {
    let rises = offsets.is_sorted();
    if rises && offsets.first() == Some(&0) && offsets.last().is_some_and(|&last| last as usize == limit) {
        Ok(())
    } else {
        Err(value_error(format!(
            "via_offsets: expected offsets that rise from 0 to the number of via points, {limit}, got {offsets:?}"
        )))
    }
}
