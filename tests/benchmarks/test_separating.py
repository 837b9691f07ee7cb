"""The bundle without the last recordings is the same cloth, filmed once."""

import yaml

from benchmarks.diagnosis.separating import without_last


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
