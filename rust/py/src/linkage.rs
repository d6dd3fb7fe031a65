//! `Linkage`, `joint_rotation` and `joint_angles`.

use glam::{DAffine3, DMat4, DQuat, DVec3};
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray2};
use pyo3::prelude::*;
use sinew_core::reach::{self, Joint, Parameterisation};

use crate::arrays::{Input, Length, Shape, numbers_of};
use crate::errors::{into_python, value_error};

/// The IK chain: joints as a tree.
#[pyclass(frozen, module = "_sinew")]
pub struct Linkage {
    /// The linkage of the core.
    pub core: reach::Linkage,
}

#[pymethods]
impl Linkage {
    #[new]
    #[pyo3(signature = (names, parents, sockets, parameterisations, angles, lower, upper, *, scales = None, eagerness = None,
        turns_with_parent = None))]
    #[allow(clippy::too_many_arguments)]
    fn new(
        names: Vec<String>,
        parents: &Bound<'_, PyAny>,
        sockets: &Bound<'_, PyAny>,
        parameterisations: Vec<String>,
        angles: &Bound<'_, PyAny>,
        lower: &Bound<'_, PyAny>,
        upper: &Bound<'_, PyAny>,
        scales: Option<&Bound<'_, PyAny>>,
        eagerness: Option<&Bound<'_, PyAny>>,
        turns_with_parent: Option<Vec<bool>>,
    ) -> PyResult<Self> {
        let count = Length::Named('J', names.len());
        let (four, three) = (Length::Exactly(4), [count, Length::Exactly(3)]);
        let parents = Input::<i32>::new("parents", parents, Shape(&[count]))?;
        let sockets = Input::<f64>::new("sockets", sockets, Shape(&[count, four, four]))?;
        let angles = Input::<f64>::new("angles", angles, Shape(&three))?;
        let lower = Input::<f64>::new("lower", lower, Shape(&three))?;
        let upper = Input::<f64>::new("upper", upper, Shape(&three))?;
        let scales = scales
            .map(|scales| Input::<f64>::new("scales", scales, Shape(&three)))
            .transpose()?;
        let eagerness = eagerness
            .map(|eagerness| Input::<f64>::new("eagerness", eagerness, Shape(&[count])))
            .transpose()?;
        let turning = turns_with_parent.unwrap_or_else(|| vec![true; names.len()]);
        for (list, found) in [
            ("parameterisations", parameterisations.len()),
            ("turns_with_parent", turning.len()),
        ] {
            if found != names.len() {
                return Err(value_error(format!(
                    "{list}: expected {} entries, one per name, got {found}",
                    names.len()
                )));
            }
        }
        let (parents, sockets) = (parents.numbers()?, sockets.groups::<16>()?);
        let (angles, lower, upper) = (angles.groups()?, lower.groups()?, upper.groups()?);
        let scales = scales.as_ref().map(Input::groups::<3>).transpose()?;
        let eagerness = eagerness.as_ref().map(Input::numbers).transpose()?;
        let joint = |(index, name): (usize, String)| {
            Ok(Joint {
                parent: parents[index].into(),
                socket: affine(&sockets[index], &name)?,
                turns_with_parent: turning[index],
                scale: scales.map_or(DVec3::ONE, |scales| scales[index].into()),
                parameterisation: parameterisation_of("parameterisations", &parameterisations[index])?,
                angles: DVec3::from_array(angles[index]),
                lower: DVec3::from_array(lower[index]),
                upper: DVec3::from_array(upper[index]),
                eagerness: eagerness.map_or(1.0, |eagerness| eagerness[index]),
                name,
            })
        };
        let joints = names
            .into_iter()
            .enumerate()
            .map(joint)
            .collect::<PyResult<_>>()?;
        Ok(Self {
            core: reach::Linkage::new(joints).map_err(into_python)?,
        })
    }

    fn __len__(&self) -> usize {
        self.core.len()
    }

    #[getter]
    fn freedom_count(&self) -> usize {
        self.core.free_angles().len()
    }

    #[getter]
    fn angles<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        rows(py, self.core.start().iter().map(DVec3::to_array))
    }

    fn heads<'py>(&self, py: Python<'py>, angles: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let angles = angles_of("angles", self.core.len(), angles)?;
        let posed = self.core.posed(&angles).map_err(into_python)?;
        Ok(rows(py, posed.iter().map(|posed| posed.translation.to_array())))
    }
}

/// The rotation (w, x, y, z) of a joint at these angles, rad.
#[pyfunction]
pub fn joint_rotation(parameterisation: &str, angles: &Bound<'_, PyAny>) -> PyResult<[f64; 4]> {
    let rotation = parameterisation_of("parameterisation", parameterisation)?
        .rotation(numbers_of("angles", angles)?.into());
    Ok([rotation.w, rotation.x, rotation.y, rotation.z])
}

/// The angles of a rotation (w, x, y, z) that are nearest to `near`, rad.
#[pyfunction]
pub fn joint_angles(
    parameterisation: &str,
    rotation: &Bound<'_, PyAny>,
    near: &Bound<'_, PyAny>,
) -> PyResult<[f64; 3]> {
    let near = numbers_of("near", near)?.into();
    Ok(parameterisation_of("parameterisation", parameterisation)?
        .angles(quaternion_of("rotation", rotation)?, near)
        .to_array())
}

/// The argument `name`, (w, x, y, z), as a unit quaternion.
pub fn quaternion_of(name: &'static str, argument: &Bound<'_, PyAny>) -> PyResult<DQuat> {
    let [w, x, y, z] = numbers_of(name, argument)?;
    let rotation = DQuat::from_xyzw(x, y, z, w);
    if rotation.length_squared() > 1e-12 {
        Ok(rotation.normalize())
    } else {
        Err(value_error(format!(
            "{name}: expected a quaternion (w, x, y, z) with a length, got zeros"
        )))
    }
}

/// The argument `name` as angles of `count` joints, rad.
pub fn angles_of(name: &'static str, count: usize, argument: &Bound<'_, PyAny>) -> PyResult<Vec<DVec3>> {
    let shape = [Length::Named('J', count), Length::Exactly(3)];
    let angles = Input::<f64>::new(name, argument, Shape(&shape))?;
    Ok(angles
        .groups()?
        .iter()
        .map(|angles| DVec3::from_array(*angles))
        .collect())
}

/// An array with these rows.
pub fn rows<const N: usize>(
    py: Python<'_>,
    rows: impl Iterator<Item = [f64; N]>,
) -> Bound<'_, PyArray2<f64>> {
    Array2::from(rows.collect::<Vec<_>>()).into_pyarray(py)
}

fn affine(columns: &[f64; 16], joint: &str) -> PyResult<DAffine3> {
    let wide = DMat4::from_cols_array(columns);
    if wide.row(3).to_array() == [0.0, 0.0, 0.0, 1.0] {
        Ok(DAffine3::from_mat4(wide))
    } else {
        Err(value_error(format!(
            "sockets: that of \"{joint}\" is not affine: its last row is {:?}; is it row-major?",
            wide.row(3).to_array()
        )))
    }
}

fn parameterisation_of(argument: &str, name: &str) -> PyResult<Parameterisation> {
    let axes = |axes: [usize; 3]| Ok(Parameterisation::Euler(axes));
    match name {
        "BALL" => Ok(Parameterisation::Ball),
        "SWING_TWIST" => Ok(Parameterisation::SwingTwist),
        "XYZ" => axes([0, 1, 2]),
        "XZY" => axes([0, 2, 1]),
        "YXZ" => axes([1, 0, 2]),
        "YZX" => axes([1, 2, 0]),
        "ZXY" => axes([2, 0, 1]),
        "ZYX" => axes([2, 1, 0]),
        _ => Err(value_error(format!(
            "{argument}: expected BALL, SWING_TWIST or an order such as XYZ, got {name:?}"
        ))),
    }
}
