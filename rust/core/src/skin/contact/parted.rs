//! Which pairs of clusters are clear of each other in a pose, so that their skin need not be looked at closer: most of those whose
//! balls meet, in a crook above all.

use glam::Vec3A;

use super::Contact;
use super::clusters::{Pair, PosedCluster};

/// Cosine of the facings of two clusters above which no plane between them is looked for: one hardly faces the other.
const ASKEW: f32 = 0.5;

/// The boxes around clusters as they lie.
#[derive(Debug)]
pub(super) struct Parted {
    boxes: Vec<Option<(Vec3A, Vec3A)>>,
}

impl Parted {
    pub fn new(clusters: usize) -> Self {
        Self {
            boxes: vec![None; clusters],
        }
    }

    /// Takes the pairs away that lie farther apart than skin is moved, or on the outer sides of a plane between them; the vertices of
    /// all clusters in `pairs` lie at `places`.
    pub fn drop_from(
        &mut self,
        contact: &Contact,
        posed: &[PosedCluster],
        places: &[Vec3A],
        pairs: &mut Vec<Pair>,
    ) {
        self.boxes.fill(None);
        for cluster in pairs.iter().flat_map(|pair| [pair.one, pair.other]) {
            let own = &mut self.boxes[cluster as usize];
            if own.is_none() {
                let vertices = contact.clusters[cluster as usize].vertices.iter();
                *own = vertices
                    .map(|&vertex| places[vertex as usize])
                    .fold(None, |held, place| {
                        let (low, high) = held.unwrap_or((place, place));
                        Some((low.min(place), high.max(place)))
                    });
            }
        }
        pairs.retain(|pair| {
            let scale = posed[pair.one as usize]
                .scale
                .max(posed[pair.other as usize].scale);
            let (one, other) = (self.boxes[pair.one as usize], self.boxes[pair.other as usize]);
            let (Some(one), Some(other)) = (one, other) else {
                return false;
            };
            let gap = (one.0 - other.1).max(other.0 - one.1).max(Vec3A::ZERO);
            gap.length_squared() < (contact.reach_m * scale).powi(2)
                && !contact.is_parted(pair, posed, places, contact.margin_m * scale)
        });
    }
}

impl Contact {
    /// Whether the skin of a pair lies on the outer sides of a plane, with `margin_m` between.
    fn is_parted(&self, pair: &Pair, posed: &[PosedCluster], places: &[Vec3A], margin_m: f32) -> bool {
        let facing = |cluster: u32| posed[cluster as usize].facing;
        if facing(pair.one).dot(facing(pair.other)) > ASKEW {
            return false;
        }
        let outwards = (facing(pair.one) - facing(pair.other)).normalize_or_zero();
        let heights = |cluster: u32| {
            let vertices = self.clusters[cluster as usize].vertices.iter();
            vertices.map(|&vertex| places[vertex as usize].dot(outwards))
        };
        let highest = heights(pair.one).fold(f32::NEG_INFINITY, f32::max);
        heights(pair.other).fold(f32::INFINITY, f32::min) > highest + margin_m
    }
}
