"""Curvature of a sheet at its vertices, and moments that answer it there, on a solver that bends at edges.

The angle at one edge depends on how the edge lies to the fold. The tensor that the edges around a vertex give together does not:
that curvature whose quadratic has angles nearest to theirs, by least squares. A moment tensor M per width acts back on the
edges by virtual work: area M dkappa = sum of moments dangle.
"""

from dataclasses import dataclass, field

import numpy as np
import warp as wp

from sim1.cloth.avbd.iterate import Iterate
from sim1.cloth.avbd.sheet import Sheet
from sim1.cloth.avbd.threads import answers_of, spans_of


@dataclass(frozen=True, kw_only=True)
class Curving:
    """What a solver keeps for physics that asks how the sheet is curved; tensors are (warp warp, weft weft, warp weft)."""

    rest: wp.array  # (h,) angle without any of that physics [rad]
    start: wp.array  # (h,) what an angle adds to the curvature at the edge's one end [1/m]
    end: wp.array  # (h,) and at the other
    firmness: np.ndarray  # (h,) stiffness of a hinge over the rigidity of its plate
    rigidity: wp.array  # (h,) of the plate [N m]
    area: wp.array  # (v,) [m^2]
    curvature: wp.array  # (v,) as the step begins, beyond that of rest [1/m]
    one: wp.array  # (h,)
    extra: dict[str, wp.array] = field(default_factory=dict)  # (h,) what physics put into the hinges' stiffness [N m]

    @classmethod
    def of(cls, sheet: Sheet, rest_m: np.ndarray) -> "Curving":
        """Of a sheet whose hinges have the stiffness of a plate, see `sim1.cloth.model.hinge_stiffness`."""
        hinge = sheet.hinge.numpy()
        length, width = spans_of(hinge, rest_m)
        area = np.zeros(len(rest_m))
        np.add.at(area, sheet.triangle.numpy(), sheet.triangle_area.numpy()[:, None] / 3.0)
        shares = _shares(hinge[:, 2:], answers_of(hinge, rest_m), len(rest_m)).astype(np.float32)
        return cls(
            rest=wp.clone(sheet.hinge_angle),
            start=wp.array(np.ascontiguousarray(shares[:, 0]), dtype=wp.vec3),
            end=wp.array(np.ascontiguousarray(shares[:, 1]), dtype=wp.vec3),
            firmness=length / width,
            rigidity=wp.array((sheet.hinge_stiffness.numpy() * width / length).astype(np.float32), dtype=float),
            area=wp.array(area.astype(np.float32), dtype=float),
            curvature=wp.zeros(len(rest_m), dtype=wp.vec3),
            one=wp.full(len(length), 1.0, dtype=float),
        )

    def stiffen(self, sheet: Sheet, name: str, plate_n_m: np.ndarray | float) -> None:
        """Add a rigidity (h,) to hinges, which follows the fold within a step; `answer` takes it off for the step's beginning."""
        added = (plate_n_m * self.firmness).astype(np.float32)
        sheet.hinge_stiffness.assign(sheet.hinge_stiffness.numpy() + added)
        self.extra[name] = wp.array(added, dtype=float)

    def look(self, sheet: Sheet, now: Iterate) -> None:
        """Take the curvature as the step begins, and angles at rest back to what they are without any of that physics."""
        self.curvature.zero_()
        wp.copy(sheet.hinge_angle, self.rest)
        wp.launch(
            gather,
            dim=len(self.rest),
            inputs=[sheet, now, self.rest, self.start, self.end, self.curvature],
            device=self.rest.device,
        )

    def answer(self, sheet: Sheet, now: Iterate, name: str, moment: wp.array, scale: wp.array) -> None:
        """Let moments (v,) as the step begins, times `scale` (h,), act on the edges; their product is in N, per width.

        Angles at rest are shifted for it until the next `look`.
        """
        wp.launch(
            bend_back,
            dim=len(self.rest),
            inputs=[sheet, now, self.rest, self.start, self.end, self.area, moment, scale, self.extra[name]],
            device=self.rest.device,
        )


def _shares(ends: np.ndarray, answers: np.ndarray, vertex_count: int) -> np.ndarray:
    """What the angle of each edge (h, 2) adds to the curvature at its ends, (h, 2, 3) [1/m]; least squares at each vertex."""
    edges_of: list[list[tuple[int, int]]] = [[] for _ in range(vertex_count)]
    for edge, pair in enumerate(ends):
        for end, vertex in enumerate(pair):
            edges_of[vertex].append((edge, end))
    shares = np.zeros((len(ends), 2, 3))
    for around in edges_of:
        if around:
            edge, end = np.array(around).T
            shares[edge, end] = np.linalg.pinv(answers[edge], rcond=0.1).T  # what too few edges cannot tell is nothing
    return shares


@wp.kernel(enable_backward=False)
def gather(
    sheet: Sheet,
    now: Iterate,
    rest: wp.array(dtype=float),
    start: wp.array(dtype=wp.vec3),
    end: wp.array(dtype=wp.vec3),
    curvature: wp.array(dtype=wp.vec3),
):
    """Add each edge to the curvature of its ends."""
    h = wp.tid()
    ends = sheet.hinge[h]
    bent = now.hinge_now[h] - rest[h]
    wp.atomic_add(curvature, ends[2], bent * start[h])
    wp.atomic_add(curvature, ends[3], bent * end[h])


@wp.func
def work(moment: wp.vec3, curvature: wp.vec3):
    """Of a moment tensor along a curvature, both as (warp warp, weft weft, warp weft)."""
    return moment[0] * curvature[0] + moment[1] * curvature[1] + 2.0 * moment[2] * curvature[2]


@wp.kernel(enable_backward=False)
def bend_back(
    sheet: Sheet,
    now: Iterate,
    rest: wp.array(dtype=float),
    start: wp.array(dtype=wp.vec3),
    end: wp.array(dtype=wp.vec3),
    area: wp.array(dtype=float),
    moment: wp.array(dtype=wp.vec3),
    scale: wp.array(dtype=float),
    extra: wp.array(dtype=float),
):
    """Shift an edge's angle at rest by what the moments of its ends ask for."""
    h = wp.tid()
    firmness = sheet.hinge_stiffness[h]
    if firmness > 0.0:
        ends = sheet.hinge[h]
        turn = area[ends[2]] * work(moment[ends[2]], start[h]) + area[ends[3]] * work(moment[ends[3]], end[h])
        turn = scale[h] * turn - extra[h] * (now.hinge_now[h] - rest[h])
        sheet.hinge_angle[h] = sheet.hinge_angle[h] - turn / firmness
