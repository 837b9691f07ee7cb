"""The check of videos passes what LeRobot's own reader reads, frame by frame, and nothing that it refuses."""

import dataclasses
import subprocess
import sys
from pathlib import Path

import av
import numpy as np
import pytest
from damaged_towel import EPISODES, VIDEO, change_json, change_table, only_file, set_cell
from hypothesis import example, given, settings
from hypothesis import strategies as st

from sim1.dataset.check_videos import check_videos
from sim1.dataset.tables import read_tables

HEAD = "videos/observation.images.head"


def said_of(artifact: Path) -> str:
    finding = check_videos(artifact / "lerobot", read_tables(artifact / "lerobot"))
    return "" if finding.passed else finding.detail


@settings(max_examples=40, deadline=None)
@example(off_s=0.0)
@example(off_s=0.08)
@example(off_s=-0.04)
@given(off_s=st.floats(-0.3, 0.3) | st.floats(-3e-4, 3e-4))
def test_what_the_reader_refuses_is_refused_and_what_it_reads_rightly_passes(good, off_s):
    from lerobot.datasets.video_utils import FrameTimestampError, decode_video_frames_pyav

    tables = read_tables(good / "lerobot")
    episodes = tables.episodes.copy()
    length = int(episodes["length"][1])
    begin_s = float(episodes[f"{HEAD}/from_timestamp"][1])
    episodes.loc[1, f"{HEAD}/from_timestamp"] = begin_s + off_s
    stamps_s = tables.frames["timestamp"][tables.frames["episode_index"] == 1].astype(float).tolist()
    video = only_file(good, VIDEO)
    right = decode_video_frames_pyav(video, [begin_s + own for own in stamps_s], 1e-4, return_uint8=True)
    try:
        read = [
            decode_video_frames_pyav(video, [begin_s + off_s + own], 1e-4, return_uint8=True)[0] for own in stamps_s
        ]
        reads = all((one == other).all() for one, other in zip(read, right, strict=True))
    except FrameTimestampError:
        reads = False
    finding = check_videos(good / "lerobot", dataclasses.replace(tables, episodes=episodes))
    assert length == len(stamps_s)
    assert finding.passed == reads, finding.detail


@pytest.mark.parametrize("which", ["from", "to"])
@pytest.mark.parametrize("off_s", [0.08, -0.04, 0.002])
def test_a_place_in_the_video_that_is_a_little_off_is_named(artifact, which, off_s):
    name = f"{HEAD}/{which}_timestamp"
    change_table(only_file(artifact, EPISODES), lambda table: set_cell(table, 1, name, table.at[1, name] + off_s))
    said = said_of(artifact)
    assert f"head/chunk-000/file-000.mp4: episode 1: {which}_timestamp is" in said
    assert "episode 0" not in said


def rewrite(path: Path, *, fps: int, count: int) -> None:
    """The first frames of a video again, at another rate."""
    with av.open(str(path)) as container:
        images = [frame.to_ndarray(format="rgb24") for frame in container.decode(video=0)][:count]
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264", rate=fps, options={"bf": "0"})
        stream.height, stream.width = images[0].shape[:2]
        stream.pix_fmt = "yuv420p"
        for image in images:
            container.mux(stream.encode(av.VideoFrame.from_ndarray(image, format="rgb24")))
        container.mux(stream.encode())


def test_a_video_of_another_rate_and_a_shorter_one_are_named(artifact):
    path = only_file(artifact, VIDEO)
    count = len(read_tables(artifact / "lerobot").frames)
    rewrite(path, fps=12, count=count)
    assert "file-000.mp4: frame 15 is at 1.2500 s" in said_of(artifact)
    rewrite(path, fps=10, count=count - 1)
    assert f"file-000.mp4: {count - 1} frames, its episodes have {count}" in said_of(artifact)


def test_a_video_that_is_missing_or_holds_none_is_named(artifact):
    path = only_file(artifact, VIDEO)
    with av.open(str(path), "w") as container:
        stream = container.add_stream("aac", rate=8000)
        sound = av.AudioFrame.from_ndarray(np.zeros((1, 1024), np.float32), format="fltp", layout="mono")
        sound.sample_rate = 8000
        container.mux(stream.encode(sound))
        container.mux(stream.encode())
    assert "file-000.mp4: cannot be decoded (no video in it)" in said_of(artifact)
    path.unlink()
    assert "file-000.mp4: missing; restore the file" in said_of(artifact)


def test_a_video_of_no_known_codec_is_named_and_does_not_end_the_program(artifact):
    path = only_file(artifact, VIDEO)
    path.write_bytes(path.read_bytes().replace(b"avc1", b"????").replace(b"avcC", b"????"))
    script = "import sys; from assets_defs.cli import app; app(['dataset', 'check', sys.argv[1]])"
    answer = subprocess.run([sys.executable, "-c", script, str(artifact)], capture_output=True, text=True, check=False)
    assert answer.returncode == 1, answer.stderr
    assert "file-000.mp4: cannot be decoded (its video is of no known codec)" in answer.stdout
    assert "FAILED moments_match_pictures" in answer.stdout


def test_channels_before_height_and_width_are_read_by_their_names(artifact):
    info = read_tables(artifact / "lerobot").info
    head = {
        **info["features"]["observation.images.head"],
        "shape": [3, 48, 64],
        "names": ["channels", "height", "width"],
    }
    path = artifact / "lerobot/meta/info.json"
    change_json(path, features={**info["features"], "observation.images.head": head})
    assert said_of(artifact) == ""
    head["shape"] = [3, 64, 48]
    change_json(path, features={**info["features"], "observation.images.head": head})
    assert "size [(48, 64)], meta/info.json says (64, 48)" in said_of(artifact)
