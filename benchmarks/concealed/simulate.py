"""From a world to the course of its markers: bring the cloth to rest, then integrate the motion.

Explicit, with two rates: the membrane and the table every inner step, all that is soft (bending, weight, effects) as an
impulse once per outer step of about 0.1 ms.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.concealed.bending import Plate, vertex_normals
from benchmarks.concealed.effects.effect import Effect
from benchmarks.concealed.grips import Poses, between, commanded, flat_poses, held_at
from benchmarks.concealed.membrane import Membrane
from benchmarks.concealed.motions.paths import rise
from benchmarks.concealed.sheet import Sheet, stable_step_s
from benchmarks.concealed.table import Contact
from benchmarks.concealed.world import State, World

OUTER_STEP_S = 1.2e-4
KEEP_EVERY_S = 1e-3
FOLLOW_S = 0.8
"""From the flat sheet to the first pose of the drives."""
REST_SPEED_M_S = 3e-5


@dataclass(frozen=True)
class Course:
    """What a simulation leaves: vertices at even times."""

    times_s: np.ndarray
    """(T,)"""
    x_m: np.ndarray
    """(T, 3, count)"""
    missing_n: np.ndarray
    """(T, 3, count) force on each vertex that the baseline would not have at the same state, mean over the interval."""
    grip_shift_m: np.ndarray
    """(T, K, 3) held vertices against where the commands would have them."""
    grip_load_n: np.ndarray
    """(T, D, 3)"""
    rest_speed_m_s: float
    """Fastest vertex at the start of the recording."""


class Simulation:
    """The solver of one world."""

    def __init__(self, world: World, effects: Sequence[Effect] = (), step_scale: float = 1.0):
        """`step_scale` below 1 refines the steps, for checks of convergence."""
        self.world, self.effects, self._step_scale = world, tuple(effects), step_scale
        grid, holds = world.sheet.grid, world.holds
        self._held = holds.vertices
        self._held_mask = np.arange(len(holds.offsets_m))[:, None] == holds.drive
        environment = world.environment
        level = None if environment.table_m is None else environment.table_m + world.cloth.thickness_m / 2
        self._contact = Contact(grid.count, level, environment.friction, world.baseline_environment.friction.mu_x)
        self._weight = environment.gravity_m_s2[:, None] * world.sheet.mass_kg
        self._slow = np.zeros((3, grid.count))
        self._normal = np.zeros((3, grid.count))

    def run(self, duration_s: float, missing: bool = True) -> Course:
        """Relax, then integrate for duration_s."""
        for effect in self.effects:
            effect.begin(self.world)
        state = self._flat()
        speed = self._relax(state)
        state.relaxing, state.time_s = False, 0.0
        return self._record(state, duration_s, speed, missing)

    def _flat(self) -> State:
        motion, grid = self.world.motion, self.world.sheet.grid
        flat = np.concatenate([grid.flat_uv_m, np.zeros((grid.count, 1))], axis=1)
        x = np.zeros((3, grid.count))
        placed = flat @ motion.flat_rotation.T + motion.flat_origin_m
        x[:, grid.inside] = placed[grid.inside].T
        return State(x, np.zeros_like(x), len(motion.blocks))

    def _relax(self, state: State, decay_per_s: float = 8.0, longest_s: float = 12.0) -> float:
        """Follow the drives from the flat sheet to their first pose; stop when nothing moves. Returns the fastest speed left.

        Grips turn first and come together then: the turn decides to which side the sheet bows. Damped by the mass and hardly
        by the stretch rate: long steps are stable, and the equilibrium is the same.
        """
        world = self.world
        damping = 5e-5
        step, number = steps_s(world.sheet, damping, self._step_scale)
        membrane, plate = Membrane(world.sheet, self._held, damping), Plate(world.sheet, damping)
        first = self._true_poses(np.zeros(1))
        flat = flat_poses(world.motion, world.holds)
        keep = float(np.exp(-decay_per_s * step / number))
        count, speed = 0, np.inf
        follow = np.arange(1, int(FOLLOW_S / step) + 2) * step
        turning, shifting = rise(follow, 0.0, 0.5 * FOLLOW_S), rise(follow, 0.4 * FOLLOW_S, 0.6 * FOLLOW_S)
        targets = held_at(between(flat, first, turning, shifting), world.holds)
        state.drive_rotation = first.rotation[0]
        while count * step < longest_s:
            self._advance(state, membrane, plate, targets[min(count, len(targets) - 1)], step, number, keep)
            count += 1
            if count % 500 == 0 and count * step > FOLLOW_S + 0.3:
                speed = float(np.abs(state.v).max())
                if speed < REST_SPEED_M_S:
                    break
        self._contact.take_impulses()
        return speed

    def _true_poses(self, times_s: np.ndarray) -> Poses:
        poses = commanded(self.world.motion, self.world.holds, times_s)
        for effect in self.effects:
            poses = effect.poses(times_s, poses)
        return poses

    def _record(self, state: State, duration_s: float, rest_speed: float, missing: bool) -> Course:
        world = self.world
        sheet, grid = world.sheet, world.sheet.grid
        step, number = steps_s(sheet, sheet.damping_s, self._step_scale)
        every = max(1, round(KEEP_EVERY_S / step))
        step = KEEP_EVERY_S / every
        kept = round(duration_s / KEEP_EVERY_S)
        membrane, plate = Membrane(sheet, self._held), Plate(sheet)
        times = np.arange(kept * every + 1) * step
        poses = self._true_poses(times)
        targets = held_at(poses, world.holds)
        told = held_at(commanded(world.motion, world.holds, times[::every]), world.holds)
        gap = Gap(world, self.effects) if missing else None
        x = np.empty((kept + 1, 3, grid.count))
        force = np.zeros((kept + 1, 3, grid.count) if missing else (0, 3, grid.count))
        shift, load = np.zeros(told.shape), np.zeros((kept + 1, state.drives, 3))
        x[0] = state.x
        before = state.v.copy()
        for frame in range(kept + 1):
            if frame:
                for n in range((frame - 1) * every, frame * every):
                    state.time_s, state.drive_rotation = times[n], poses.rotation[n]
                    self._advance(state, membrane, plate, targets[n + 1], step, number)
                x[frame] = state.x
            state.time_s = times[frame * every]
            shift[frame] = state.x[:, self._held].T - told[frame]
            load[frame] = state.grip_load_n
            if gap is not None:
                acceleration = (state.v - before) / KEEP_EVERY_S
                impulse, _ = self._contact.take_impulses()
                force[frame] = gap.force(state, acceleration) + impulse / KEEP_EVERY_S
                before = state.v.copy()
        if not np.isfinite(state.x).all():
            names = ", ".join(effect.name for effect in self.effects) or "no effect"
            raise FloatingPointError(
                f"{world.motion.name} with {names} became unstable: try a smaller amplitude or step"
            )
        return Course(np.arange(kept + 1) * KEEP_EVERY_S, x, force, shift, load, rest_speed)

    def _advance(self, state, membrane, plate, target, step: float, number: int, keep: float = 1.0) -> None:
        """One outer step in place; the held vertices go to target (K, 3)."""
        slow = self._slow
        slow[:] = self._weight
        plate.add(state.x, state.v, slow)
        carried = None
        for effect in self.effects:
            effect.advance(state, step)
            effect.add_force(state, slow)
            extra = effect.carried(state)
            if extra is not None:
                carried = self._along_normal(state, extra)
            moved = effect.grip_shift(state)
            if moved is not None:
                target = target + moved
        held = self._held
        state.v[:, held] = (target.T - state.x[:, held]) / step
        membrane.step(state.x, state.v, slow, step / number, number, self._contact, keep, carried)
        state.grip_load_n = self._held_mask @ membrane.force_n[:, held].T

    def _along_normal(self, state: State, extra_kg: np.ndarray) -> np.ndarray:
        """(4, count) normal, and 1/mass - 1/(mass + extra), which the compiled step takes off along it."""
        grid, sheet = self.world.sheet.grid, self.world.sheet
        vertex_normals(state.x, grid.rows, grid.columns, self._normal)
        mass = np.where(sheet.mass_kg > 0, sheet.mass_kg, 1.0)
        less = np.where(sheet.mass_kg > 0, 1 / mass - 1 / (mass + extra_kg), 0.0)
        less[self._held] = 0.0
        return np.concatenate([self._normal, less[None]])


class Gap:
    """The force that the baseline lacks, at a state of the true world."""

    def __init__(self, world: World, effects: Sequence[Effect]):
        """Builds the internal forces of both sheets."""
        self._world, self._effects = world, effects
        none = np.zeros(0, dtype=int)
        same = world.sheet is world.baseline_sheet
        sheets = () if same else (world.sheet, world.baseline_sheet)
        self._internal = [(Membrane(sheet, none), Plate(sheet)) for sheet in sheets]
        self._normal = np.zeros((3, world.sheet.grid.count))

    def force(self, state: State, acceleration_m_s2: np.ndarray) -> np.ndarray:
        """(3, count) N; `acceleration_m_s2` (3, count) for what differs in inertia."""
        world = self._world
        out = np.zeros_like(state.x)
        for sign, (membrane, plate) in zip((1, -1), self._internal):
            bent = np.zeros_like(out)
            plate.add(state.x, state.v, bent)
            out += sign * (membrane.forces(state.x, state.v) + bent)
        gravity, level_gravity = world.environment.gravity_m_s2, world.baseline_environment.gravity_m_s2
        more = world.sheet.mass_kg - world.baseline_sheet.mass_kg
        out += more * (gravity[:, None] - acceleration_m_s2)
        out += world.baseline_sheet.mass_kg * (gravity - level_gravity)[:, None]
        for effect in self._effects:
            effect.add_force(state, out)
            extra = effect.carried(state)
            if extra is not None:
                grid = world.sheet.grid
                vertex_normals(state.x, grid.rows, grid.columns, self._normal)
                out -= extra * (self._normal * acceleration_m_s2).sum(axis=0) * self._normal
        return out


def steps_s(sheet: Sheet, damping_s: float, scale: float = 1.0) -> tuple[float, int]:
    """Outer step [s] and how many inner steps it has; neither is longer than the plate allows, an inner one than the membrane does.

    The outer step may be 1.3 times `OUTER_STEP_S` where that spares an inner one; `scale` below 1 refines both.
    """
    plate = plate_step_s(sheet, damping_s)
    inner = min(stable_step_s(sheet, damping_s), plate, OUTER_STEP_S) * scale
    outer = min(OUTER_STEP_S * scale, plate)
    number = max(1, round(outer / inner))
    if number * inner > min(outer * 1.3, plate):
        number = max(1, int(outer / inner))
    return number * inner, number


def plate_step_s(sheet: Sheet, damping_s: float) -> float:
    """A safe step of the bending, from its highest frequency."""
    grid = sheet.grid
    area = np.where(grid.area_m2 > 0, grid.area_m2, 1)
    rigidity = max((sheet.bend_u_n_m3 / area).max(), (sheet.bend_v_n_m3 / area).max())
    density = (sheet.mass_kg / area)[grid.inside].min()
    omega = np.sqrt(rigidity / density) * (4 / grid.du_m**2 + 4 / grid.dv_m**2)
    zeta = damping_s * omega / 2
    return float(0.7 * 2 / omega * (np.sqrt(1 + zeta**2) - zeta))
