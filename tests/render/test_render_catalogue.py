"""A person sees every look, with its name."""

from dataclasses import replace

import numpy as np
import pytest
from PIL import Image
from towel_cell import LOOKS

from sim1.render.catalogue import preview, shelves, sized, write_sheet
from sim1.render.looks.draw import read_looks
from sim1.render.stage import RenderConfig

SMALL = RenderConfig(width=32, height=24, samples=2, device="cpu")


@pytest.fixture(scope="module")
def shelf_of():
    return shelves(read_looks(LOOKS), seed=0)


def test_every_name_stands_on_its_shelf_with_neutral_looks_around_it(shelf_of):
    assert {name: len(shelf.appearances) for name, shelf in shelf_of.items()} == {
        "fabrics": 28,
        "tables": 17,
        "rooms": 90,
    }
    for name, look in shelf_of["fabrics"].appearances.items():
        assert (look.fabric.name, look.table.name, look.room.name) == (name, "grey", "neutral")
    for name, look in shelf_of["rooms"].appearances.items():
        assert (look.fabric.name, look.table.name, look.room.name) == ("white", "grey", name)


def test_every_width_from_the_least_that_the_command_takes_gives_pictures_that_can_be_rendered(shelf_of):
    for width in range(32, 400):
        for shelf in shelf_of.values():
            size = sized(shelf, preview(width))
            assert size.width / size.height == pytest.approx(4 / 3, rel=0.13)


def test_a_sheet_shows_each_look_in_its_place(shelf_of, tmp_path):
    fabrics = shelf_of["fabrics"]
    two = {name: fabrics.appearances[name] for name in ("satin", "tartan")}
    path = tmp_path / "out" / "fabrics.png"
    write_sheet(replace(fabrics, appearances=two, columns=2), path, SMALL)
    sheet = np.asarray(Image.open(path).convert("RGB"), float)
    assert sheet.shape[1] == 2 * (32 + 2)
    wanted = [look.fabric.colors[0] for look in two.values()]
    for (red, _, blue), left in zip(wanted, (0, 34)):
        shown = sheet[10:20, left + 4 : left + 28].mean(axis=(0, 1))
        assert (shown[0] > shown[2] + 10) == (red > blue)
    assert sheet[24:].min() < 100  # the names are written below
    assert sheet[24:].mean() > 200
