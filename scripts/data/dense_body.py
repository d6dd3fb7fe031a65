"""The real body with more vertices: its largest faces are cut in four until there are enough.

MakeHuman's faces are finest in face and hands; so most of the new vertices lie on limbs and trunk, where skin is relaxed.
Weights are interpolated, as Blender's own Subdivide does.
"""

import bmesh

NEW_VERTICES_A_FACE = 3  # a grid of faces cut in four has one new vertex in each and one for two of its four edges


def subdivide(mesh, vertices: int) -> None:
    """Cuts the largest faces of a mesh until it has about `vertices`; one that has more is left as it is."""
    cutting = bmesh.new()
    cutting.from_mesh(mesh)
    while len(cutting.verts) < vertices:
        missing = (vertices - len(cutting.verts)) // NEW_VERTICES_A_FACE
        if missing < 1:
            break
        largest = sorted(cutting.faces, key=lambda face: face.calc_area(), reverse=True)[:missing]
        edges = list({edge for face in largest for edge in face.edges})
        bmesh.ops.subdivide_edges(cutting, edges=edges, cuts=1, use_grid_fill=True)
    cutting.to_mesh(mesh)
    cutting.free()
