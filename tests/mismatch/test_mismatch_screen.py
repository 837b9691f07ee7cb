"""What a shortlist rests on: fingerprints by the coarser mesh, and an engine that corrects for its step."""

from dataclasses import replace

import numpy as np
import pytest
from small_bundle import empty_bundle, filmed, plain_world

from sim1.cloth.precise.simulate import NotConverged
from sim1.mismatch import engine as module
from sim1.mismatch.engine import Engine
from sim1.mismatch.fit import fit
from sim1.mismatch.screen import screen, site_of, typical_information
from sim1.mismatch.search import baseline


@pytest.fixture(scope="module")
def engine():
    with Engine(filmed(empty_bundle(motions=2, duration_s=1.2), air_normal=1.3)) as engine:
        engine.refine(plain_world(engine.bundle), engine.names)
        yield engine


@pytest.fixture(scope="module")
def base(engine):
    return fit(
        engine, baseline(engine.bundle), np.zeros(baseline(engine.bundle).count), engine.names,
        temper=dict.fromkeys(engine.names, 3.0), most=2,
    )  # fmt: skip


def meshes_of(engine, monkeypatch):
    """On which mesh each of the engine's tasks is simulated, as they are asked for."""
    asked, run = [], engine.run
    monkeypatch.setattr(engine, "run", lambda tasks: asked.extend(task.finer for task in tasks) or run(tasks))
    return asked


def test_a_shortlist_is_drawn_up_on_the_coarser_mesh_and_headed_by_what_was_concealed(engine, base, monkeypatch):
    asked = meshes_of(engine, monkeypatch)
    first = screen(engine, base, site_of(engine, base.unknowns.world(base.z)), engine.names)[0]
    assert first.term.effect.name == "air_drag"
    assert first.gain > 50.0
    assert set(asked) == {engine.finest - 1}
    assert engine.finer == engine.finest


def test_where_the_sheet_finds_no_way_on_the_coarser_mesh_the_working_one_tells(engine, base, monkeypatch):
    asked, run = meshes_of(engine, monkeypatch), engine.run

    def lost_when_rough(tasks):
        done = run(tasks)
        if tasks[0].finer < engine.finest:
            raise NotConverged("recording swing_0: no next state at 1 s")
        return done

    monkeypatch.setattr(engine, "run", lost_when_rough)
    first = screen(engine, base, site_of(engine, base.unknowns.world(base.z)), engine.names)[0]
    assert first.term.effect.name == "air_drag"
    assert set(asked) == {engine.finest - 1, engine.finest}


def test_without_projection_the_fabric_stays_and_what_it_could_imitate_counts_as_told(engine, base, monkeypatch):
    def shortlist():
        found = screen(engine, base, site_of(engine, base.unknowns.world(base.z)), engine.names)
        return {one.term.effect.name: one for one in found}

    projected = shortlist()
    monkeypatch.setattr(engine, "projects", False)
    plain = shortlist()
    assert plain.keys() == projected.keys()
    kept = []
    for name, one in plain.items():
        assert one.start[: len(base.z)] == pytest.approx(base.z, abs=1e-6)
        kept += list(np.divide(projected[name].information, one.information))
    assert max(kept) <= 1.0 + 1e-6
    assert min(kept) < 0.9  # of some fingerprint the fabric imitates a good part
    moved = projected["air_drag"].start[: len(base.z)] - base.z
    assert np.abs(moved).max() > 1e-3  # what imitated the drag is given up as it comes in


def test_what_half_a_step_changes_tells_what_a_step_gets_wrong(engine):
    """Against a step that is eight times as fine; what is left of the error is of higher order."""
    world = plain_world(engine.bundle)
    for name in engine.names:
        task = engine.task(name, world)
        working, fine = (run.markers_m[0] for run in engine.run([task, replace(task, step_s=module.STEP_S / 8)]))
        wrong = fine - working
        assert np.linalg.norm(wrong - engine.stages[name].defect_m) < 0.15 * np.linalg.norm(wrong)


def test_a_threshold_that_no_recording_crosses_tells_of_no_strength():
    assert typical_information(np.array([[3.0], [1.0], [0.0], [0.0], [0.0]])) == (2.0,)
    assert typical_information(np.zeros((3, 2))) == (0.0, 0.0)
