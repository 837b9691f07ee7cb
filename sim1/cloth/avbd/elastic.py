"""Elastic terms of a cloth: membrane, hinges, strain limit. Each gives force and a positive semi-definite Hessian block.

Sources: the SIM1 paper, appendix A (St. Venant-Kirchhoff membrane, dihedral-angle bending, strain limit); VBD (Chen et al.
2024) for the vertex blocks. Hessians leave out what could make them indefinite: compressive stress in the membrane, the
curvature of the dihedral angle.
"""

import warp as wp

from sim1.cloth.avbd.iterate import Iterate, StepNumbers
from sim1.cloth.avbd.sheet import Part, Sheet


@wp.func
def frame(corner: wp.vec3i, pose: wp.mat22, x: wp.array(dtype=wp.vec3)):
    """Columns of the deformation gradient of a triangle, 3 x 2."""
    origin = x[corner[0]]
    first = x[corner[1]] - origin
    second = x[corner[2]] - origin
    return first * pose[0, 0] + second * pose[1, 0], first * pose[0, 1] + second * pose[1, 1]


@wp.func
def green_strain(f1: wp.vec3, f2: wp.vec3):
    """Green strain, Voigt: (G11, G22, 2 G12)."""
    return wp.vec3(0.5 * (wp.dot(f1, f1) - 1.0), 0.5 * (wp.dot(f2, f2) - 1.0), wp.dot(f1, f2))


@wp.func
def slackened(part: Part, s1: float, s2: float, strain: wp.vec3, share: float):
    """What moves a block (see `Part`) by `share` of the full law's stress, the rest by tension field theory.

    Wagner 1929; Pipkin 1986. A strip of width h buckles at pi^2 D / h^2, far below what a membrane would take; folds finer than
    an edge are not in the mesh, so they are in its law. Taut where both principal stresses pull, E e n n^T where one alone
    would, nothing where the cloth is shorter in both directions: the slope of the relaxed energy, so that no closed round of
    strains gives work.

    Strains are taken as D G D, D = diag(g, 1), in which a law with C33 = (sqrt(C11 C22) - C12) / 2 is isotropic. D G D is
    negative wherever G is: what wrinkles may take up is the same in both, and so is the energy that they leave.
    """
    lean = part.lean
    first = lean * lean * strain[0]
    mean = 0.5 * (first + strain[1])
    half = 0.5 * (first - strain[1])
    shear = 0.5 * lean * strain[2]
    radius = wp.sqrt(half * half + shear * shear)
    high = mean + radius
    if mean - radius + part.beside * high >= 0.0:
        return s1, s2
    if high <= 0.0:
        return share * s1, share * s2
    pull = (1.0 - share) * part.single * high
    cosine = half / radius
    sine = shear / radius
    b1 = lean * part.slope[0]
    b2 = part.slope[1]
    return (
        share * s1 + pull * lean * ((1.0 + cosine) * b1 + sine * b2),
        share * s2 + pull * (sine * b1 + (1.0 - cosine) * b2),
    )


@wp.func
def membrane(part: Part, slack: float, growth: float, now: wp.array(dtype=Iterate), step: StepNumbers):
    """Force [N] and Hessian block [N/m] of a triangle on what moves with it: S = C G + 4 kd dG/dt, f = -A F S b."""
    f1, f2 = frame(part.corner, part.pose, now[0].x)
    b1 = part.slope[0]
    b2 = part.slope[1]
    strain = green_strain(f1, f2)
    s1 = wp.dot(part.first, strain)
    s2 = wp.dot(part.second, strain)
    if slack < 1.0:
        s1, s2 = slackened(part, s1, s2, strain, slack)
    m11 = part.firmness[0]
    m12 = part.firmness[1]
    m22 = part.firmness[2]
    if growth > 0.0:  # S += C e^2 growth along each axis; axes are those of the yarns, so C has no shear in these rows
        pull1 = growth * wp.max(strain[0], 0.0)
        pull2 = growth * wp.max(strain[1], 0.0)
        s1 += part.first[0] * pull1 * strain[0]
        s2 += part.second[1] * pull2 * strain[1]
        m11 += 2.0 * part.first[0] * pull1 * b1
        m22 += 2.0 * part.second[1] * pull2 * b2
    viscosity = part.viscosity
    if viscosity > 0.0:
        speed = step.rate * strain - now[0].triangle_past[part.triangle]
        across = 0.5 * speed[2]
        s1 += viscosity * (speed[0] * b1 + across * b2)
        s2 += viscosity * (across * b1 + speed[1] * b2)
        rate = viscosity * step.rate
        m11 += rate * (b1 * b1 + 0.5 * b2 * b2)
        m12 += 0.5 * rate * b1 * b2
        m22 += rate * (0.5 * b1 * b1 + b2 * b2)
    tension = wp.max(s1 * b1 + s2 * b2, 0.0)
    # The strains' gradients b1 f1, b2 f2, b1 f2 + b2 f1 lie in the plane of f1 and f2, so that two outer products are enough.
    block = wp.outer(f1, m11 * f1 + m12 * f2) + wp.outer(f2, m12 * f1 + m22 * f2)
    return -(s1 * f1 + s2 * f2), block + tension * wp.identity(n=3, dtype=float)


@wp.func
def bend(a: wp.vec3, b: wp.vec3, c: wp.vec3, d: wp.vec3):
    """Dihedral angle [rad] at edge c-d between the triangles of a and b, 0 when flat, and its gradients [rad/m].

    The gradients at the opposite vertices lie along the normals; rigid motion leaves the angle, which gives the others.
    """
    edge = d - c
    n1 = wp.cross(c - a, d - a)
    n2 = wp.cross(d - b, c - b)
    length_sq = wp.max(wp.dot(edge, edge), 1.0e-20)
    length = wp.sqrt(length_sq)
    n1_sq = wp.max(wp.dot(n1, n1), 1.0e-20)
    n2_sq = wp.max(wp.dot(n2, n2), 1.0e-20)
    angle = wp.atan2(wp.dot(wp.cross(n1, n2), edge) / length, wp.dot(n1, n2))
    ga = -(length / n1_sq) * n1
    gb = -(length / n2_sq) * n2
    ta = wp.dot(a - c, edge) / length_sq
    tb = wp.dot(b - c, edge) / length_sq
    gc = -(1.0 - ta) * ga - (1.0 - tb) * gb
    gd = -ta * ga - tb * gb
    return angle, ga, gb, gc, gd


@wp.func
def refresh_hinge(sheet: wp.array(dtype=Sheet), now: wp.array(dtype=Iterate), step: StepNumbers, h: int):
    """Linearise the moment k (angle - rest) + c d(angle)/dt of a hinge, on the branch nearest to its angle so far."""
    v = sheet[0].hinge[h]
    angle, ga, gb, gc, gd = bend(now[0].x[v[0]], now[0].x[v[1]], now[0].x[v[2]], now[0].x[v[3]])
    turn = 6.283185307179586
    angle += turn * wp.round((now[0].hinge_now[h] - angle) / turn)
    now[0].hinge_now[h] = angle
    moment = sheet[0].hinge_stiffness[h] * (angle - sheet[0].hinge_angle[h])
    firmness = sheet[0].hinge_stiffness[h]
    damping = sheet[0].hinge_damping[h]
    if damping > 0.0:
        moment += damping * (step.rate * angle - now[0].hinge_past[h])
        firmness += damping * step.rate
    root = wp.sqrt(firmness)
    now[0].hinge_moment[h] = wp.where(root > 0.0, moment / root, 0.0)
    now[0].hinge_slope[h, 0] = root * ga
    now[0].hinge_slope[h, 1] = root * gb
    now[0].hinge_slope[h, 2] = root * gc
    now[0].hinge_slope[h, 3] = root * gd


@wp.func
def hinge_slope(now: wp.array(dtype=Iterate), h: int, corners: int):
    """Change of a hinge's angle with one corner, or with those of the bits of -`corners` together [rad/m]."""
    if corners >= 0:
        return now[0].hinge_slope[h, corners]
    slope = wp.vec3(0.0)
    for corner in range(4):
        if (-corners >> corner) & 1 != 0:
            slope += now[0].hinge_slope[h, corner]
    return slope


@wp.func
def hinge(now: wp.array(dtype=Iterate), h: int, corners: int):
    """Force [N] and Gauss-Newton block [N/m] of hinge `h` on its corner or corners, see `hinge_slope`."""
    slope = hinge_slope(now, h, corners)
    return -now[0].hinge_moment[h] * slope, wp.outer(slope, slope)


@wp.func
def limit(now: wp.array(dtype=Iterate), e: int, at: wp.vec3, other: wp.vec3):
    """Force [N] and block [N/m] of the strain limit on the end `at` of edge `e`: f = -(lambda + k C) n, pulling only."""
    apart = at - other
    length = wp.max(wp.length(apart), 1.0e-12)
    excess = length - now[0].edge_free[e]
    pull = now[0].edge_force[e] + now[0].edge_stiffness[e] * excess
    force = wp.vec3(0.0)
    block = wp.mat33(0.0)
    if pull > 0.0:
        along = apart / length
        turning = pull / length  # the Hessian block is k n n^T + turning (1 - n n^T)
        force = -pull * along
        block = (now[0].edge_stiffness[e] - turning) * wp.outer(along, along) + turning * wp.identity(n=3, dtype=float)
    return force, block


@wp.func
def update_limit(sheet: wp.array(dtype=Sheet), now: wp.array(dtype=Iterate), step: StepNumbers, e: int):
    """Dual step of the strain limit: lambda += share k C, k += growth |C| while it pulls."""
    ends = sheet[0].edge[e]
    length = wp.length(now[0].x[ends[0]] - now[0].x[ends[1]])
    excess = length - now[0].edge_free[e]
    pull = wp.max(0.0, now[0].edge_force[e] + step.edge_share * now[0].edge_stiffness[e] * excess)
    now[0].edge_force[e] = pull
    if pull > 0.0:
        grown = now[0].edge_stiffness[e] + step.edge_growth * wp.abs(excess)
        now[0].edge_stiffness[e] = wp.min(step.edge_stiffness_max, grown)
