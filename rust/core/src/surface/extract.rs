//! The surface of a field as quads: one vertex in each cell that it passes, one quad across each edge between
//! inside and outside (naive surface nets, with the crate `fast-surface-nets`).
//!
//! The crate was chosen among the maintained isosurface crates for its result: quads with four neighbours at
//! almost all vertices, which users can edit. Marching cubes (`splashsurf_lib`, `transvoxel`, `isosurface`)
//! make triangles with slivers. It also takes arrays brick by brick, whereas `isosurface` and `tessellation`
//! call a function for the whole grid. Its one fault, a common vertex of several surfaces in ambiguous cells,
//! cannot occur in a well-composed field (`repair`).

use fast_surface_nets::ndshape::ConstShape3u32;
use fast_surface_nets::{SurfaceNetsBuffer, surface_nets};
use glam::{DVec3, IVec3, Vec3};
use rayon::prelude::*;
use rustc_hash::FxHashMap;

use super::bricks::{Bricks, first_of};

/// A brick with one voxel around it.
type Shape = ConstShape3u32<10, 10, 10>;
/// Smallest absolute depth, in voxels, for the positions of vertices. A surface through the centre of a voxel
/// would move the vertices of eight cells to the same point.
const LEAST_DEPTH: f32 = 0.1;

/// A surface of quads.
#[derive(Debug, Clone, Default)]
pub(super) struct QuadMesh {
    /// Positions of the vertices, in voxels.
    pub positions: Vec<DVec3>,
    /// The cell of each vertex, named by its first voxel.
    pub cells: Vec<IVec3>,
    /// Corners of the quads, counter-clockwise seen from outside.
    pub quads: Vec<[u32; 4]>,
}

/// The cells and quads of one brick. Corners of quads are indices of these cells.
#[derive(Default)]
struct Piece {
    cells: Vec<(IVec3, Vec3)>,
    quads: Vec<[u32; 4]>,
}

/// The surface of a well-composed field.
pub(super) fn extract(bricks: &Bricks) -> QuadMesh {
    let pieces: Vec<Piece> = bricks
        .stored()
        .par_iter()
        .map_init(
            || (vec![], SurfaceNetsBuffer::default()),
            |(around, buffer), &brick| piece_of(bricks, brick, around, buffer),
        )
        .collect();
    let mut mesh = QuadMesh::default();
    let mut numbers: FxHashMap<IVec3, u32> = FxHashMap::default();
    for piece in &pieces {
        let numbers: Vec<u32> = piece
            .cells
            .iter()
            .map(|&(cell, position)| {
                *numbers.entry(cell).or_insert_with(|| {
                    mesh.cells.push(cell);
                    mesh.positions.push(cell.as_dvec3() + position.as_dvec3());
                    mesh.cells.len() as u32 - 1
                })
            })
            .collect();
        let quads = piece.quads.iter();
        mesh.quads
            .extend(quads.map(|quad| quad.map(|corner| numbers[corner as usize])));
    }
    mesh
}

fn piece_of(bricks: &Bricks, brick: IVec3, around: &mut Vec<f32>, buffer: &mut SurfaceNetsBuffer) -> Piece {
    bricks.gather(brick, 1, around);
    let is_inside = around[0] > 0.0;
    if around.iter().all(|depth| (*depth > 0.0) == is_inside) {
        return Piece::default();
    }
    // the crate takes distances, negative inside
    for depth in around.iter_mut() {
        *depth = if *depth > 0.0 {
            -depth.max(LEAST_DEPTH)
        } else {
            -depth.min(-LEAST_DEPTH)
        };
    }
    surface_nets(around, &Shape {}, [0; 3], [9; 3], buffer);
    let first = first_of(brick) - 1;
    // A vertex is identified by its cell, and its position depends only on the eight values of the cell. So
    // bricks with a common cell agree.
    let cells = buffer.surface_points.iter().zip(&buffer.positions);
    let cells = cells.map(|(&cell, &position)| {
        let cell = IVec3::from_array(cell.map(|at| at as i32));
        (first + cell, Vec3::from_array(position) - cell.as_vec3())
    });
    Piece {
        cells: cells.collect(),
        quads: buffer.indices.as_chunks().0.iter().map(quad_of).collect(),
    }
}

/// The quad that the crate split into two triangles.
fn quad_of(&[a, b, c, _, e, f]: &[u32; 6]) -> [u32; 4] {
    if f == b { [a, e, b, c] } else { [a, b, c, f] }
}
