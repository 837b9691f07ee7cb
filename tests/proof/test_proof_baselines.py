"""Simpler methods: what they are asked, and what they make of forces that are known."""

from dataclasses import replace

import numpy as np
import pytest
from proof_stand_ins import campaign, films

from sim1.cloth.effects import EFFECTS, Site
from sim1.cloth.precise.world import World
from sim1.mismatch.search import Term, Unknowns
from sim1.proof.baselines import sindy
from sim1.proof.baselines.ask import ask_baselines
from sim1.proof.baselines.dictionary import RIG, entries_of, world_with
from sim1.proof.baselines.residual import NAMES, smooth_term
from sim1.proof.draw import Case
from sim1.proof.prove import prove
from sim1.proof.report import rewrite
from sim1.stage import BadInput

PLAIN = World(area_density_kg_m2=0.2, stretch_n_m=300.0, poisson=0.3, bending_n_m=2e-4, damping_s=1e-3, friction=0.4)
SITE = Site(low_m=(0.0, 0.0), high_m=(0.3, 0.3), curvature_1_m=20.0, grip_load_n=0.1, table=True)


def entries():
    return entries_of(PLAIN, SITE)


def column(named, name, variant=0):
    """Index of a column; `named` is an effect, or None for the fabric."""
    found = [k for k, e in enumerate(entries()) if (e.term.effect.name if e.term else None) == named and e.name == name]
    return found[variant]


def test_the_dictionary_has_every_effect_on_cloth_and_the_fabric_and_nothing_of_the_rig():
    effects = {entry.term.effect.name for entry in entries() if entry.term}
    assert effects == set(EFFECTS) - set(RIG)
    assert [entry.name for entry in entries() if not entry.term][-1] == "friction"
    assert len({entry.world for entry in entries()} | {PLAIN}) == len(entries()) + 1  # each changes the world
    without = entries_of(PLAIN, replace(SITE, table=False))
    assert "adhesion" not in {entry.term.effect.name for entry in without if entry.term}
    assert "friction" not in {entry.name for entry in without if not entry.term}


def test_what_is_picked_becomes_a_world_within_the_limits_and_at_the_strongest_place():
    known, sizes = entries(), np.ones(len(entries()))
    shares = np.zeros(len(known))
    shares[column("heavy_region", "mass", 3)], shares[column("heavy_region", "mass", 7)] = 0.5, 0.2
    shares[column("adhesion", "pressure")] = -2.0  # cloth is not pushed off a table
    shares[column(None, "stretch_n_m")] = 3.0
    world, names = world_with(PLAIN, known, shares, sizes)
    assert names == ("heavy_region",)
    place = known[column("heavy_region", "mass", 3)].world.heavy_patch
    assert world.heavy_patch == (*place[:2], pytest.approx(0.5 * place[2]))
    assert world.adhesion_pa == 0.0
    assert world.stretch_n_m == pytest.approx(1.3 * PLAIN.stretch_n_m)


def test_a_fabric_that_is_off_is_no_name():
    shares = np.zeros(len(entries()))
    shares[column(None, "damping_s")] = 1.0
    assert world_with(PLAIN, entries(), shares, np.ones(len(shares)))[1] == ()


def given(shares, noise):
    """Forces that are the columns' sum by `shares`, and noise."""
    stream = np.random.default_rng(0)
    columns = 1e-4 * stream.standard_normal((4000, len(entries())))
    missing = columns @ shares + noise * stream.standard_normal(4000)
    return sindy.Regression(entries=entries(), columns=columns, missing=missing)


def test_sparse_regression_names_what_the_forces_are_made_of():
    shares = np.zeros(len(entries()))
    shares[column("added_mass", "mass")] = 0.7
    world, names = sindy.chosen(PLAIN, given(shares, 3e-5))
    assert names == ("added_mass",)
    assert world.added_mass_kg_m2 == pytest.approx(0.7 * 0.08, rel=0.05)


def test_forces_of_noise_alone_are_called_nothing():
    world, names = sindy.chosen(PLAIN, given(np.zeros(len(entries())), 1e-4))
    assert (world, names) == (PLAIN, ())


def test_without_pysindy_the_way_to_get_it_is_said(monkeypatch):
    made = given(np.zeros(len(entries())), 1e-4)
    monkeypatch.setitem(__import__("sys").modules, "pysindy", None)
    with pytest.raises(BadInput, match="dev extra"):
        sindy.chosen(PLAIN, made)


def test_smoothing_keeps_what_lasts_and_takes_away_what_shakes():
    time = np.arange(240) / 60
    steady, shaking = np.ones(240), np.sin(2 * np.pi * 5.0 * time)
    forces = np.stack([steady, shaking])[..., None, None] * np.ones((1, 1, 2, 3))
    smooth = sindy.smoothed(forces, 1 / 60)
    assert smooth[0] == pytest.approx(np.ones_like(smooth[0]))
    assert np.sqrt(np.mean(smooth[1, 3:-3] ** 2)) < 0.02


def test_the_residual_is_none_at_its_prior_and_18_numbers_beside_it():
    term: Term = smooth_term(2.0)
    model = Unknowns(base=PLAIN, nominal=(), terms=(term,))
    assert not any(model.world(np.zeros(18)).smooth_push)
    assert model.world(np.ones(18)).smooth_push == tuple(0.2 if n.startswith("push") else 0.4 for n in NAMES)


def interrupted(said, after):
    """Something that takes lines and stops whoever tells them, as Ctrl-C does."""

    def tell(line):
        said.append(line)
        if len(said) == after:
            raise KeyboardInterrupt

    return tell


CASES = (Case(effects=("air_drag",), seed=1), Case(effects=(), seed=3), Case(effects=("shrinkage",), seed=6))


def test_every_diagnosed_case_is_asked_once_without_its_answers_and_the_report_tells(tmp_path, monkeypatch):
    made = campaign(tmp_path, CASES)  # the last diagnosis fails
    outcomes, asked, said = prove(made).outcomes, [], []

    def sparse(bundle, physics, held):
        asked.append((bundle.name, physics.parent.name))
        return sindy.Named(effects=("air_drag",), heldout_m=0.0015 if bundle.name == "case_001" else None)

    monkeypatch.setattr("sim1.proof.baselines.ask.read_bundle", lambda path: path)
    monkeypatch.setattr("sim1.proof.baselines.ask.read_physics", lambda path: path)
    monkeypatch.setattr("sim1.proof.baselines.ask.sparse_effects", sparse)
    monkeypatch.setattr("sim1.proof.baselines.ask.heldout_m", lambda bundle, physics, held: 0.0012)
    with pytest.raises(KeyboardInterrupt):
        ask_baselines(films(made, interrupted(said, after=1)), outcomes)
    for _ in range(2):
        ask_baselines(films(made, said.append), outcomes)
    assert asked == [("case_001", "case_001"), ("case_002", "case_002")]
    assert said == [
        "case_001: sparse regression says air_drag and is off by 1.50 mm; 1 of 2 asked",
        "case_002: sparse regression says air_drag and finds no way; 2 of 2 asked",
        "case_001: a residual without a name is off by 1.20 mm; 1 of 2 asked",
        "case_002: a residual without a name is off by 1.20 mm; 2 of 2 asked",
    ]
    table = {row.name.split(" (")[0]: row for row in rewrite(made.files).methods}
    row = table["sparse regression on forces"]
    assert (row.singles.count, row.nulls.count, row.heldout) == (1, 0, pytest.approx(0.75))
    page = (tmp_path / "out" / "proof.html").read_text()
    assert "Beside simpler methods" in page
    assert "sparse regression on forces (SINDy)" in page
