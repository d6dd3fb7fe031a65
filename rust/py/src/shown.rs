//! `ShownTissues`.

use glam::{DQuat, DVec3};
use pyo3::prelude::*;
use sinew_core::{AngleOrder, ColumnMajor, Error, ShownTissue, Transform};

use crate::arrays::{Input, Length, Output, Shape};
use crate::errors::{into_python, value_error};
use crate::skeleton::Skeleton;
use crate::threads::in_pool;

/// Numbers of a delta transform: location 3, quaternion 4, angles 3, scale 3.
const WIDTH: usize = 13;
/// The rounding of a last row that counts as (0, 0, 0, 1), as for poses in the core.
const PROJECTIVE_TOLERANCE: f32 = 1e-4;

/// The objects that show the tissues of a rig.
#[pyclass(frozen, module = "_sinew")]
pub struct ShownTissues {
    shown: Vec<ShownTissue>,
    bones: usize,
}

#[pymethods]
impl ShownTissues {
    #[new]
    #[pyo3(signature = (skeleton, names, bones, to_bones, locations, rotations, scales, orders))]
    #[allow(clippy::too_many_arguments)]
    fn new(
        skeleton: &Skeleton,
        names: Vec<String>,
        bones: &Bound<'_, PyAny>,
        to_bones: &Bound<'_, PyAny>,
        locations: &Bound<'_, PyAny>,
        rotations: &Bound<'_, PyAny>,
        scales: &Bound<'_, PyAny>,
        orders: Vec<String>,
    ) -> PyResult<Self> {
        let (count, three, four) = (
            Length::Named('T', names.len()),
            Length::Exactly(3),
            Length::Exactly(4),
        );
        let bones = Input::<i32>::new("bones", bones, Shape(&[count]))?;
        let to_bones = Input::<f32>::new("to_bones", to_bones, Shape(&[count, four, four]))?;
        let locations = Input::<f32>::new("locations", locations, Shape(&[count, three]))?;
        let rotations = Input::<f32>::new("rotations", rotations, Shape(&[count, four]))?;
        let scales = Input::<f32>::new("scales", scales, Shape(&[count, three]))?;
        if orders.len() != names.len() {
            let (found, expected) = (orders.len(), names.len());
            return Err(value_error(format!(
                "orders: expected {expected}, one per tissue, got {found}"
            )));
        }
        let (bones, to_bones): (_, &[ColumnMajor]) = (bones.numbers()?, to_bones.groups()?);
        let (locations, rotations, scales) = (locations.groups()?, rotations.groups()?, scales.groups()?);
        let mut shown = Vec::with_capacity(names.len());
        for (index, name) in names.iter().enumerate() {
            let bone = bone_of(bones, index, skeleton)?;
            let rest = Transform {
                location: vector(locations[index]),
                rotation: quaternion(rotations[index]),
                scale: vector(scales[index]),
            };
            let order = order_of(&orders[index])?;
            shown.push(ShownTissue::new(bone, &to_bones[index], rest, order, name).map_err(into_python)?);
        }
        Ok(Self {
            shown,
            bones: skeleton.core.len(),
        })
    }

    fn __len__(&self) -> usize {
        self.shown.len()
    }

    fn deltas<'py>(
        &self,
        py: Python<'py>,
        pose: &Bound<'py, PyAny>,
        posed: &Bound<'py, PyAny>,
        out: &Bound<'py, PyAny>,
    ) -> PyResult<()> {
        let (count, four) = (Length::Named('T', self.shown.len()), Length::Exactly(4));
        let pose = Input::<f32>::new("pose", pose, Shape(&[Length::Named('B', self.bones), four, four]))?;
        let posed = Input::<f32>::new("posed", posed, Shape(&[count, four, four]))?;
        let out = Output::<f32>::new("out", out, Shape(&[count, Length::Exactly(WIDTH)]))?;
        let mut out = out.view(&[&pose, &posed])?;
        let (pose, posed, out): (&[ColumnMajor], &[ColumnMajor], _) =
            (pose.groups()?, posed.groups()?, out.groups()?);
        require_affine("pose", pose)?;
        require_affine("posed", posed)?;
        in_pool(py, || {
            for ((object, posed), out) in self.shown.iter().zip(posed).zip(out) {
                *out = numbers(object.delta(&pose[object.bone()], posed));
            }
        });
        Ok(())
    }
}

/// Requires that the last row of each matrix is (0, 0, 0, 1).
fn require_affine(name: &str, matrices: &[ColumnMajor]) -> PyResult<()> {
    for (index, matrix) in matrices.iter().enumerate() {
        let row = [matrix[3], matrix[7], matrix[11], matrix[15]];
        let is_flat = row
            .iter()
            .zip([0.0, 0.0, 0.0, 1.0])
            .all(|(found, expected)| (found - expected).abs() <= PROJECTIVE_TOLERANCE);
        if !is_flat {
            return Err(value_error(format!(
                "{name}: matrix {index} is not affine: its last row is {row:?}; is it row-major?"
            )));
        }
    }
    Ok(())
}

fn numbers(delta: sinew_core::Delta) -> [f32; WIDTH] {
    let [x, y, z, w] = delta.rotation.to_array();
    let rotation = [w, x, y, z];
    let parts = delta.location.to_array().into_iter().chain(rotation);
    let parts = parts.chain(delta.angles.to_array()).chain(delta.scale.to_array());
    let mut numbers = [0.0; WIDTH];
    numbers
        .iter_mut()
        .zip(parts)
        .for_each(|(slot, part)| *slot = part as f32);
    numbers
}

fn vector(numbers: [f32; 3]) -> DVec3 {
    DVec3::from_array(numbers.map(f64::from))
}

/// A unit quaternion from (w, x, y, z).
fn quaternion(numbers: [f32; 4]) -> DQuat {
    let [w, x, y, z] = numbers.map(f64::from);
    DQuat::from_xyzw(x, y, z, w).normalize()
}

fn bone_of(bones: &[i32], position: usize, skeleton: &Skeleton) -> PyResult<usize> {
    let (found, limit) = (bones[position], skeleton.core.len());
    let bone = usize::try_from(found).ok().filter(|&bone| bone < limit);
    bone.ok_or_else(|| {
        into_python(Error::Index {
            list: "bones",
            position,
            found: found.into(),
            limit,
            of: "bones",
        })
    })
}

fn order_of(order: &str) -> PyResult<AngleOrder> {
    match order {
        "XYZ" => Ok(AngleOrder::Xyz),
        "XZY" => Ok(AngleOrder::Xzy),
        "YXZ" => Ok(AngleOrder::Yxz),
        "YZX" => Ok(AngleOrder::Yzx),
        "ZXY" => Ok(AngleOrder::Zxy),
        "ZYX" => Ok(AngleOrder::Zyx),
        _ => Err(value_error(format!(
            "orders: expected XYZ, XZY, YXZ, YZX, ZXY or ZYX, got {order:?}"
        ))),
    }
}
