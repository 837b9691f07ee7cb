"""Pictures of the cell as it is now: a process of Blender that renders what it is shown, one state after the other."""

import contextlib
import sys
import tempfile
import weakref
from pathlib import Path
from queue import SimpleQueue

import numpy as np
from PIL import Image

from sim1.render.blender import check_end, tells_of_a_picture
from sim1.render.blender_process import BlenderProcess, Said
from sim1.render.film_set import FilmSet
from sim1.render.job import Clip, frame_path, write_clip, write_moment
from sim1.render.shares import Order
from sim1.render.stage import RenderConfig

MOMENT = "now.npz"  # in the job's folder; every picture waits for the one before


class LiveCamera:
    """All cameras of a film set, in one process that ends with this object, or with the process that made it.

    A picture is that which `rendered_episodes` makes of the same state, look, clip and frame number by the same settings.

    Args:
        film_set: the cell.
        config: how pictures are rendered, but for `workers`: it is one.
        folder: where its files may lie while it is there.
        command: a worker.

    Attributes:
        close: ends the process; nothing where it has ended.
    """

    def __init__(
        self,
        film_set: FilmSet,
        config: RenderConfig,
        folder: Path,
        *,
        command: tuple[str, ...] = (sys.executable, "-m", "sim1.render.worker"),
    ):
        files = tempfile.TemporaryDirectory(dir=folder)
        self._film_set, self._folder = film_set, Path(files.name)
        film_set.job(self._folder, [], config)
        self._said: SimpleQueue[Said] = SimpleQueue()
        arguments = (str(self._folder), str(self._folder), str(config.threads or 1))
        self._process = BlenderProcess([*command, *arguments], self._said)
        self.close = weakref.finalize(self, _end, self._process, files)
        self._clip: Clip | None = None

    def show(self, clip: Clip) -> None:
        """From now on pictures are of that clip's look. Its episode's name and frame numbers decide about their noise."""
        write_clip(self._folder, clip)
        self._clip = clip

    def pictures(
        self, *, garment_m: np.ndarray, joints_rad: np.ndarray, openness: np.ndarray, frame: int
    ) -> dict[str, np.ndarray]:
        """What every camera sees, (h, w, 3) u8 sRGB.

        Args:
            garment_m: (v, 3).
            joints_rad: (2, 6).
            openness: (2,).
            frame: number of this state among the clip's frames.

        Raises:
            BlenderFailed: with the reason, or the last words of the process.
            BadInput: the look's elevation has no direction where a camera stands.
        """
        film = self._film_set.film(garment_m=garment_m[None], joints_rad=joints_rad[None], openness=openness[None])
        cameras = self._film_set.raised(film.cameras, self._clip.appearance.elevation_offset_rad)
        write_moment(self._folder, MOMENT, film.at(frame, cameras))
        wanted = tuple((name, frame) for name in sorted(cameras))
        self._process.send(Order(clip=self._clip.key, pictures=wanted, moment=MOMENT))
        while self._process.owed:
            process, line = self._said.get()
            if line is None:
                check_end(process)
            tells_of_a_picture(process, line)
        return {name: _taken(frame_path(self._folder, self._clip, name, frame)) for name, _ in wanted}


def _taken(path: Path) -> np.ndarray:
    with Image.open(path) as image:
        pixels = np.asarray(image.convert("RGB"))
    path.unlink()
    return pixels


def _end(process: BlenderProcess, files: tempfile.TemporaryDirectory) -> None:
    process.kill()
    process.close()
    with contextlib.suppress(FileNotFoundError):  # whoever owns the folder may have removed it
        files.cleanup()
