"""Curvature of a sheet at its vertices, and moments that answer it there, on a solver that bends at edges.

The angle at one edge depends on how the edge lies to the fold. The tensor that the edges around a vertex give together does not:
that curvature whose angles are nearest to theirs, each weighted by that part of its hinge's stiffness which is the vertex's.
Energy of the tensors, 1/2 kappa Q kappa with the Q of those weights, is then a part of the hinges' own, never more of it: a
curvature that counted for more than the hinges feel would be thrown beyond its rest by what is to keep it there.
"""

from dataclasses import dataclass, field

import numpy as np
import warp as wp

from sim1.cloth.avbd.elastic import bend
from sim1.cloth.avbd.iterate import Iterate
from sim1.cloth.avbd.sheet import Sheet
from sim1.cloth.avbd.threads import answers_of, spans_of

TOLD = 0.02  # of the stiffest curvature: one that the edges of a vertex resist less, they cannot tell
LATE = (
    0.6  # of a stiffness that acts as the step begins, to be had within the step; above a half, nothing is thrown back
)


@dataclass(frozen=True, kw_only=True)
class Curving:
    """What a solver keeps for physics that asks how the sheet is curved; tensors are (warp warp, weft weft, warp weft)."""

    rest: wp.array  # (h,) angle without any of that physics [rad]
    answer_of: wp.array  # (h,) angle of a hinge by a curvature [rad m]
    start: wp.array  # (h,) what an angle adds to the curvature at the edge's one end [1/m]
    end: wp.array  # (h,) and at the other
    split: wp.array  # (h,) shares of a hinge that its edge's ends have
    stiffness: wp.array  # (h,) without any of that physics [N m]
    time: wp.array  # (h,) damping over stiffness [s]
    firmness: np.ndarray  # (h,) stiffness of a hinge over the rigidity of its plate
    law: np.ndarray  # (v, 3, 3) Q: energy 1/2 kappa Q kappa of the hinges' shares [N m^3]
    ease: np.ndarray  # (v, 3, 3) its inverse, as far as the edges tell the curvature
    angle: wp.array  # (h,) as the step begins, beyond that of rest [rad]
    curvature: wp.array  # (v,) of those angles [1/m]
    damped_angle: wp.array  # (h,) with the damping time's part of its rate, as Kelvin-Voigt resists it [rad]
    damped_curvature: wp.array  # (v,) [1/m]
    kept: wp.array  # (v,) of the curvature, what folds have kept [1/m]
    none: wp.array  # (h,) 0
    extra: dict[str, wp.array] = field(default_factory=dict)  # (h,) what physics put into the hinges' stiffness [N m]
    turns: dict[str, wp.array] = field(default_factory=dict)  # (v,) matrices that physics turn curvatures with

    @classmethod
    def of(cls, sheet: Sheet, corners_m: np.ndarray, warp: tuple[float, float, float]) -> "Curving":
        """Of a sheet whose hinges have the stiffness of a plate, `sim1.cloth.model.hinge_stiffness`, and corners (h, 4, 3)."""
        ends, count = sheet.hinge.numpy()[:, 2:], len(sheet.mass)
        answers = answers_of(corners_m, warp)
        length, width = spans_of(corners_m)
        stiffness = sheet.hinge_stiffness.numpy().astype(float)
        time = np.divide(sheet.hinge_damping.numpy(), stiffness, out=np.zeros(len(ends)), where=stiffness > 0.0)
        weight = stiffness if stiffness.any() else length / width  # a sheet that bends freely is curved as well
        split = _split(ends, weight, answers, count)
        fit = _fit(ends, split * weight[:, None], answers, count)
        ease = np.linalg.pinv(fit, rcond=TOLD, hermitian=True)
        start, end = (
            wp.array(np.einsum("hij,hj,h->hi", ease[v], answers, share * weight), dtype=wp.vec3)
            for v, share in zip(ends.T, split.T, strict=True)
        )
        return cls(
            rest=wp.clone(sheet.hinge_angle),
            answer_of=wp.array(answers, dtype=wp.vec3),
            start=start,
            end=end,
            split=wp.array(split, dtype=wp.vec2),
            stiffness=wp.clone(sheet.hinge_stiffness),
            time=wp.array(time.astype(np.float32), dtype=float),
            firmness=length / width,
            law=fit * stiffness.any(),
            ease=ease,
            angle=wp.zeros(len(ends), dtype=float),
            curvature=wp.zeros(count, dtype=wp.vec3),
            damped_angle=wp.zeros(len(ends), dtype=float),
            damped_curvature=wp.zeros(count, dtype=wp.vec3),
            kept=wp.zeros(count, dtype=wp.vec3),
            none=wp.zeros(len(ends), dtype=float),
        )

    def stiffen(self, sheet: Sheet, name: str, added_n_m: np.ndarray) -> None:
        """Add to the stiffness (h,) of hinges, which follows the fold within a step; `answer` takes it off as the step begins."""
        added = added_n_m.astype(np.float32)
        sheet.hinge_stiffness.assign(sheet.hinge_stiffness.numpy() + added)
        self.extra[name] = wp.array(added, dtype=float)

    def look(self, sheet: Sheet, now: Iterate, dt: float) -> None:
        """Take the curvature as the step begins, and angles at rest back to what they are without any of that physics."""
        count, device = len(self.rest), self.rest.device
        wp.copy(sheet.hinge_angle, self.rest)
        wp.launch(
            bent_so_far,
            dim=count,
            inputs=[sheet, now, self.rest, self.time, dt, self.angle, self.damped_angle],
            device=device,
        )
        for angle, curvature in ((self.angle, self.curvature), (self.damped_angle, self.damped_curvature)):
            curvature.zero_()
            wp.launch(gather, dim=count, inputs=[sheet, angle, self.start, self.end, curvature], device=device)

    def answer(self, sheet: Sheet, resisted: wp.array, scale: wp.array, extra: wp.array, angle: wp.array) -> None:
        """Let edges resist curvatures (v,) [1/m] as hinges of stiffness `scale` (h,) [N m] would; all as the step begins.

        What `extra` (h,) [N m], which follows the fold within the step, makes of an `angle` (h,) [rad] is taken off. Angles at
        rest are shifted for it until the next `look`.
        """
        wp.launch(
            bend_back,
            dim=len(self.rest),
            inputs=[sheet, self.answer_of, self.split, resisted, scale, extra, angle],
            device=self.rest.device,
        )

    def late(self, sheet: Sheet, change: np.ndarray) -> np.ndarray:
        """Stiffness (h,) [N m] that hinges need within a step where a change (v, 3, 3) of Q acts as the step begins.

        With T the whole stiffness and S that within the step, a long step leaves 1 - T / S of the way to rest: less than all of
        it, on either side, where S is above T / 2. Gershgorin's rows of T bound it in every direction by a number per hinge.
        """
        rows = np.zeros(len(self.firmness))
        ends = sheet.hinge.numpy()[:, 2:].ravel()
        own = (self.split.numpy() * self.stiffness.numpy()[:, None]).astype(float).ravel()
        shares = np.stack([self.start.numpy(), self.end.numpy()], axis=1).astype(float).reshape(-1, 3)
        order = np.argsort(ends, kind="stable")
        for around in np.split(order, np.cumsum(np.bincount(ends, minlength=len(change)))[:-1]):
            if len(around):
                moments = np.diag(own[around]) + shares[around] @ change[ends[around[0]]] @ shares[around].T
                rows[around // 2] += np.abs(moments).sum(axis=1)  # no edge is twice around a vertex
        return LATE * rows


def _fit(ends: np.ndarray, weight: np.ndarray, answers: np.ndarray, count: int) -> np.ndarray:
    """Normal equations (v, 3, 3) of the curvature at `count` vertices; weight (h, 2) of an edge at its ends (h, 2)."""
    fit = np.zeros((count, 3, 3))
    np.add.at(fit, ends, weight[:, :, None, None] * (answers[:, :, None] * answers[:, None, :])[:, None])
    return fit


def _split(ends: np.ndarray, weight: np.ndarray, answers: np.ndarray, count: int) -> np.ndarray:
    """Shares (h, 2) of hinges that the ends of their edges have: halves, or all where the other end's edges are too few.

    At a rim two edges see a curvature along it as nine tenths of what it is; the vertex inside sees it whole.
    """
    halves = np.full(ends.shape, 0.5)
    size = np.linalg.eigvalsh(_fit(ends, halves * weight[:, None], answers, count))
    tells = (size[:, 0] > TOLD * size[:, 2])[ends]
    return np.where(tells == tells[:, ::-1], halves, tells)


@wp.kernel(enable_backward=False)
def bent_so_far(
    sheet: Sheet,
    now: Iterate,
    rest: wp.array(dtype=float),
    time: wp.array(dtype=float),
    dt: float,
    angle: wp.array(dtype=float),
    damped_angle: wp.array(dtype=float),
):
    """Angles as the step begins, and those with what damping makes of their rate in the step before."""
    h = wp.tid()
    at = now.hinge_now[h]
    angle[h] = at - rest[h]
    damped_angle[h] = at - rest[h]
    if time[h] > 0.0:
        v = sheet.hinge[h]
        older, _a, _b, _c, _d = bend(now.before[v[0]], now.before[v[1]], now.before[v[2]], now.before[v[3]])
        turn = 6.283185307179586
        older += turn * wp.round((at - older) / turn)
        damped_angle[h] = at - rest[h] + time[h] * (at - older) / dt


@wp.kernel(enable_backward=False)
def gather(
    sheet: Sheet,
    angle: wp.array(dtype=float),
    start: wp.array(dtype=wp.vec3),
    end: wp.array(dtype=wp.vec3),
    curvature: wp.array(dtype=wp.vec3),
):
    """Add each edge to the curvature of its ends."""
    h = wp.tid()
    ends = sheet.hinge[h]
    wp.atomic_add(curvature, ends[2], angle[h] * start[h])
    wp.atomic_add(curvature, ends[3], angle[h] * end[h])


@wp.kernel(enable_backward=False)
def bend_back(
    sheet: Sheet,
    answer_of: wp.array(dtype=wp.vec3),
    split: wp.array(dtype=wp.vec2),
    resisted: wp.array(dtype=wp.vec3),
    scale: wp.array(dtype=float),
    extra: wp.array(dtype=float),
    angle: wp.array(dtype=float),
):
    """Shift an edge's angle at rest by what the curvatures at its ends ask for."""
    h = wp.tid()
    firmness = sheet.hinge_stiffness[h]
    if firmness > 0.0:
        ends = sheet.hinge[h]
        both = split[h][0] * resisted[ends[2]] + split[h][1] * resisted[ends[3]]
        turn = scale[h] * wp.dot(answer_of[h], both) - extra[h] * angle[h]
        sheet.hinge_angle[h] = sheet.hinge_angle[h] - turn / firmness
