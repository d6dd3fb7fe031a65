//! How the tissues of a rig stand in a pose.

use glam::{DAffine3, DMat3, DMat4, DVec3};

use crate::ellipsoid::Ellipsoid;
use crate::error::Result;
use crate::muscles::belly_chain::{BellyChain, PosedBellyChain};
use crate::muscles::muscle::Belly;
use crate::muscles::muscle_path::PathBuffers;
use crate::muscles::musculature::Musculature;
use crate::pose::Palette;

/// What a pose does to the space around a carrier: a point at `surface + fat` in its rest frame goes to
/// `centre + stretch · surface + turn · fat`.
#[derive(Debug, Clone, Copy)]
pub struct TissueTransform {
    /// Posed centre, armature space, m.
    pub centre: DVec3,
    /// Rest frame to armature space, with the change of shape.
    pub stretch: DMat3,
    /// Rest frame to armature space, without it.
    pub turn: DMat3,
}

/// What one pose did to the tissues.
#[derive(Debug, Clone)]
pub struct PosedMusculature {
    /// Unit sphere to posed tissue (belly, or envelope of a bone), armature space; one a tissue.
    pub matrices: Vec<DMat4>,
    /// Posed over rest belly length, without the rig's scale; 1 for rigid kinds.
    pub stretch: Vec<f64>,
    /// Posed volume, m³.
    pub volume: Vec<f64>,
    /// Indices of the muscles whose belly came near its floor.
    pub clamped: Vec<usize>,
}

/// Polylines along the posed muscles, one after the other.
#[derive(Debug, Clone, Default)]
pub struct MusclePaths {
    /// Points, armature space, m.
    pub points: Vec<DVec3>,
    /// Tissue t has the points `offsets[t]..offsets[t + 1]`: none for a rigid kind.
    pub offsets: Vec<usize>,
}

/// How one tissue stands.
// One lives at a time, on the stack; a box would allocate in every frame.
#[expect(clippy::large_enum_variant)]
enum PosedShape<'a> {
    /// Its bone's carry and scale.
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
    /// The tissues in a pose; `tension` 0..1, one a tissue.
    ///
    /// # Errors
    /// As [`Musculature::require_tension`].
    pub fn pose(&self, palette: &Palette, tension: &[f32]) -> Result<PosedMusculature> {
        self.require_tension(tension)?;
        let mut posed = PosedMusculature {
            matrices: vec![],
            stretch: vec![],
            volume: vec![],
            clamped: vec![],
        };
        let mut tracing = PathBuffers::default();
        for (index, (tissue, &tension)) in self.tissues().iter().zip(tension).enumerate() {
            let rest = tissue.envelope();
            let stand = self.stand(index, palette, tension, &mut tracing);
            let (shown, rest_volume, shape, scale) = match &stand {
                PosedShape::Rigid(carry, scale) => {
                    (*carry * unit_sphere_to(rest), tissue.volume(), DVec3::ONE, *scale)
                }
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
            if stand.is_clamped() {
                posed.clamped.push(index);
            }
        }
        Ok(posed)
    }

    /// All ellipsoids in a pose: unit sphere to posed ellipsoid, armature space, in the order of
    /// [`Musculature::ellipsoids`].
    ///
    /// # Errors
    /// As [`Musculature::require_tension`].
    pub fn pose_ellipsoids(&self, palette: &Palette, tension: &[f32]) -> Result<Vec<DMat4>> {
        self.require_tension(tension)?;
        let mut matrices: Vec<DMat4> = Vec::with_capacity(self.ellipsoids().len());
        let mut tracing = PathBuffers::default();
        for (index, (tissue, &tension)) in self.tissues().iter().zip(tension).enumerate() {
            match self.stand(index, palette, tension, &mut tracing) {
                PosedShape::Rigid(carry, _) => {
                    let own = tissue.ellipsoids().iter().map(unit_sphere_to);
                    matrices.extend(own.map(|own| DMat4::from(carry * own)));
                }
                PosedShape::Straight(belly) => {
                    matrices.push(unit_sphere_to(&posed_belly(tissue.envelope(), &belly)).into());
                }
                PosedShape::Curved(chain, posed) => {
                    let links = posed.frames.iter().enumerate().map(|(link, frame)| Ellipsoid {
                        centre: frame.centre,
                        axes: frame.axes,
                        semi_axes: chain.semi_axes(link) * posed.shape * posed.scale,
                    });
                    matrices.extend(links.map(|link| DMat4::from(unit_sphere_to(&link))));
                }
            }
        }
        Ok(matrices)
    }

    /// The paths of all muscles in a pose.
    pub fn paths(&self, palette: &Palette) -> MusclePaths {
        let mut paths = MusclePaths {
            points: vec![],
            offsets: vec![0],
        };
        let mut tracing = PathBuffers::default();
        for (tissue, chain) in self.tissues().iter().zip(self.chains()) {
            match (chain, tissue.muscle()) {
                (Some(chain), _) => {
                    chain.trace(palette, &mut tracing);
                    paths.points.extend_from_slice(tracing.path.points());
                }
                (None, Some(muscle)) => {
                    let ends = [muscle.origin, muscle.insertion];
                    paths.points.extend(ends.map(|end| end.posed(palette)));
                }
                (None, None) => {}
            }
            paths.offsets.push(paths.points.len());
        }
        paths
    }

    /// Gives `take` the index of each carrier of the tissues that are `due`, what a pose does to the skin around it, and
    /// whether its belly came near its floor; in order. `tension` is a checked one; `tracing` a buffer.
    pub(crate) fn carry_each(
        &self,
        palette: &Palette,
        tension: &[f32],
        tracing: &mut PathBuffers,
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
            let stand = self.stand(index, palette, tension, tracing);
            let is_clamped = stand.is_clamped();
            let mut give = |carry| {
                take(carrier, carry, is_clamped);
                carrier += 1;
            };
            match stand {
                PosedShape::Rigid(bone, _) => {
                    let Ellipsoid { centre, axes, .. } = *self.tissues()[index].envelope();
                    let turn = bone.matrix3 * axes;
                    give(TissueTransform {
                        centre: bone.transform_point3(centre),
                        stretch: turn,
                        turn,
                    });
                }
                PosedShape::Straight(belly) => give(TissueTransform::of(
                    belly.centre,
                    belly.axes * belly.scale,
                    belly.shape,
                )),
                PosedShape::Curved(_, posed) => {
                    for frame in posed.frames {
                        give(TissueTransform::of(
                            frame.centre,
                            frame.axes * posed.scale,
                            posed.shape,
                        ));
                    }
                }
            }
        }
    }

    fn stand(
        &self,
        tissue: usize,
        palette: &Palette,
        tension: f32,
        tracing: &mut PathBuffers,
    ) -> PosedShape<'_> {
        let own = &self.tissues()[tissue];
        match (&self.chains()[tissue], own.muscle()) {
            (Some(chain), _) => PosedShape::Curved(chain, chain.posed(palette, tension.into(), tracing)),
            (None, Some(muscle)) => PosedShape::Straight(muscle.posed(palette, tension.into())),
            (None, None) => {
                let bone = own.origin_bone();
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
