"""Does the recording that a report asks for settle what it could not tell? The same cloth without and with it."""

import json
import shutil
from pathlib import Path
from typing import Any

import yaml

from benchmarks.concealed.case import Case
from benchmarks.concealed.make import make
from sim1.mismatch.findings import run_diagnosis
from sim1.mismatch.summary import read_summary
from sim1.mismatch.verdict import Verdict
from sim1.stage import BadInput


def separate(
    effect: str, strength: str, seed: int, motions: tuple[str, ...], adding: tuple[str, ...], out: Path
) -> str:
    """Film `motions` and `adding` once, diagnose the bundle without and with `adding`; a Markdown table of both verdicts.

    Writes OUT/with, OUT/without (bundles), OUT/answers.json and what each diagnosis wrote; films that are there are kept.

    Raises:
        BadInput: the films that are there are of something else.
    """
    whole, less = out / "with", out / "without"
    if (out / "answers.json").is_file():
        refuse_others(out, {"effects": [effect], "strength": strength, "seed": seed}, (*motions, *adding))
    else:
        make(Case((effect,), strength, seed, (*motions, *adding)), whole, out / "answers.json")
    without_last(whole, less, keep=len(motions))
    lines = [
        f"{effect}, {strength}, seed {seed}: {', '.join(motions)}; then {', '.join(adding)} as well",
        "",
        "| recordings | verdict | first, second of the ranking | it asks for |",
        "| --- | --- | --- | --- |",
    ]
    for label, bundle in (("without", less), ("with", whole)):
        found = run_diagnosis(bundle, out / f"found_{label}", lambda share, what: None)
        lines.append(f"| {label} | {_called(found)} | {_ranked(out / f'found_{label}')} | {found.next_experiment} |")
    return "\n".join(lines)


def refuse_others(out: Path, asked: dict[str, Any], motions: tuple[str, ...]) -> None:
    """Raises BadInput where OUT/answers.json and OUT/with are of another case, or show other motions."""
    case = json.loads((out / "answers.json").read_text())["case"]
    listed = yaml.safe_load((out / "with" / "bundle.yaml").read_text())["recordings"]
    filmed = tuple(one["name"].rpartition("_")[0] for one in listed)
    if case != asked or filmed != motions:
        raise BadInput(
            f"{out} holds films of {case}, {', '.join(filmed)}; asked is {asked}, {', '.join(motions)}: give another folder for --out"
        )


def without_last(whole: Path, less: Path, keep: int) -> None:
    """The bundle with the first `keep` recordings alone."""
    if less.is_dir():
        shutil.rmtree(less)
    shutil.copytree(whole, less)
    listed = yaml.safe_load((less / "bundle.yaml").read_text())
    for dropped in listed["recordings"][keep:]:
        shutil.rmtree(less / "recordings" / dropped["name"])
    listed["recordings"] = listed["recordings"][:keep]
    (less / "bundle.yaml").write_text(yaml.safe_dump(listed, sort_keys=False))


def _called(found: Verdict) -> str:
    names = " + ".join(effect.name for effect in found.missing_physics)
    return f"{found.verdict} {names}".strip()


def _ranked(folder: Path) -> str:
    ranking = read_summary(folder / "summary.json").ranking
    return ", ".join(f"`{row.name}` {row.gain:.0f}" for row in ranking[:2])
