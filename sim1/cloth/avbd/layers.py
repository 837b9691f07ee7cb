"""Self-contact: which vertices and triangles, edges and edges are near each other, and the planes that part them."""

import warp as wp

from sim1.cloth.avbd.iterate import Iterate
from sim1.cloth.avbd.sheet import Sheet
from sim1.cloth.avbd.touch import Guard, Touches, link, point_of

NEAR = wp.constant(1.3)  # radii: pairs further apart than this at the start of a step do not push in it
LEAST = wp.constant(0.1)  # of the distance found by a search that always stays


@wp.struct
class LayerNumbers:
    """Distances and material of the self-contact."""

    radius: float  # kept between two layers [m]
    rest_exclusion: float  # pairs nearer than this at rest are neighbours [m]
    stiffness: float  # [N/m]
    damping: float  # [N s/m]
    friction: float


@wp.func
def triangle_weights(p: wp.vec3, a: wp.vec3, b: wp.vec3, c: wp.vec3):
    """Barycentric weights of the point of triangle abc nearest to p (Ericson 2004, section 5.1.5)."""
    ab = b - a
    ac = c - a
    ap = p - a
    d1 = wp.dot(ab, ap)
    d2 = wp.dot(ac, ap)
    if d1 <= 0.0 and d2 <= 0.0:
        return wp.vec3(1.0, 0.0, 0.0)
    bp = p - b
    d3 = wp.dot(ab, bp)
    d4 = wp.dot(ac, bp)
    if d3 >= 0.0 and d4 <= d3:
        return wp.vec3(0.0, 1.0, 0.0)
    vc = d1 * d4 - d3 * d2
    if vc <= 0.0 and d1 >= 0.0 and d3 <= 0.0:
        t = d1 / wp.max(d1 - d3, 1.0e-20)
        return wp.vec3(1.0 - t, t, 0.0)
    cp = p - c
    d5 = wp.dot(ab, cp)
    d6 = wp.dot(ac, cp)
    if d6 >= 0.0 and d5 <= d6:
        return wp.vec3(0.0, 0.0, 1.0)
    vb = d5 * d2 - d1 * d6
    if vb <= 0.0 and d2 >= 0.0 and d6 <= 0.0:
        t = d2 / wp.max(d2 - d6, 1.0e-20)
        return wp.vec3(1.0 - t, 0.0, t)
    va = d3 * d6 - d5 * d4
    if va <= 0.0 and d4 - d3 >= 0.0 and d5 - d6 >= 0.0:
        t = (d4 - d3) / wp.max((d4 - d3) + (d5 - d6), 1.0e-20)
        return wp.vec3(0.0, 1.0 - t, t)
    scale = 1.0 / wp.max(va + vb + vc, 1.0e-20)
    return wp.vec3(va * scale, vb * scale, vc * scale)


@wp.func
def segment_weights(p1: wp.vec3, q1: wp.vec3, p2: wp.vec3, q2: wp.vec3):
    """Shares (s, t) along segments p1-q1 and p2-q2 of their nearest points (Ericson 2004, section 5.1.9)."""
    d1 = q1 - p1
    d2 = q2 - p2
    r = p1 - p2
    a = wp.max(wp.dot(d1, d1), 1.0e-20)
    e = wp.max(wp.dot(d2, d2), 1.0e-20)
    b = wp.dot(d1, d2)
    c = wp.dot(d1, r)
    f = wp.dot(d2, r)
    parting = a * e - b * b
    s = float(0.0)
    if parting > 1.0e-7 * a * e:
        s = wp.clamp((b * f - c * e) / parting, 0.0, 1.0)
    t = (b * s + f) / e
    if t < 0.0:
        t = 0.0
        s = wp.clamp(-c / a, 0.0, 1.0)
    elif t > 1.0:
        t = 1.0
        s = wp.clamp((b - c) / a, 0.0, 1.0)
    return wp.vec2(s, t)


@wp.func
def weights_of(vertex: wp.vec4i, first_side: int, x: wp.array(dtype=wp.vec3)):
    """Signed weights of the nearest points: first side minus second side."""
    if first_side == 1:
        w = triangle_weights(x[vertex[0]], x[vertex[1]], x[vertex[2]], x[vertex[3]])
        return wp.vec4(1.0, -w[0], -w[1], -w[2])
    st = segment_weights(x[vertex[0]], x[vertex[1]], x[vertex[2]], x[vertex[3]])
    return wp.vec4(1.0 - st[0], st[0], -(1.0 - st[1]), -st[1])


@wp.func
def refresh_layer(layers: wp.array(dtype=Touches), now: wp.array(dtype=Iterate), sweep: int, record: int):
    """Nearest points and direction of a pair at the present positions; after the first sweep only of those that are near."""
    if sweep == 0 or layers[0].near[record] != 0:
        vertex = layers[0].vertex[record]
        weight = weights_of(vertex, layers[0].first_side[record], now[0].x)
        apart = point_of(vertex, weight, now[0].x)
        distance = wp.length(apart)
        if sweep == 0:
            layers[0].near[record] = wp.where(distance < NEAR * layers[0].offset[record], 1, 0)
            if layers[0].near[record] != 0:
                link(vertex, record, layers[0].head, layers[0].after)
        layers[0].weight[record] = weight
        if distance > 1.0e-6:
            layers[0].normal[record] = apart / distance
        layers[0].anchor[record] = point_of(vertex, weight, now[0].start)


@wp.func
def swept_low(now: wp.array(dtype=Iterate), v: int, dt: float):
    """Lower corner of the box around a vertex on its way through the step."""
    return wp.min(now[0].start[v], now[0].start[v] + dt * now[0].expected[v])


@wp.func
def swept_high(now: wp.array(dtype=Iterate), v: int, dt: float):
    """Upper corner of the box around a vertex on its way through the step."""
    return wp.max(now[0].start[v], now[0].start[v] + dt * now[0].expected[v])


@wp.func
def consider(
    vertex: wp.vec4i,
    first_side: int,
    rest: wp.array(dtype=wp.vec3),
    now: wp.array(dtype=Iterate),
    numbers: LayerNumbers,
    guard: wp.array(dtype=Guard),
    layers: wp.array(dtype=Touches),
    dt: float,
):
    """Make a record of a pair that is near now, or will be at its present speed, and was not at rest."""
    weight = weights_of(vertex, first_side, now[0].start)
    apart = point_of(vertex, weight, now[0].start)
    distance = wp.length(apart)
    closing = float(0.0)
    for i in range(first_side):
        for j in range(first_side, 4):
            apart_then = now[0].expected[vertex[i]] - now[0].expected[vertex[j]]
            closing = wp.max(closing, dt * wp.length(apart_then))
    if distance < guard[0].reach + closing and distance > 1.0e-9:
        still = point_of(vertex, weights_of(vertex, first_side, rest), rest)
        if wp.length(still) > numbers.rest_exclusion:
            record = wp.atomic_add(layers[0].count, 0, 1)
            if record < layers[0].capacity:
                normal = apart / distance
                layers[0].vertex[record] = vertex
                layers[0].weight[record] = weight
                layers[0].normal[record] = normal
                layers[0].offset[record] = numbers.radius
                layers[0].anchor[record] = point_of(vertex, weight, now[0].start)
                layers[0].stiffness[record] = numbers.stiffness
                layers[0].damping[record] = numbers.damping
                layers[0].friction[record] = numbers.friction
                layers[0].shape[record] = -1
                layers[0].first_side[record] = first_side
                layers[0].near[record] = 1
                layers[0].parting[record] = normal
                layers[0].least[record] = LEAST * distance
                for slot in range(4):
                    wp.atomic_min(guard[0].room, vertex[slot], 0.5 * (1.0 - LEAST) * distance)
                link(vertex, record, layers[0].wide_head, layers[0].wide_after)


@wp.kernel(enable_backward=False)
def decide_search(now: wp.array(dtype=Iterate), guard: wp.array(dtype=Guard), due: wp.array(dtype=wp.int32)):
    """A new search is due when a move was cut, or would be in this step."""
    v = wp.tid()
    if guard[0].cut[0] > 0 or wp.length(now[0].target[v] - guard[0].seen[v]) > guard[0].share * guard[0].reach:
        due[0] = 1


@wp.kernel(enable_backward=False)
def begin_search(
    now: wp.array(dtype=Iterate),
    due: wp.array(dtype=wp.int32),
    guard: wp.array(dtype=Guard),
    layers: wp.array(dtype=Touches),
    triangle: wp.array(dtype=wp.vec3i),
    edge: wp.array(dtype=wp.vec2i),
    triangle_low: wp.array(dtype=wp.vec3),
    triangle_high: wp.array(dtype=wp.vec3),
    edge_low: wp.array(dtype=wp.vec3),
    edge_high: wp.array(dtype=wp.vec3),
    dt: float,
):
    """Empty the lists and take the boxes of triangles and edges where a search is due."""
    i = wp.tid()
    if due[0] != 0:
        if i == 0:
            layers[0].count[0] = 0
            guard[0].cut[0] = 0
        if i < layers[0].head.shape[0]:
            guard[0].seen[i] = now[0].start[i] + dt * now[0].expected[i]
            guard[0].room[i] = guard[0].share * guard[0].reach
            layers[0].wide_head[i] = -1
        if i < triangle.shape[0]:
            t = triangle[i]
            triangle_low[i] = wp.min(
                swept_low(now, t[0], dt), wp.min(swept_low(now, t[1], dt), swept_low(now, t[2], dt))
            )
            triangle_high[i] = wp.max(
                swept_high(now, t[0], dt), wp.max(swept_high(now, t[1], dt), swept_high(now, t[2], dt))
            )
        if i < edge.shape[0]:
            ends = edge[i]
            edge_low[i] = wp.min(swept_low(now, ends[0], dt), swept_low(now, ends[1], dt))
            edge_high[i] = wp.max(swept_high(now, ends[0], dt), swept_high(now, ends[1], dt))


@wp.kernel(enable_backward=False)
def find_vertex_triangle(
    due: wp.array(dtype=wp.int32),
    tree: wp.uint64,
    world: wp.array(dtype=wp.int32),
    sheet: wp.array(dtype=Sheet),
    rest: wp.array(dtype=wp.vec3),
    now: wp.array(dtype=Iterate),
    numbers: LayerNumbers,
    guard: wp.array(dtype=Guard),
    layers: wp.array(dtype=Touches),
    dt: float,
):
    """Triangles near a vertex that do not hold it."""
    v = wp.tid()
    if due[0] != 0:
        around = wp.vec3(guard[0].reach)
        root = wp.bvh_get_group_root(tree, world[v])
        a = now[0].start[v]
        b = a + dt * now[0].expected[v]
        query = wp.bvh_query_aabb(tree, wp.min(a, b) - around, wp.max(a, b) + around, root)
        t = wp.int32(0)
        while wp.bvh_query_next(query, t):
            tri = sheet[0].triangle[t]
            if tri[0] != v and tri[1] != v and tri[2] != v:
                consider(wp.vec4i(v, tri[0], tri[1], tri[2]), 1, rest, now, numbers, guard, layers, dt)


@wp.kernel(enable_backward=False)
def find_edge_edge(
    due: wp.array(dtype=wp.int32),
    tree: wp.uint64,
    world: wp.array(dtype=wp.int32),
    sheet: wp.array(dtype=Sheet),
    rest: wp.array(dtype=wp.vec3),
    now: wp.array(dtype=Iterate),
    numbers: LayerNumbers,
    guard: wp.array(dtype=Guard),
    layers: wp.array(dtype=Touches),
    dt: float,
):
    """Edges near an edge that share no end with it, each pair once."""
    e = wp.tid()
    if due[0] != 0:
        ends = sheet[0].edge[e]
        around = wp.vec3(guard[0].reach)
        low = wp.min(swept_low(now, ends[0], dt), swept_low(now, ends[1], dt))
        high = wp.max(swept_high(now, ends[0], dt), swept_high(now, ends[1], dt))
        root = wp.bvh_get_group_root(tree, world[ends[0]])
        query = wp.bvh_query_aabb(tree, low - around, high + around, root)
        o = wp.int32(0)
        while wp.bvh_query_next(query, o):
            if o > e:
                other = sheet[0].edge[o]
                if other[0] != ends[0] and other[0] != ends[1] and other[1] != ends[0] and other[1] != ends[1]:
                    consider(wp.vec4i(ends[0], ends[1], other[0], other[1]), 2, rest, now, numbers, guard, layers, dt)
