"""A laboratory and a diagnosis in a few lines each: they write the right files, and note how they were called."""

import json
import sys
from collections.abc import Callable
from pathlib import Path

from sim1.proof.again import Films
from sim1.proof.campaign import Campaign
from sim1.proof.closure import code_sha256
from sim1.proof.draw import Case
from sim1.proof.files import Drawn, Files
from sim1.proof.start import Wish, open_campaign

DRAG = Case(effects=("air_drag",), seed=1)
PAIR = Case(effects=("wind", "adhesion"), seed=2)
NULL = Case(effects=(), seed=3)
STRANGE = Case(effects=("magnet",), seed=4)
LAME = Case(effects=("fan_jet",), seed=5)  # the laboratory fails to film it
SHRUNK = Case(effects=("shrinkage",), seed=6)  # the diagnosis fails on it

LABORATORY = """
import argparse, json, pathlib, sys, time
import numpy as np
if sys.argv[1] == "list":
    print("air_drag table\\nwind table\\nshrinkage table\\nadhesion table\\nmagnet outside\\nfan_jet outside")
    sys.exit()
parser = argparse.ArgumentParser()
parser.add_argument("--effect", action="append")
for name in ("bundle", "held-out", "answers", "strength", "seed"):
    parser.add_argument("--" + name)
asked = parser.parse_args(sys.argv[2:])
with open(NOTES, "a") as notes:
    notes.write(json.dumps({"who": "laboratory", "at": time.time(), "argv": sys.argv[1:]}) + "\\n")
if "fan_jet" in asked.effect:
    sys.exit("the jet would not start")
effects = [name for name in asked.effect if name != "none"]
bundle, answers = pathlib.Path(asked.bundle), pathlib.Path(asked.answers)
bundle.mkdir(parents=True, exist_ok=True)
(bundle / "bundle.yaml").write_text("looks: " + "+".join(effects))
print("made in", time.perf_counter(), "s")  # of the clock nothing gets into what is committed to
unseen = pathlib.Path(asked.held_out)
unseen.mkdir(parents=True, exist_ok=True)
(unseen / "bundle.yaml").write_text("looks: " + "+".join(effects))
(unseen / "recordings" / "u").mkdir(parents=True, exist_ok=True)
rounding = b"!" if pathlib.Path(ROUNDS).exists() else b""
(unseen / "recordings" / "u" / "markers.parquet").write_bytes(b"of the first half second" + rounding)
arrays = {"a/stamps_s": np.arange(4.0), "a/missing_n_m2": np.eye(4) * len(effects)}
for name in "au":  # of what the diagnosis is given, too
    arrays |= {name + "/truth_s": np.arange(4) / 60, name + "/truth_m": np.zeros((4, 2, 3))}
np.savez(answers.with_suffix(".npz"), **arrays)
answers.write_text(json.dumps({
    "case": {"effects": effects, "strength": asked.strength, "seed": int(asked.seed)},
    "effects": [{"name": n, "parameters": {"c": 2.0}, "named_by_format": n not in ("magnet", "fan_jet")} for n in effects],
    "baseline": {"poisson": 0.3, "stretch_n_m": 300.0}, "places_given": True}))
"""

DIAGNOSIS = """
import json, os, pathlib, sys, time
import numpy as np
from sim1.mismatch.summary import SCHEMA, Prices
bundle, out = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[3])
with open(NOTES, "a") as notes:
    notes.write(json.dumps({"who": "diagnosis", "at": time.time(), "argv": sys.argv[1:], "cwd": os.getcwd(), "pid": os.getpid()}) + "\\n")
while SLOW and pathlib.Path(SLOW).exists():
    time.sleep(0.05)
names = [n for n in (bundle / "bundle.yaml").read_text().removeprefix("looks: ").split("+") if n]
if "shrinkage" in names:
    sys.exit("it shrank to nothing")
verdict = "none" if not names else "unknown" if "magnet" in names else "named"
names = [] if verdict == "unknown" else names
error = {"fit": 0.001, "heldout": 0.002}
better = {"fit": 0.0005, "heldout": 0.001} if names else error
coefficient = {"value": 1.9, "ci95": [1.5, 2.5], "unit": "1"}
(out / "verdict.json").write_text(json.dumps({
    "schema": "sim1.verdict/1", "verdict": verdict, "noise_std_m": 0.0003, "rmse_m": {"baseline": error, "augmented": better},
    "mismatch": {"regions": [], "windows": [], "signature": "made up"}, "alternatives": [], "next_experiment": "none",
    "missing_physics": [{"name": n, "probability": 1.0, "parameters": {"c": coefficient}, "heldout_rmse_reduction": 0.5} for n in names]}))
prices = dict.fromkeys(Prices.model_fields, 1)
ranking = [{"name": " with ".join(names) or "wind", "gain": 50.0, "worth": 40.0, "unsteadiness": 0.1, "established": True, "steady": True, "misfit": 1.0}, {"name": "the baseline", "gain": 0.0, "worth": 0.0, "unsteadiness": 0.0, "established": True, "steady": True, "misfit": 2.0}]
(out / "summary.json").write_text(json.dumps({
    "schema": SCHEMA, "sentence": "made up", "fitted": ["a"], "heldout": ["b"], "heldout_nats": -20.0, "withdrawn": [], "spoken_for": names[1:],
    "converged": True, "creep_m": 0.0,
    "misfit": {"baseline": 2.0, "chosen": 1.0, "limit": 1.35, "alone": 2.5, "heldout": 1.2, "table": False}, "prices": prices, "ranking": ranking, "estimates": [], "effects": names, "detectable": [], "undecided": [], "states": []}))
scalars = {n: {"value": 0.3, "ci95": None} for n in ("area_density_kg_m2", "thickness_m", "stretch_n_m", "bending_n_m", "damping_s")}
scalars["poisson"] = {"value": 0.4, "ci95": [0.35, 0.45]}
friction = {n: {"value": 0.4, "ci95": None} for n in ("table", "robot", "self")}
(out / "model.yaml").write_text(json.dumps({"schema": "sim1.model/1", **scalars, "friction": friction, "effects": []}))
(out / "baseline.yaml").write_text((out / "model.yaml").read_text())
np.savez(out / "forces.npz", **{"a/time_s": np.arange(4.0), "a/force_n": np.eye(4)[..., None] * np.ones(3)})
(out / "report.html").write_text("<p>made up</p>")
print("done")
"""

PREDICTION = """
import json, pathlib, sys
import pyarrow as pa, pyarrow.parquet as pq
unseen, model, out = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[3]), pathlib.Path(sys.argv[5])
with open(NOTES, "a") as notes:
    notes.write(json.dumps({"who": "prediction", "argv": sys.argv[1:]}) + "\\n")
if "adhesion" in (unseen / "bundle.yaml").read_text():
    sys.exit("it sticks")
off_m = 0.004 if model.name == "baseline.yaml" else 0.001  # of truths at the origin
rows = [("u", frame / 60, marker, off_m, off_m, off_m) for frame in range(4) for marker in range(2)]
pq.write_table(pa.table(dict(zip(["recording", "time_s", "marker", "x_m", "y_m", "z_m"], zip(*rows)))), out)
"""

CODE = {"assets_defs/_diagnose.py": "from sim1.mismatch import a\n", "sim1/mismatch/a.py": "a = 1\n"}  # which is hashed

PROGRAMS = {"laboratory": LABORATORY, "diagnosis": DIAGNOSIS, "prediction": PREDICTION}


def write_programs(folder: Path) -> dict[str, tuple[str, ...]]:
    """Commands of the `PROGRAMS`, which take their notes in `folder`.

    The diagnosis waits while `folder/slow` is there; the laboratory rounds otherwise while `folder/rounds` is.
    """
    places = f"NOTES, SLOW, ROUNDS = {[str(folder / name) for name in ('notes.jsonl', 'slow', 'rounds')]!r}\n"
    for name, text in PROGRAMS.items():
        (folder / f"{name}.py").write_text(places + text)
    return {name: (sys.executable, str(folder / f"{name}.py")) for name in PROGRAMS}


def campaign(folder: Path, cases: tuple[Case, ...], tell=lambda line: None, parallel: int = 1) -> Campaign:
    """A campaign of chosen cases in `folder/out`, laboratory and diagnosis as above; one that is there goes on."""
    programs = write_programs(folder)
    for name, text in CODE.items():
        if not (folder / "code" / name).exists():
            (folder / "code" / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / "code" / name).write_text(text)
    files = Files(folder / "out")
    chosen = folder / "cases.yaml"
    chosen.write_text(json.dumps([case.model_dump() for case in cases]))
    wish = Wish() if files.drawn.exists() else Wish(cases_file=chosen)
    drawn: Drawn = open_campaign(files, wish, programs["laboratory"], folder, code_sha256(folder / "code"))
    return Campaign(
        files=files,
        drawn=drawn,
        home=folder,
        diagnose=programs["diagnosis"],
        predict=programs["prediction"],
        environment={},
        code=folder / "code",
        tell=tell,
        parallel=parallel,
    )


def films(made: Campaign, tell: Callable[[str], None]) -> Films:
    """Of a campaign's scored cases; what stayed behind is filmed again by its laboratory."""
    return Films(files=made.files, drawn=made.drawn, home=made.home, tell=tell)


def notes(folder: Path, who: str | None = None) -> list[dict]:
    """How one of the programs was called, or all of them, in the order of the calls."""
    path = folder / "notes.jsonl"
    lines = [json.loads(line) for line in path.read_text().splitlines()] if path.exists() else []
    return [line for line in lines if who in (None, line["who"])]


def unsealed(root: Path) -> None:
    """Take out of a campaign what it tells of its diagnoses, as earlier code left it: what was found can be changed then."""
    write_lines(root, [line for line in lines_of(root) if "of" in line])


def lines_of(root: Path) -> list[dict]:
    """The lines of `commitments.jsonl`."""
    return [json.loads(line) for line in (root / "commitments.jsonl").read_text().splitlines()]


def write_lines(root: Path, lines: list[dict]) -> None:
    """Write them as earlier code did, which put no hash of the line before into a line."""
    (root / "commitments.jsonl").write_text("".join(json.dumps(line | {"before": None}) + "\n" for line in lines))
