"""One case from drawing to files: bundle, held-out bundle, answers."""

import json
import os
import shutil
import time
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

import numpy as np

from benchmarks.concealed.bundle import Take, camera_stamps, drive_stamps, write_bundle
from benchmarks.concealed.case import STRENGTHS, Case, Plan, plans
from benchmarks.concealed.effects.effect import Effect
from benchmarks.concealed.effects.library import LIBRARY
from benchmarks.concealed.film import Stage, Track, film, grid_for
from benchmarks.concealed.markers import camera_noise, draw_markers, drop_outs
from benchmarks.concealed.mesh import draw_mesh
from benchmarks.concealed.motions.motion import DURATION_S
from benchmarks.concealed.setting import REFINE, draw_friction_prior, draw_prior
from benchmarks.concealed.specimen import Specimen, taken
from benchmarks.concealed.strength import Films, moves_m, reported, rms, tuned

HELD_OUT_KEEPS_S = 0.5
TRUTH_HZ = 60.0


def make(case: Case, bundle: Path, answers: Path, held_out: Path | None = None) -> dict:
    """Film one case. Writes `bundle`, `answers` (and a .npz beside it) and, where asked, the bundle of held-out motions.

    All files appear at once or not at all, and are the same whenever they are made. Returns the answers, and how long it took.
    """
    started = time.perf_counter()
    one = taken(case, lambda like: _specimen(like, with_held_out=held_out is not None))
    case, stage, plan_list, without, effects = one.case, one.stage, one.plans, one.without, one.effects
    setting, tracks = stage.setting, dict(one.tracks)
    moved = [effect for effect in effects if not effect.measures_only]
    for plan in plan_list:
        if plan.name not in tracks:
            tracks[plan.name] = film(stage, plan, moved) if moved else without[plan.name]
    takes = {plan.name: _take(case, stage, plan, effects, tracks[plan.name]) for plan in plan_list}

    prior, friction = draw_prior(setting, case.stream("prior")), draw_friction_prior(setting, case.stream("friction"))
    for folder, wanted in ((bundle, False), (held_out, True)):
        if folder is not None:
            chosen = [takes[plan.name] for plan in plan_list if plan.held_out == wanted]
            until = HELD_OUT_KEEPS_S if wanted else np.inf
            _replace(
                folder, lambda place, c=chosen, u=until: write_bundle(place, stage, one.mesh, c, prior, friction, u)
            )
    document = _document(one, tracks)
    arrays = _arrays(plan_list, effects, without, tracks, takes)
    _replace(answers.with_suffix(".npz"), lambda place: _save(place, arrays))
    _replace(answers, lambda place: place.write_text(json.dumps(document, indent=1) + "\n"))
    return document | {"made_in_s": round(time.perf_counter() - started, 1)}


def _specimen(case: Case, *, with_held_out: bool) -> Specimen:
    setting = case.setting()
    grid = grid_for(setting)
    stage = Stage(setting, grid, draw_markers(setting, grid, case.stream("markers")), _offsets(case))
    every = plans(case, setting)
    mesh = draw_mesh(setting, [plan.motion for plan in every], case.stream("mesh"))
    wanted = [plan for plan in every if with_held_out or not plan.held_out]
    without: Films = {plan.name: film(stage, plan, []) for plan in wanted}
    effects, tracks, strengths = tuned(case, stage, wanted, without)
    return Specimen(
        case=case,
        stage=stage,
        mesh=mesh,
        plans=wanted,
        without=without,
        effects=effects,
        tracks=tracks,
        strengths=strengths,
    )


def _offsets(case: Case) -> dict[str, np.ndarray]:
    """A robot reports its tool centre point; the cloth is some centimetres from it."""
    rng = case.stream("offsets")
    scale = np.array([0.01, 0.04, 0.02]) * (rng.random() < 0.6)
    return {drive: rng.uniform(-1, 1, 3) * scale for drive in ("left", "right", "bar", "front", "back", "pin")}


def _take(case: Case, stage: Stage, plan: Plan, effects: Sequence[Effect], track: Track) -> Take:
    setting, rng = stage.setting, case.stream(f"cameras {plan.name}")
    stamps = camera_stamps(setting.marker_hz, rng)
    clean = reported(effects, track, stamps)
    noise = camera_noise(clean.shape, setting.marker_hz, setting.noise_m, rng)
    visible = drop_outs(*clean.shape[:2], rng)
    return Take(plan, stamps, clean + noise, visible, drive_stamps(setting.drive_hz, rng))


def _document(one: Specimen, tracks: Films) -> dict:
    case, stage, plan_list, effects, without = one.case, one.stage, one.plans, one.effects, one.without
    setting = stage.setting
    change = {plan.name: rms(moves_m(effects, tracks[plan.name], without[plan.name])) for plan in plan_list}
    filmed = [change[plan.name] for plan in plan_list if not plan.held_out]
    return {
        "schema": "concealed.answers/1",
        "case": {"effects": list(case.effects), "strength": case.strength, "seed": case.seed},
        "effects": [
            {
                "name": effect.name,
                "parameters": effect.parameters,
                "extras": effect.extras,
                "formula": effect.formula,
                "named_by_format": LIBRARY[effect.name].in_table,
                "own_rms_m": strength * setting.noise_m,
            }
            for effect, strength in zip(effects, one.strengths, strict=True)
        ],
        "baseline": {
            **asdict(setting.cloth),
            "friction": setting.friction,
            "air_density_kg_m3": setting.air_density_kg_m3,
        },
        "noise_rms_m": setting.noise_m,
        "target_rms_m": STRENGTHS[case.strength] * setting.noise_m if case.effects else 0.0,
        "effect_rms_m": {**change, "total": float(np.sqrt(np.mean(np.square(filmed)))), "largest": max(filmed)},
        "recordings": [
            {
                "name": plan.name,
                "motion": plan.motion.name,
                "table": plan.motion.table,
                "shows_effect": plan.shown,
                "held_out": plan.held_out,
                "rest_speed_m_s": tracks[plan.name].rest_speed_m_s,
                "nearest_m": tracks[plan.name].nearest_m,
            }
            for plan in plan_list
        ],
        "places_given": setting.places_given,
        "tool_offsets_m": {drive: offset.tolist() for drive, offset in stage.offsets_m.items()},
        "markers_uv_m": stage.markers.uv_m.tolist(),
        "laboratory": {
            "columns": stage.grid.columns,
            "rows": stage.grid.rows,
            "refine": REFINE,
            "specimen": case.specimen,
        },
        "arrays": {
            "NAME/stamps_s": "(F,) stamps of the bundle's marker frames",
            "NAME/clean_m": "(F, M, 3) what the cameras would report at them without noise, in the markers' frame",
            "NAME/missing_n_m2": "(F, M) size of the force per area that the baseline lacks, near each marker",
            "NAME/grip_shift_m": "(F, M) how far held vertices near the marker are off their command; 0 far from grips",
            "NAME/report_shift_m": "(F, M) how far the reported place is from the true one: clocks, frames, cameras",
            "NAME/truth_s": f"(T,) stamps at {TRUTH_HZ:g} Hz from 0 to the end, on the markers' clock",
            "NAME/truth_m": "(T, M, 3) as clean_m, at these stamps",
            "NAME/baseline_m": "(T, M, 3) markers without the effects, at these stamps",
            "NAME/grip_load_n": "(T, D, 3) force of the cloth on each gripper, in the order of the holds, on the robot's clock",
        },
    }


def _arrays(
    plan_list: Sequence[Plan], effects: Sequence[Effect], without: Films, tracks: Films, takes: dict[str, Take]
) -> dict[str, np.ndarray]:
    out: dict[str, np.ndarray] = {}
    truth_s = np.arange(0, DURATION_S + 1e-9, 1 / TRUTH_HZ)
    for plan in plan_list:
        track, stamps = tracks[plan.name], takes[plan.name].stamps_s
        clean = reported(effects, track, stamps)
        at = np.clip(np.round(stamps / track.times_s[1]).astype(int), 0, len(track.times_s) - 1)
        at_truth = np.round(truth_s / track.times_s[1]).astype(int)
        found = {
            "stamps_s": stamps,
            "clean_m": clean,
            "missing_n_m2": _smooth(track.missing_n_m2)[at],
            "grip_shift_m": track.grip_shift_m[at],
            "report_shift_m": np.linalg.norm(clean - reported([], track, stamps), axis=2),
            "truth_s": truth_s,
            "truth_m": reported(effects, track, truth_s),
            "baseline_m": reported([], without[plan.name], truth_s),
            "grip_load_n": track.grip_load_n[at_truth],
        }
        for key, value in found.items():
            out[f"{plan.name}/{key}"] = value if key in ("stamps_s", "truth_s") else value.astype(np.float32)
    return out


def _smooth(course: np.ndarray, samples: int = 11) -> np.ndarray:
    """Running mean over axis 0: contact forces rattle from one millisecond to the next."""
    padded = np.pad(course, ((samples // 2, samples // 2), (0, 0)), mode="edge")
    return np.lib.stride_tricks.sliding_window_view(padded, samples, axis=0).mean(axis=-1)


def _save(place: Path, arrays: dict[str, np.ndarray]) -> None:
    with place.open("wb") as file:
        np.savez_compressed(file, **arrays)


def _replace(target: Path, write) -> None:
    """Write under a temporary name beside the target, then rename: nobody sees half a file or half a folder."""
    target.parent.mkdir(parents=True, exist_ok=True)
    temporary = target.with_name(f".{target.name}.{os.getpid()}")
    try:
        write(temporary)
        if target.is_dir():
            shutil.rmtree(target)
        temporary.rename(target)
    finally:
        if temporary.is_dir():
            shutil.rmtree(temporary)
        temporary.unlink(missing_ok=True)
