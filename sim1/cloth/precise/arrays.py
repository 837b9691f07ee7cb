"""What the compiled loops work on: plain arrays in named tuples."""

from collections import namedtuple

import numpy as np

# Shared by all worlds of a simulation. V vertices, F faces, C curvature stencils, H held vertices, G grips, M markers.
Net = namedtuple(
    "Net",
    [
        "faces",  # (F, 3)
        "first",  # (C + 1,) where the nodes of each stencil start
        "node",  # (n,) vertices of the stencils
        "centre",  # (C,) vertex in the middle of each stencil
        "second",  # (n, 3) weights of d2/du2, d2/dv2, d2/dudv [1/m^2]
        "slope",  # (n, 2) weights of d/du, d/dv [1/m]
        "ripple",  # (n, R) weights of what no quadratic follows [1/m^2], unused columns zero
        "star_first",  # (V + 1,) where the faces around each vertex start
        "star_face",  # (3 F,)
        "star_local",  # (3 F, 3) places of the face's corners in the ring of the vertex
        "ring_first",  # (V + 1,) where the ring of each vertex starts
        "ring_node",  # (r,) vertices of the faces around each vertex
        "pair",  # (B, 2) vertices i >= j that share a ring or a stencil
        "ring_pair",  # of every vertex the pairs (a, b), b <= a, of its ring, row by row: their places in `pair`
        "stencil_pair",  # likewise of every stencil
        "face_pair",  # (F, 3, 3) of corners, of which the first has the higher number; else of no meaning
        "held",  # (H,) vertices
        "grip",  # (H,) which grip holds each
        "marker_node",  # (M, 3)
        "marker_weight",  # (M, 3)
    ],
)

# One row per world P: the first is the base, the others its twins.
Cloth = namedtuple(
    "Cloth",
    [
        "scalar",  # (P, SCALARS)
        "gradient",  # (P, F, 3, 2) derivatives of the shape functions [1/m]
        "area",  # (P, F) [m^2]
        "law",  # (P, 4) c_uu, c_vv, c_uv, c_shear [N/m]
        "mass",  # (P, V) [kg]
        "inertia",  # (P, F) [kg] by which accelerations of a face's corners act on each other
        "vertex_area",  # (P, V) [m^2]
        "bend",  # (P, C, 3) rigidity times area of uu, vv, and twice uv [N m^3]
        "ripple",  # (P, C) rigidity times area of what no quadratic follows [N m^3]
        "curl",  # (P, C, 3) rest curvature [1/m]
        "bend_area",  # (P, C) [m^2]
        "push",  # (P, 2, V, 3), or of no world: a push [N] and a brake [N s/m] without a name
    ],
)

# Columns of `Cloth.scalar`.
(
    DAMPING,
    AIR_NORMAL,
    AIR_SKIN,
    WIND_X,
    WIND_Y,
    WIND_Z,
    GRAVITY_X,
    GRAVITY_Y,
    GRAVITY_Z,
    ADDED_MASS,
    TABLE_Z,
    FRICTION_X,
    FRICTION_Y,
    STICTION,
    STRIBECK,
    ADHESION,
    CLING,
    HYSTERESIS,
    TURN_CURVATURE,
    YIELD,
    RETAINED,
    COMPLIANCE,
    SLIP_THRESHOLD,
    SLIP_RATE,
    STIFFENING,
    PULL_STIFFNESS,
    PULL_DAMPING,
) = range(27)
SCALARS = 27

# Numbers that loops hand on to loops, numpy's: a loop that is called with a literal is compiled once more for it.
BASE = np.int64(0)  # the row of the base
DEFINITE = np.int64(0)  # kind of a matrix: its Cholesky factor is there
ALL_FACES = np.bool_(False)  # compressed ones keep their geometric part: not tension only
