//! The tissues of a rig in a pose.

use glam::{DAffine3, DMat3, DMat4, DVec3};

use crate::ellipsoid::Ellipsoid;
use crate::error::Result;
use crate::math::rows::Rows;
use crate::muscles::belly_chain::{BellyChain, PosedBellyChain};
use crate::muscles::muscle::Belly;
use crate::muscles::muscle_path::PathBuffers;
use crate::muscles::musculature::Musculature;
use crate::pose::Palette;

/// The motion of the space around a carrier from rest to pose: a point at `surface + fat` in the carrier's
/// rest axes moves to `centre + stretch · surface + turn · fat` in armature space.
#[derive(Debug, Clone, Copy)]
pub struct TissueTransform {
    /// Posed centre, armature space, m.
    pub centre: DVec3,
    /// The carrier's rest axes to armature space, with the change of shape.
    pub stretch: DMat3,
    /// The carrier's rest axes to armature space, without the change of shape.
    pub turn: DMat3,
}

/// The tissues in one pose; one entry per tissue in all lists but `clamped`.
#[derive(Debug, Clone)]
pub struct PosedMusculature {
    /// Unit sphere to posed tissue (the belly of a muscle, the envelope of a bone), armature space.
    pub matrices: Vec<DMat4>,
    /// Posed over rest belly length, without the scale of the rig; 1 for rigid kinds.
    pub stretch: Vec<f64>,
    /// Posed volume, m³.
    pub volume: Vec<f64>,
    /// Indices of the muscles whose belly is close to its minimum length.
    pub clamped: Vec<usize>,
}

/// Polylines along the posed muscles.
#[derive(Debug, Clone, Default)]
pub struct MusclePaths(Rows<DVec3>);

impl MusclePaths {
    /// The points of the path of tissue `tissue`, armature space, m; none for a rigid kind.
    pub fn of(&self, tissue: usize) -> &[DVec3] {
        self.0.row(tissue)
    }

    /// The paths, one per tissue.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &[DVec3]> {
        self.0.rows()
    }

    /// The points of all paths, armature space, m.
    pub fn points(&self) -> &[DVec3] {
        self.0.entries()
    }

    /// The points of tissue t are `offsets[t]..offsets[t + 1]` of [`MusclePaths::points`].
    pub fn offsets(&self) -> &[u32] {
        self.0.offsets()
    }
}

/// The shape of one tissue in a pose.
#[expect(clippy::large_enum_variant)]
enum PosedShape<'a> {
    /// The skinning matrix and scale of its bone.
    Rigid(DAffine3, f64),
    Straight(Belly),
    Curved(&'a BellyChain, PosedBellyChain),
}

impl PosedShape<'_> {
    fn is_clamped(&self) -> bool {
        match self {
            Self::Rigid(..) => false,
            Self::Straight(belly) => belly.is_clamped,
            Self::Curved(_, posed) => posed.is_clamped,
        }
    }
}

impl Musculature {
    /// The tissues in a pose. `tension` has a number 0..1 per tissue.
    ///
    /// # Errors
    /// The same as [`Musculature::require_tension`].
    pub fn pose(&self, palette: &Palette, tension: &[f32]) -> Result<PosedMusculature> {
        self.require_tension(tension)?;
        let mut posed = PosedMusculature {
            matrices: vec![],
            stretch: vec![],
            volume: vec![],
            clamped: vec![],
        };
        let mut buffers = PathBuffers::default();
        for (index, (tissue, &tension)) in self.tissues().iter().zip(tension).enumerate() {
            let rest = tissue.envelope();
            let shape_in_pose = self.shape_in_pose(index, palette, tension, &mut buffers);
            let (shown, rest_volume, shape, scale) = match &shape_in_pose {
                PosedShape::Rigid(transform, scale) => (
                    *transform * unit_sphere_to(rest),
                    tissue.volume(),
                    DVec3::ONE,
                    *scale,
                ),
                PosedShape::Straight(belly) => {
                    let shown = unit_sphere_to(&posed_belly(rest, belly));
                    (shown, tissue.volume(), belly.shape, belly.scale)
                }
                PosedShape::Curved(chain, curved) => {
                    let shown = unit_sphere_to(&chain.shown(curved));
                    (shown, chain.volume(), curved.shape, curved.scale)
                }
            };
            posed.matrices.push(shown.into());
            posed.stretch.push(shape.z);
            posed
                .volume
                .push(rest_volume * shape.element_product() * scale.powi(3));
            if shape_in_pose.is_clamped() {
                posed.clamped.push(index);
            }
        }
        Ok(posed)
    }

    /// All ellipsoids in a pose: unit sphere to posed ellipsoid, armature space, in the order of
    /// [`Musculature::ellipsoids`].
    ///
    /// # Errors
    /// The same as [`Musculature::require_tension`].
    pub fn pose_ellipsoids(&self, palette: &Palette, tension: &[f32]) -> Result<Vec<DMat4>> {
        self.require_tension(tension)?;
        let mut matrices: Vec<DMat4> = Vec::with_capacity(self.ellipsoids().len());
        let mut buffers = PathBuffers::default();
        for (index, (tissue, &tension)) in self.tissues().iter().zip(tension).enumerate() {
            match self.shape_in_pose(index, palette, tension, &mut buffers) {
                PosedShape::Rigid(transform, _) => {
                    let rest = tissue.ellipsoids().iter().map(unit_sphere_to);
                    matrices.extend(rest.map(|rest| DMat4::from(transform * rest)));
                }
                PosedShape::Straight(belly) => {
                    matrices.push(unit_sphere_to(&posed_belly(tissue.envelope(), &belly)).into());
                }
                PosedShape::Curved(chain, posed) => {
                    let links = posed.links.iter().enumerate().map(|(index, link)| Ellipsoid {
                        centre: link.centre,
                        axes: link.axes,
                        semi_axes: chain.semi_axes(index) * posed.shape * posed.scale,
                    });
                    matrices.extend(links.map(|link| DMat4::from(unit_sphere_to(&link))));
                }
            }
        }
        Ok(matrices)
    }

    /// The paths of all muscles in a pose; an empty path for rigid kinds.
    pub fn paths(&self, palette: &Palette) -> MusclePaths {
        let mut paths = Rows::default();
        let mut buffers = PathBuffers::default();
        for (tissue, chain) in self.tissues().iter().zip(self.chains()) {
            match (chain, tissue.muscle()) {
                (Some(chain), _) => {
                    chain.trace(palette, &mut buffers);
                    paths.push(buffers.path.points().iter().copied());
                }
                (None, Some(muscle)) => {
                    let ends = [muscle.origin, muscle.insertion];
                    paths.push(ends.map(|end| end.posed(palette)));
                }
                (None, None) => paths.push([]),
            }
        }
        MusclePaths(paths)
    }

    /// Calls `take` for each carrier of the tissues for which `is_due` is true, in order: with the carrier's
    /// index, its transform in the pose, and whether its belly is clamped. `tension` is already checked.
    pub(crate) fn each_transform(
        &self,
        palette: &Palette,
        tension: &[f32],
        buffers: &mut PathBuffers,
        mut is_due: impl FnMut(usize) -> bool,
        mut take: impl FnMut(usize, TissueTransform, bool),
    ) {
        let mut carrier = 0;
        for (index, &tension) in tension.iter().enumerate() {
            if !is_due(index) {
                carrier += self.chains()[index]
                    .as_ref()
                    .map_or(1, |chain| chain.links().len());
                continue;
            }
            let shape_in_pose = self.shape_in_pose(index, palette, tension, buffers);
            let is_clamped = shape_in_pose.is_clamped();
            let mut add = |transform| {
                take(carrier, transform, is_clamped);
                carrier += 1;
            };
            match shape_in_pose {
                PosedShape::Rigid(bone, _) => {
                    let Ellipsoid { centre, axes, .. } = *self.tissues()[index].envelope();
                    let turn = bone.matrix3 * axes;
                    add(TissueTransform {
                        centre: bone.transform_point3(centre),
                        stretch: turn,
                        turn,
                    });
                }
                PosedShape::Straight(belly) => add(TissueTransform::of(
                    belly.centre,
                    belly.axes * belly.scale,
                    belly.shape,
                )),
                PosedShape::Curved(_, posed) => {
                    for link in posed.links {
                        add(TissueTransform::of(
                            link.centre,
                            link.axes * posed.scale,
                            posed.shape,
                        ));
                    }
                }
            }
        }
    }

    fn shape_in_pose(
        &self,
        tissue: usize,
        palette: &Palette,
        tension: f32,
        buffers: &mut PathBuffers,
    ) -> PosedShape<'_> {
        let rest = &self.tissues()[tissue];
        match (&self.chains()[tissue], rest.muscle()) {
            (Some(chain), _) => PosedShape::Curved(chain, chain.posed(palette, tension.into(), buffers)),
            (None, Some(muscle)) => PosedShape::Straight(muscle.posed(palette, tension.into())),
            (None, None) => {
                let bone = rest.origin_bone();
                PosedShape::Rigid(palette.skinning_matrices()[bone], palette.scales()[bone])
            }
        }
    }
}

impl TissueTransform {
    fn of(centre: DVec3, turn: DMat3, shape: DVec3) -> Self {
        Self {
            centre,
            stretch: turn * DMat3::from_diagonal(shape),
            turn,
        }
    }
}

fn posed_belly(rest: &Ellipsoid, belly: &Belly) -> Ellipsoid {
    Ellipsoid {
        centre: belly.centre,
        axes: belly.axes,
        semi_axes: rest.semi_axes * belly.shape * belly.scale,
    }
}

fn unit_sphere_to(ellipsoid: &Ellipsoid) -> DAffine3 {
    DAffine3 {
        matrix3: ellipsoid.axes * DMat3::from_diagonal(ellipsoid.semi_axes),
        translation: ellipsoid.centre,
    }
}
