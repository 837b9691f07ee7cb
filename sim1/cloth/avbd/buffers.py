"""Empty arrays of the solver's structs."""

from dataclasses import dataclass
from typing import Any

import warp as wp

from sim1.cloth.avbd.blocks import Blocks
from sim1.cloth.avbd.iterate import Iterate
from sim1.cloth.avbd.parameters import AVBDConfig
from sim1.cloth.avbd.sheet import Sheet
from sim1.cloth.avbd.touch import Guard, Touches


@dataclass(frozen=True, kw_only=True)
class Arguments:
    """The solver's structs as kernels take them."""

    sheet: wp.array
    blocks: wp.array
    now: wp.array
    solids: wp.array
    layers: wp.array
    guard: wp.array

    @classmethod
    def of(
        cls, sheet: Sheet, blocks: Blocks, now: Iterate, solids: Touches, layers: Touches, guard: Guard
    ) -> "Arguments":
        """Packed."""
        return cls(
            sheet=packed(sheet, Sheet),
            blocks=packed(blocks, Blocks),
            now=packed(now, Iterate),
            solids=packed(solids, Touches),
            layers=packed(layers, Touches),
            guard=packed(guard, Guard),
        )


def packed(struct: Any, kind: Any) -> wp.array:
    """A struct as an array of one, which is how functions take it: a struct itself would be copied whole at every call."""
    return wp.array([struct], dtype=kind)


def new_iterate(vertex_count: int, sheet: Sheet, config: AVBDConfig) -> Iterate:
    """Unknowns without a history: the positions are not a number, so that every vertex counts as newly put."""
    now = Iterate()
    now.x = wp.full(vertex_count, wp.vec3(float("nan")), dtype=wp.vec3)
    for name in ("target", "start", "before", "before_speed", "expected", "wish", "force"):
        setattr(now, name, wp.zeros(vertex_count, dtype=wp.vec3))
    now.fresh = wp.zeros(vertex_count, dtype=wp.int32)
    now.slope = wp.zeros(vertex_count, dtype=wp.mat33)
    now.triangle_past = wp.zeros(len(sheet.triangle), dtype=wp.vec3)
    now.hinge_now = wp.clone(sheet.hinge_angle)
    now.hinge_moment = wp.zeros(len(sheet.hinge), dtype=float)
    now.hinge_past = wp.zeros(len(sheet.hinge), dtype=float)
    now.hinge_slope = wp.zeros((len(sheet.hinge), 4), dtype=wp.vec3)
    now.edge_force = wp.zeros(len(sheet.edge), dtype=float)
    now.edge_stiffness = wp.full(len(sheet.edge), config.strain_stiffness_n_m, dtype=float)
    now.edge_free = wp.zeros(len(sheet.edge), dtype=float)
    now.broken = wp.zeros(3, dtype=wp.int32)
    return now


def new_touches(vertex_count: int, capacity: int) -> Touches:
    """Room for `capacity` contact records, none in use."""
    touches = Touches()
    size = max(capacity, 1)
    touches.count = wp.zeros(1, dtype=wp.int32)
    touches.capacity = capacity
    touches.vertex = wp.zeros(size, dtype=wp.vec4i)
    for name, dtype in (("weight", wp.vec4), ("normal", wp.vec3), ("anchor", wp.vec3), ("parting", wp.vec3)):
        setattr(touches, name, wp.zeros(size, dtype=dtype))
    for name in ("offset", "stiffness", "damping", "friction", "skew", "least"):
        setattr(touches, name, wp.zeros(size, dtype=float))
    for name in ("shape", "near", "first_side"):
        setattr(touches, name, wp.zeros(size, dtype=wp.int32))
    touches.head = wp.full(vertex_count, -1, dtype=wp.int32)
    touches.after = wp.full(4 * size, -1, dtype=wp.int32)
    touches.wide_head = wp.full(vertex_count, -1, dtype=wp.int32)
    touches.wide_after = wp.full(4 * size, -1, dtype=wp.int32)
    return touches


def new_guard(model: Any, config: AVBDConfig) -> Guard:
    """Nothing seen yet; reach 0 where the cloth does not collide with itself."""
    guard = Guard()
    guard.seen = wp.clone(model.particle_q)
    guard.room = wp.zeros(model.particle_count, dtype=float)
    guard.cut = wp.zeros(1, dtype=wp.int32)
    if config.self_contact is not None:
        guard.reach, guard.share = config.self_contact.search_m, config.self_contact.share
    return guard
