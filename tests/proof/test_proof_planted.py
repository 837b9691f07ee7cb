"""Wrong answers that lie about: the diagnosis itself, started as a campaign starts it, writes what it writes without them, to the byte."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from small_bundle import empty_bundle, filmed

from pipeline.home import REPOSITORY
from sim1.proof.closure import ENTRY
from sim1.recording.bundle import write_bundle

WRITTEN = ("verdict.json", "summary.json", "model.yaml", "baseline.yaml")
WRONG = {"case": {"effects": ["wind"], "seed": 1}, "effects": [{"name": "wind", "parameters": {"vx": 0.5}}]}
PLANTED = (  # below a campaign's folder
    "bundles/case_001/answers.json",
    "bundles/case_001/case_001.json",
    "bundles/answers.json",
    "bundles/case_001.json",
    "answers/case_001.json",
    "answers.json",
)


@pytest.fixture(scope="module")
def films(tmp_path_factory):
    """A bundle that is quickly simulated, of cloth with drag, and what it is of."""
    folder = tmp_path_factory.mktemp("films") / "case_001"
    write_bundle(folder, filmed(empty_bundle(motions=2, duration_s=1.2), air_normal=3.0))
    return folder


def diagnosed(campaign: Path) -> dict[str, bytes]:
    """What the real diagnosis writes of the case of a campaign, by name."""
    (campaign / "empty").mkdir()
    out = campaign / "found" / "case_001"
    command = [sys.executable, "-P", "-m", ENTRY, "diagnose", str(campaign / "bundles" / "case_001"), "--out", str(out)]
    surroundings = {**os.environ, "PYTHONPATH": str(REPOSITORY)}
    done = subprocess.run(
        command, cwd=campaign / "empty", env=surroundings, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return {name: (out / name).read_bytes() for name in WRITTEN}


@pytest.mark.slow
@pytest.mark.timeout(1800)
def test_the_real_diagnosis_writes_the_same_to_the_byte_with_wrong_answers_in_and_beside_its_bundle(films, tmp_path):
    found = {}
    for name in ("alone", "planted"):
        campaign = tmp_path / name
        shutil.copytree(films, campaign / "bundles" / "case_001")
        for place in PLANTED if name == "planted" else ():
            (campaign / place).parent.mkdir(exist_ok=True)
            (campaign / place).write_text(json.dumps(WRONG))
        found[name] = diagnosed(campaign)
    assert json.loads(found["alone"]["verdict.json"])["schema"] == "sim1.verdict/1"
    assert found["planted"] == found["alone"]
