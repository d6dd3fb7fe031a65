"""Adds vertices to the real body: divides its largest faces in four until there are enough.

MakeHuman's faces are smallest in face and hands, so most of the new vertices are on limbs and trunk, where skin is relaxed.
Weights are interpolated, as in Blender's Subdivide.
"""

import bmesh

NEW_VERTICES_PER_FACE = (
    3  # a grid of divided faces: one new vertex per face, and one per edge, of which there are two per face
)


def subdivide(mesh, vertices: int) -> None:
    """Divides the largest faces of a mesh until it has about `vertices`. A mesh that has more does not change."""
    cutting = bmesh.new()
    cutting.from_mesh(mesh)
    while len(cutting.verts) < vertices:
        missing = (vertices - len(cutting.verts)) // NEW_VERTICES_PER_FACE
        if missing < 1:
            break
        largest = sorted(cutting.faces, key=lambda face: face.calc_area(), reverse=True)[:missing]
        edges = list({edge for face in largest for edge in face.edges})
        bmesh.ops.subdivide_edges(cutting, edges=edges, cuts=1, use_grid_fill=True)
    cutting.to_mesh(mesh)
    cutting.free()
