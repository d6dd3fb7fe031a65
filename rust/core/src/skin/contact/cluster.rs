//! Clusters for the broad phase: patches of skin of one segment, each in a sphere that moves with a bone
//! (mathematics/contact.md, Skin contact).

use std::ops::Range;

use glam::{DVec3, Vec3A};

use crate::skin::contact::contact_mesh::ContactMesh;
use crate::skin::contact::facing::FACING;
use crate::skin::mesh::vertex_order;

/// Angle that skin may rotate against the bone that moves it most, rad: roughly half of a bent joint.
const NORMAL_SLACK: f32 = 0.4;

/// The clusters of a bone, in a sphere that contains them.
#[derive(Debug)]
pub(crate) struct BoneClusters {
    pub bone: usize,
    pub segment: i32,
    pub clusters: Range<usize>,
    /// Centre of the sphere at rest, m.
    pub centre: Vec3A,
    pub radius_m: f32,
    /// Radius of the smallest cluster, m.
    pub smallest_m: f32,
}

/// A patch of skin, at rest.
#[derive(Debug)]
pub(crate) struct Cluster {
    /// The bone that moves most of it.
    pub bone: usize,
    pub segment: i32,
    /// Centre of its bounding sphere, m.
    pub centre: Vec3A,
    pub radius_m: f32,
    /// Mean of its normals, the axis of its normal cone.
    pub axis: Vec3A,
    pub cone: NormalCone,
    /// Cosine between its axis and a normal below which skin with that normal may face some of it.
    pub min_opposing_cos: f32,
    pub vertices: Range<usize>,
    /// Its vertices and the corners of the triangles around them.
    pub with_corners: Vec<u32>,
    /// Longest edge at its vertices, m.
    pub longest_edge_m: f32,
}

/// Normal cone: the largest angle of a cluster's normals from its axis in any pose, approximately; rad.
/// Sine and cosine are stored because a frame needs them for thousands of pairs.
#[derive(Debug, Clone, Copy)]
pub(crate) struct NormalCone {
    angle: f32,
    sin: f32,
    cos: f32,
}

impl NormalCone {
    fn new(angle: f32) -> Self {
        let (sin, cos) = angle.sin_cos();
        Self { angle, sin, cos }
    }

    /// The sum of two cones: the largest angle between normals of two clusters whose axes are parallel.
    pub fn and(self, other: Self) -> Self {
        Self {
            angle: self.angle + other.angle,
            sin: self.sin * other.cos + self.cos * other.sin,
            cos: self.cos * other.cos - self.sin * other.sin,
        }
    }

    /// The cone at rest.
    pub fn at_rest(self) -> Self {
        Self::new(self.angle - NORMAL_SLACK)
    }

    /// Normal-cone test: two clusters may contain opposing normals if the cosine of their axes is below
    /// `cos(acos FACING - angle)`.
    pub fn min_opposing_cos(self) -> f32 {
        self.min_cos(FACING)
    }

    /// As [`NormalCone::min_opposing_cos`], for normals whose cosine is below `limit`.
    pub fn min_cos(self, limit: f32) -> f32 {
        if self.angle >= limit.acos() {
            f32::INFINITY
        } else {
            limit * self.cos + (1.0 - limit * limit).sqrt() * self.sin
        }
    }
}

/// Two clusters that may touch.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Pair {
    pub one: u32,
    pub other: u32,
}

/// The clusters of all vertices that bones move.
pub(crate) fn clusters(mesh: &ContactMesh, normals: &[Vec3A]) -> Vec<Cluster> {
    let around = around(mesh);
    mesh.clusters
        .iter()
        .map(|cluster| Cluster::new(mesh, normals, cluster, &around))
        .collect()
}

/// The clusters, which are sorted by bone, with a sphere for each bone.
pub(crate) fn by_bone(clusters: &[Cluster]) -> Vec<BoneClusters> {
    let mut first = 0;
    let bones = clusters.chunk_by(|a, b| a.bone == b.bone).map(|members| {
        let centre = members.iter().map(|cluster| cluster.centre).sum::<Vec3A>() / members.len() as f32;
        let reach = |cluster: &Cluster| cluster.centre.distance(centre) + cluster.radius_m;
        first += members.len();
        BoneClusters {
            bone: members[0].bone,
            segment: members[0].segment,
            clusters: first - members.len()..first,
            centre,
            radius_m: members.iter().map(reach).fold(0.0, f32::max),
            smallest_m: members
                .iter()
                .map(|cluster| cluster.radius_m)
                .fold(f32::INFINITY, f32::min),
        }
    });
    bones.collect()
}

/// The cluster of each vertex; `u32::MAX` if it is in none.
pub(crate) fn cluster_of(clusters: &[Cluster], vertices: usize) -> Vec<u32> {
    let mut cluster_of = vec![u32::MAX; vertices];
    for (index, cluster) in clusters.iter().enumerate() {
        cluster_of[cluster.vertices.clone()].fill(index as u32);
    }
    cluster_of
}

/// The corners of the triangles at each vertex.
fn around(mesh: &ContactMesh) -> Vec<Vec<u32>> {
    let mut around = vec![vec![]; mesh.points.len()];
    for triangle in mesh.triangles {
        for &vertex in triangle {
            around[vertex as usize].extend_from_slice(triangle);
        }
    }
    around
}

impl Cluster {
    /// Its vertices and the corners of the triangles around them.
    pub fn with_corners(&self) -> impl Iterator<Item = usize> {
        self.with_corners.iter().map(|&vertex| vertex as usize)
    }

    /// Whether a vertex of it may be within `reach_m` of a position at rest.
    pub fn may_reach(&self, position: Vec3A, reach_m: f32) -> bool {
        self.centre.distance(position) < self.radius_m + reach_m
    }

    fn new(
        mesh: &ContactMesh,
        normals: &[Vec3A],
        cluster: &vertex_order::Cluster,
        around: &[Vec<u32>],
    ) -> Self {
        let vertex_order::Cluster { bone, ref vertices } = *cluster;
        let points = &mesh.points[vertices.clone()];
        let centre = points.iter().sum::<DVec3>() / points.len() as f64;
        let radius = points
            .iter()
            .map(|point| point.distance(centre))
            .fold(0.0, f64::max);
        let normals = &normals[vertices.clone()];
        let facing = normals.iter().sum::<Vec3A>().normalize_or(Vec3A::Z);
        let angles = normals.iter().map(|normal| normal.angle_between(facing));
        let cone = NormalCone::new(angles.fold(0.0, f32::max) + NORMAL_SLACK);
        let mut with_corners: Vec<u32> = vertices
            .clone()
            .flat_map(|vertex| around[vertex].iter().copied().chain([vertex as u32]))
            .collect();
        with_corners.sort_unstable();
        with_corners.dedup();
        let lengths = vertices.clone().flat_map(|vertex| {
            let position = mesh.points[vertex];
            let around = around[vertex].iter();
            around.map(move |&corner| mesh.points[corner as usize].distance(position))
        });
        let longest_edge = lengths.fold(0.0, f64::max);
        Self {
            bone,
            segment: mesh.segments.of_bone[bone],
            centre: centre.as_vec3a(),
            radius_m: radius as f32,
            cone,
            min_opposing_cos: cone.min_opposing_cos(),
            axis: facing,
            vertices: vertices.clone(),
            with_corners,
            longest_edge_m: longest_edge as f32,
        }
    }
}
