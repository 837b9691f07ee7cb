"""The bundle without the last recordings is the same cloth, filmed once."""

import json

import pytest
import yaml

from benchmarks.diagnosis.separating import separate, without_last
from sim1.stage import BadInput


def test_only_the_last_recordings_are_left_out(tmp_path):
    whole = tmp_path / "with"
    for name in ("a", "b", "c"):
        (whole / "recordings" / name).mkdir(parents=True)
        (whole / "recordings" / name / "markers.parquet").write_bytes(name.encode())
    (whole / "bundle.yaml").write_text(yaml.safe_dump({"recordings": [{"name": name} for name in ("a", "b", "c")]}))
    less = tmp_path / "without"
    for _ in range(2):  # again over what is there
        without_last(whole, less, keep=2)
    assert sorted(path.name for path in (less / "recordings").iterdir()) == ["a", "b"]
    assert (less / "recordings" / "b" / "markers.parquet").read_bytes() == b"b"
    assert yaml.safe_load((less / "bundle.yaml").read_text()) == {"recordings": [{"name": "a"}, {"name": "b"}]}
    assert len(yaml.safe_load((whole / "bundle.yaml").read_text())["recordings"]) == 3


@pytest.mark.parametrize(
    "change", [{"effect": "wind"}, {"strength": "weak"}, {"seed": 6}, {"motions": ("heave",)}, {"adding": ("twist",)}]
)
def test_films_of_something_else_are_not_diagnosed_under_this_name(tmp_path, change):
    asked = {"effect": "actuator_lag", "strength": "medium", "seed": 5, "motions": ("hang",), "adding": ("fast_swing",)}
    (tmp_path / "with").mkdir()
    listed = [{"name": "hang_a"}, {"name": "fast_swing_b"}]
    (tmp_path / "with" / "bundle.yaml").write_text(yaml.safe_dump({"recordings": listed}))
    case = {"effects": ["actuator_lag"], "strength": "medium", "seed": 5}
    (tmp_path / "answers.json").write_text(json.dumps({"case": case}))
    with pytest.raises(BadInput, match="give another folder for --out"):
        separate(**(asked | change), out=tmp_path)
