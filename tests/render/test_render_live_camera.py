"""Pictures of the cell as it is now are those of the dataset, and the process that makes them is never left behind."""

import signal
import subprocess
import sys
import time
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from planned_towel import plan
from towel_cell import LOOKS, write_inputs

from sim1.episode import read_episode
from sim1.render.blender import BlenderFailed
from sim1.render.film_set import FilmSet
from sim1.render.live_camera import LiveCamera
from sim1.render.looks.draw import draw_appearance, read_looks
from sim1.render.stage import RenderConfig, rendered_episodes
from sim1.stage import random_stream

ROOT = Path(__file__).parents[2]
CONFIG = RenderConfig(
    seed=3,
    width=48,
    height=36,
    samples=1,
    rate_hz=15,
    variants=2,
    workers=1,
    threads=1,
    device="cpu",
    cameras=("head", "left_wrist"),
)


def film_set(inputs) -> FilmSet:
    return FilmSet.of(inputs["garment_mesh"]["towel"], inputs["scene"]["towel"], CONFIG.cameras)


def test_a_live_picture_is_the_frame_of_the_dataset_to_the_bit(tmp_path):
    inputs, out = write_inputs(tmp_path), tmp_path / "out"
    out.mkdir()
    rendered_episodes(inputs, out, CONFIG)
    episode = read_episode(out / "episodes" / "0000")
    clips = plan(inputs, tmp_path / "planned", CONFIG).clips
    camera = LiveCamera(film_set(inputs), CONFIG, tmp_path)
    for clip, frame in ((clips[1], 3), (clips[0], 1), (clips[0], 2)):
        at = frame * clip.stride
        camera.show(clip)
        seen = camera.pictures(
            garment_m=episode.garment_m[at],
            joints_rad=episode.joints_rad[at],
            openness=episode.openness[at],
            frame=frame,
        )
        assert list(seen) == ["head", "left_wrist"]
        for name, picture in seen.items():
            path = out / clip.folder / name / f"{frame:06d}.png"
            np.testing.assert_array_equal(picture, np.asarray(Image.open(path)))
    camera.close()


# Keeps its number in a file. ACT stands for what it does when it is ordered to render.
WORKER = """
import json, os, sys
from pathlib import Path
from PIL import Image

out = Path(sys.argv[2])
(out.parent / "number").write_text(str(os.getpid()))
print(json.dumps({"device": "cpu"}), flush=True)
for line in sys.stdin:
    order = json.loads(line)
    for camera, frame in order["pictures"]:
        ACT
        path = out / "episodes" / "0000" / "v0" / camera / f"{frame:06d}.png"
        path.parent.mkdir(parents=True, exist_ok=True)
        Image.new("RGB", (4, 3), (frame, 0, 0)).save(path)
        print(json.dumps({"rendered": camera}), flush=True)
"""


def stand_in(act: str = "pass") -> tuple[str, ...]:
    return sys.executable, "-c", WORKER.replace("ACT", act)


# The worker itself, over a scene that shows how many looks it has been given, and the garment's colour.
COUNTING = """
import sys, types
from pathlib import Path
from PIL import Image

class Scene:
    device = "cpu"

    def __init__(self, **parts):
        self.looks = 0

    def set_appearance(self, look):
        self.looks += 1
        self.color = tuple(round(255 * part) for part in look.fabric.colors[0])

    def set_frame(self, **states):
        pass

    def render(self, path, **view):
        image = Image.new("RGB", (2, 1), self.color)
        image.putpixel((1, 0), (self.looks, 0, 0))
        image.save(path, format="PNG")

sys.modules["sim1.render.scene3d"] = types.SimpleNamespace(RenderScene=Scene)
from sim1.render.worker import main
sys.exit(main(Path(sys.argv[1]), Path(sys.argv[2]), int(sys.argv[3])))
"""


def test_another_look_under_the_same_name_is_set_up_and_one_that_stays_is_not_set_up_again(tmp_path):
    inputs = write_inputs(tmp_path)
    camera = LiveCamera(film_set(inputs), CONFIG, tmp_path, command=(sys.executable, "-c", COUNTING))
    first = plan(inputs, tmp_path / "planned", CONFIG).clips[0]
    drawing = {"scanned": np.ones((1, 3)), "scanned_share": 0.0, "elevation_jitter_rad": 0.0}
    looks = [draw_appearance(partial(random_stream, seed), read_looks(LOOKS), **drawing) for seed in range(2)]
    seen = []
    for look in (looks[0], looks[0], looks[1], looks[0]):
        camera.show(replace(first, appearance=look))
        seen.append(shown(camera)["head"][0])
    camera.close()
    assert [int(picture[1, 0]) for picture in seen] == [1, 1, 2, 3]
    colors = [np.round(255 * np.array(look.fabric.colors[0])) for look in looks]
    np.testing.assert_array_equal([picture[0] for picture in seen], [colors[at] for at in (0, 0, 1, 0)])
    assert not np.array_equal(*colors)


@pytest.fixture
def live(tmp_path):
    """Makes a live camera whose worker is a small program, shown the first clip."""
    inputs = write_inputs(tmp_path)

    def of(act: str = "pass") -> LiveCamera:
        camera = LiveCamera(film_set(inputs), CONFIG, tmp_path, command=stand_in(act))
        camera.show(plan(inputs, tmp_path / "planned", CONFIG).clips[0])
        return camera

    return of


def shown(camera: LiveCamera, frame: int = 7) -> dict[str, np.ndarray]:
    return camera.pictures(garment_m=np.zeros((144, 3)), joints_rad=np.zeros((2, 6)), openness=np.ones(2), frame=frame)


def is_alive(number: int) -> bool:
    """Whether it runs; one that has ended and that nobody has asked about does not."""
    try:
        return Path(f"/proc/{number}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def test_it_renders_what_it_is_shown_as_often_as_asked_and_leaves_nothing_behind(live, tmp_path):
    camera = live()
    for frame in (7, 8):
        assert {name: picture[0, 0, 0] for name, picture in shown(camera, frame).items()} == {
            "head": frame,
            "left_wrist": frame,
        }
    number = int((tmp_path / "number").read_text())
    folders = set(tmp_path.iterdir())
    del camera
    assert not is_alive(number)
    assert len(folders - set(tmp_path.iterdir())) == 1  # that of its files


def test_why_it_cannot_see_is_said_with_the_last_words(live):
    act = "print('out of memory in kernel', file=sys.stderr, flush=True); os.abort()"
    with pytest.raises(BlenderFailed, match=r"(?s)ended by signal 6.*last words:\nout of memory in kernel"):
        shown(live(act))
    with pytest.raises(BlenderFailed, match="ended with code 0; its last words"):
        shown(live("sys.exit()"))


def test_it_ends_with_the_process_that_made_it_however_that_ends(tmp_path):
    """With the worker itself: it is the one that has to notice."""
    write_inputs(tmp_path)
    code = f"""
import sys, time
from pathlib import Path
from sim1.render.film_set import FilmSet
from sim1.render.live_camera import LiveCamera
from sim1.render.stage import RenderConfig
folder = Path({str(tmp_path)!r})
camera = LiveCamera(FilmSet.of(folder / "mesh", folder / "scene", ["head"]), RenderConfig(device="cpu"), folder)
print(camera._process._process.pid, flush=True)
camera._said.get()  # it is ready
print("ready", flush=True)
time.sleep(60)
"""
    parent = subprocess.Popen([sys.executable, "-c", code], cwd=ROOT, stdout=subprocess.PIPE, text=True)
    number = int(parent.stdout.readline())
    assert parent.stdout.readline() == "ready\n"
    assert is_alive(number)
    parent.send_signal(signal.SIGKILL)
    parent.wait()
    parent.stdout.close()
    until = time.monotonic() + 30
    while is_alive(number) and time.monotonic() < until:
        time.sleep(0.05)
    assert not is_alive(number)
