"""The artifact of `mismatch_report`: verdict and page of a diagnosis that was made before."""

import json
import shutil
from pathlib import Path

from sim1.mismatch.page import CAPTIONS, write_page
from sim1.mismatch.strict_json import write_json
from sim1.mismatch.summary import read_summary
from sim1.mismatch.verdict import read_verdict
from sim1.stage import BadInput, Facts


def write_report(recordings: Path, calibrated: Path, out: Path) -> Facts:
    """Write `verdict.json`, `report.html` and the picture of where and when.

    Raises:
        BadInput: an artifact is damaged.
    """
    verdict, summary = read_verdict(calibrated / "verdict.json"), read_summary(calibrated / "summary.json")
    missing = [name for name in CAPTIONS if not (calibrated / name).is_file()]
    if missing:
        raise BadInput(f"{calibrated}: pictures {missing} are missing; make calibrated_physics again")
    stand_in = _is_virtual(recordings / "origin.json")
    write_json(out / "verdict.json", verdict)
    write_page(out / "report.html", verdict, summary, calibrated, stand_in=stand_in)
    shutil.copyfile(calibrated / "forces.png", out / "forces.png")
    return {
        "verdict": verdict.verdict,
        "sentence": summary.sentence,
        "recordings_are": "a stand-in lab (simulated)" if stand_in else "real",
        "signature": verdict.mismatch.signature,
        "next_experiment": verdict.next_experiment,
    }


def _is_virtual(path: Path) -> bool:
    try:
        virtual = json.loads(path.read_text())["virtual"]
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise BadInput(f"{path}: does not say what was recorded ({error!r}); make recordings again") from error
    if not isinstance(virtual, bool):
        raise BadInput(f"{path}: virtual is {virtual!r}, expected true or false; make recordings again")
    return virtual
