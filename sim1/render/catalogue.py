"""A picture of everything that appearances are drawn from: one small rendering of every fabric, table and room, with its name."""

import tempfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from PIL import Image, ImageDraw, ImageFont

from sim1.picture_file import COLORS
from sim1.render.appearance import Appearance, Fabric, Glow, Room, Surface, Table
from sim1.render.blender import run_blender
from sim1.render.job import SETTINGS, Clip, Job, write_cameras, write_motion
from sim1.render.looks.blocks import Block
from sim1.render.looks.draw import Looks
from sim1.render.looks.noise import clouds, step
from sim1.render.stage import RenderConfig
from sim1.scene.environment import look_at
from sim1.stage import random_stream

VIEW = "view"  # the one camera
FRAME = 0
TABLE_M = (0.8, 1.2, 0.03)
CLOTH_M = 0.5  # side of the square sheet
CLOTH_POINTS = 72  # a side
LABEL_PX = 13
GREY, WHITE = (0.42, 0.42, 0.42), (0.9, 0.9, 0.88)


@dataclass(frozen=True, kw_only=True)
class Shelf:
    """What stands on one sheet: names with appearances, seen by one camera."""

    appearances: dict[str, Appearance]
    eye_m: tuple[float, float, float]
    target_m: tuple[float, float, float]
    fy_over_height: float
    columns: int
    share: float = 1.0  # of the width that is asked for: ninety pictures are smaller than seventeen


def write_sheet(shelf: Shelf, path: Path, config: RenderConfig) -> None:
    """Render a shelf's looks into one PNG file with a palette.

    Args:
        shelf: what to show.
        path: where; its folder is made if need be.
        config: size of a small picture, samples, engine; what belongs to episodes is not used.

    Raises:
        BlenderFailed: a process of Blender could not finish.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    _sheet(_rendered(shelf, sized(shelf, config)), shelf.columns).save(path, format="PNG", optimize=True)


def preview(width: int, **settings: Any) -> RenderConfig:
    """Settings for pictures `width` px wide, at least 32, and three quarters as high."""
    return RenderConfig(width=2 * (width // 2), height=2 * (3 * width // 8), **settings)


def sized(shelf: Shelf, config: RenderConfig) -> RenderConfig:
    """The settings with the size of one picture on the shelf, px."""
    width = 2 * round(shelf.share * config.width / 2)
    return replace(config, width=width, height=2 * round(width * config.height / config.width / 2))


def shelves(looks: Looks, seed: int) -> dict[str, Shelf]:
    """Sheets `fabrics`, `tables` and `rooms`: each shows one sort of look among neutral ones of the others."""

    def drawn[T](sort: str, entries: tuple, place: Callable[[T], Appearance]) -> dict[str, Appearance]:
        return {entry.name: place(entry.draw(random_stream(seed, "catalogue", sort, entry.name))) for entry in entries}

    look = partial(replace, _neutral(looks, seed))
    return {
        "fabrics": Shelf(
            appearances=drawn("fabric", looks.fabrics, lambda fabric: look(fabric=fabric)),
            eye_m=(-0.4, -0.12, 0.46),
            target_m=(0.02, -0.02, 0.0),
            fy_over_height=2.1,
            columns=7,
        ),
        "tables": Shelf(
            appearances=drawn("table", looks.tables, lambda table: look(table=table)),
            eye_m=(-0.55, 0.0, 0.7),
            target_m=(0.0, 0.0, 0.0),
            fy_over_height=1.2,
            columns=6,
        ),
        "rooms": Shelf(
            appearances=drawn("room", looks.rooms, lambda room: look(room=replace(room, yaw_rad=0.0))),
            eye_m=(-1.2, 0.0, 0.95),
            target_m=(0.5, 0.0, -0.2),
            fy_over_height=0.75,
            columns=10,
            share=0.7,
        ),
    }


def _neutral(looks: Looks, seed: int) -> Appearance:
    """A white sheet on a grey table in soft light from the left."""
    none = Block(kind="plain", values={})
    whole = Block(kind="none", values={})
    stream = random_stream(seed, "catalogue")
    fabric: Fabric = looks.scanned.draw(stream, (WHITE,) * 3)
    grey = Surface(
        colors=(GREY,) * 3, figure=none, joints=whole, tone=0.0, roughness=0.7, metallic=0.0, coat=0.0, seed=0
    )
    window = Block(kind="window", values={"elevation_deg": 35.0, "width_deg": 50.0, "height_deg": 40.0})
    light = ((Block(kind="ambient", values={}), 0.45), (window, 0.65))
    room = Room(
        name="neutral",
        yaw_rad=0.0,
        size_m=(6.0, 6.0),
        walls=WHITE,
        floor=grey,
        furniture=(),
        furniture_colors=(GREY,) * 3,
        glows=tuple(Glow(shape=shape, bearing_rad=2.0, color=(1.0, 1.0, 1.0), level=level) for shape, level in light),
        lamps=(),
    )
    # Not the name of the measured texture: there is none here.
    return Appearance(
        fabric=replace(fabric, name="white"),
        table=Table(name="grey", surface=grey),
        room=room,
        elevation_offset_rad=0.0,
    )


def _rendered(shelf: Shelf, config: RenderConfig) -> dict[str, Image.Image]:
    vertices, faces, flat = _sheet_of_cloth()
    table = trimesh.creation.box(TABLE_M)
    pose = look_at(np.array(shelf.eye_m), np.array(shelf.target_m), np.array([0.0, 0.0, 1.0]))
    arrays = {
        "faces": faces,
        "uv": flat[faces],
        "pattern_m": flat,
        "table_vertices": np.asarray(table.vertices) - [0.0, 0.0, TABLE_M[2] / 2],
        "table_faces": np.asarray(table.faces),
    }
    motion = {"garment_m": vertices[None], "parts": np.zeros((1, 0, 4, 4))}
    clips = [
        Clip(episode=f"{number:03d}", variant=0, frame_count=1, stride=1, appearance=appearance)
        for number, appearance in enumerate(shelf.appearances.values())
    ]
    with tempfile.TemporaryDirectory() as temporary:
        folder, out = Path(temporary) / "job", Path(temporary) / "out"
        job = Job(
            folder=folder,
            texture=folder,  # no clip shows a measured texture
            settings={key: getattr(config, key) for key in SETTINGS},
            part_colors=[],
            fy_over_height={VIEW: shelf.fy_over_height},
            clips=clips,
        )
        job.write(arrays)
        for clip in clips:
            write_motion(folder, clip, motion)
            write_cameras(folder, clip, {VIEW: pose[None]})
        run_blender(folder, out)
        return {
            name: Image.open(job.frame_path(out, clip, VIEW, FRAME)).convert("RGB")
            for name, clip in zip(shelf.appearances, clips)
        }


def _sheet_of_cloth() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Vertices (v, 3), faces (f, 3) and flat places (v, 2) of a sheet with soft wrinkles whose far edge is folded back."""
    side = np.linspace(-CLOTH_M / 2, CLOTH_M / 2, CLOTH_POINTS)
    x, y = (axis.ravel() for axis in np.meshgrid(side, side, indexing="ij"))
    wrinkles = 0.03 * step(0.35, 0.9, clouds(5.0 * x + 0.9 * y, 9.0 * y - 3.0 * x, 4, octaves=2))
    radius, line = 0.012, 0.1
    past = np.clip(x - line, 0.0, None)  # what lies beyond the fold goes around a half cylinder and back
    turn = np.minimum(past / radius, np.pi)
    back = np.clip(past - np.pi * radius, 0.0, None)
    along = np.minimum(x, line) + radius * np.sin(turn) - back
    height = 0.004 + radius * (1.0 - np.cos(turn)) + wrinkles
    index = np.arange(CLOTH_POINTS**2).reshape(CLOTH_POINTS, CLOTH_POINTS)
    a, b, c, d = (corner.ravel() for corner in (index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]))
    faces = np.concatenate([np.c_[a, b, c], np.c_[a, c, d]])
    return np.c_[along, y, height], faces, np.c_[x, y]


def _sheet(pictures: dict[str, Image.Image], columns: int) -> Image.Image:
    """All pictures in rows, each with its name below; parts of a name that a picture is too narrow for go on a new line."""
    font = ImageFont.load_default(size=LABEL_PX - 4)
    width, height = next(iter(pictures.values())).size
    breaks = any(font.getlength(name) > width for name in pictures)
    labels = {name: name.split("-") if breaks else [name] for name in pictures}
    label_px = 2 + (LABEL_PX - 2) * max(len(lines) for lines in labels.values())
    rows = -(-len(pictures) // columns)
    sheet = Image.new("RGB", (columns * (width + 2), rows * (height + label_px)), "white")
    draw = ImageDraw.Draw(sheet)
    for number, (name, picture) in enumerate(pictures.items()):
        row, column = divmod(number, columns)
        left, top = column * (width + 2), row * (height + label_px)
        sheet.paste(picture, (left, top))
        for line, text in enumerate(labels[name]):
            draw.text((left + 1, top + height + line * (LABEL_PX - 2)), text, fill="black", font=font)
    return sheet.quantize(COLORS, dither=Image.Dither.NONE)
