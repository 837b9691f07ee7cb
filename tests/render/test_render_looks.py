"""Fabrics, tables and rooms are what the files say, and what is drawn from them can be told apart."""

import shutil
from collections import Counter
from dataclasses import replace
from functools import cache, partial
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from towel_cell import LOOKS

from sim1.render.appearance import SCANNED
from sim1.render.looks.cloth_colors import cloth_colors, mean_color
from sim1.render.looks.colors import encoded, linear
from sim1.render.looks.draw import MIN_CONTRAST, Looks, draw_appearance, read_looks, stands_out
from sim1.render.looks.surface_colors import mean_color as surface_mean
from sim1.render.looks.surface_colors import surface_colors
from sim1.render.looks.weaves import REPEAT, WEAVES
from sim1.stage import BadInput, random_stream

COLORS = st.lists(st.tuples(*[st.floats(0.0, 1.0)] * 3), min_size=1, max_size=1)
GREY = ((0.5, 0.5, 0.5),)


@cache
def shipped() -> Looks:
    return read_looks(LOOKS)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A copy of the shipped looks that a test may edit."""
    return Path(shutil.copytree(LOOKS, tmp_path / "appearance"))


def edit(folder: Path, file: str, old: str, new: str) -> None:
    text = (folder / file).read_text()
    assert text.count(old) >= 1, old
    (folder / file).write_text(text.replace(old, new, 1))


def draw(looks: Looks, number: int, *, scanned=GREY, share=0.0):
    chance = partial(random_stream, 0, "appearance", "towel", number)
    return draw_appearance(chance, looks, scanned=np.array(scanned), scanned_share=share, elevation_jitter_rad=0.09)


def distance(look) -> float:
    """Between garment and table as a camera far away sees them in white light: sRGB distance of their mean light."""
    stream = np.random.default_rng(0)
    cloth = np.array(look.fabric.colors[:1])
    if look.fabric.name != SCANNED:
        cloth = cloth_colors(look.fabric, *stream.uniform(-0.3, 0.3, (2, 20_000)))
    height, weft = WEAVES.make(look.fabric.weave, *stream.uniform(0.0, REPEAT, (2, 20_000)))
    light = linear(cloth) + look.fabric.weft * weft[:, None] * (linear(look.fabric.colors[1]) - linear(cloth))
    light = light * (1.0 - look.fabric.shade * (1.0 - height[:, None])) ** 2
    places = stream.uniform(-1.0, 1.0, (2, 20_000)) * np.array([[0.4], [0.6]])
    table = linear(surface_colors(look.table.surface, *places))
    return float(np.linalg.norm(encoded(light.mean(axis=0)) - encoded(table.mean(axis=0))))


def test_the_shipped_files_hold_as_many_looks_as_the_paper_names():
    looks = shipped()
    assert (len(looks.fabrics), len(looks.tables), len(looks.rooms)) == (28, 17, 90)
    names = [entry.name for entry in (*looks.fabrics, *looks.tables, *looks.rooms)]
    assert len(set(names)) == 28 + 17 + 90
    assert "kitchen-low_sun-cool_tiles" in names


@settings(deadline=None)
@given(number=st.integers(0, 10_000), scanned=COLORS, share=st.sampled_from([0.0, 0.5, 1.0]))
def test_the_garment_always_stands_out_from_the_table(number, scanned, share):
    look = draw(shipped(), number, scanned=scanned, share=share)
    assert distance(look) >= 0.29
    assert abs(look.elevation_offset_rad) <= 0.09
    assert (look.fabric.name == SCANNED) or share < 1.0


def test_dots_that_stand_out_on_cloth_that_does_not_are_not_enough():
    polka, lacquer = (
        next(entry for entry in entries if entry.name == name).draw(np.random.default_rng(0))
        for entries, name in ((shipped().fabrics, "polka_dots"), (shipped().tables, "white_lacquer"))
    )
    red, white = (0.2, 0.0, 0.0), (0.95, 0.95, 0.95)
    pattern = replace(polka.pattern, values={"period_m": 0.04, "share": 0.39})
    dotted = replace(polka, colors=(white, red, red), pattern=pattern)
    lacquer = replace(lacquer, surface=replace(lacquer.surface, colors=(white,) * 3))
    assert np.linalg.norm(np.array(mean_color(dotted)) - white) > MIN_CONTRAST
    assert not stands_out(dotted, lacquer)
    assert stands_out(replace(dotted, colors=(red, white, white)), lacquer)


def test_metal_has_to_stand_out_however_dark_the_room_is_that_it_mirrors():
    steel = next(table for table in shipped().tables if table.name == "brushed_steel").draw(np.random.default_rng(0))
    dim = tuple(0.5 * value for value in surface_mean(steel.surface))
    fabric = replace(shipped().scanned.draw(np.random.default_rng(0), (dim,) * 3), shade=0.0)
    lacquer = replace(steel, surface=replace(steel.surface, metallic=0.0))
    assert stands_out(fabric, lacquer)
    assert not stands_out(fabric, steel)


def test_most_places_of_a_measured_texture_have_to_stand_out_not_its_mean_alone():
    white = next(table for table in shipped().tables if table.name == "white_lacquer").draw(np.random.default_rng(0))
    white = replace(white, surface=replace(white.surface, colors=((0.95, 0.95, 0.95),) * 3))
    mean = (0.74, 0.74, 0.74)  # of black and white in equal parts
    fabric = replace(shipped().scanned.draw(np.random.default_rng(0), (mean,) * 3), shade=0.0)
    assert stands_out(fabric, white)
    assert not stands_out(fabric, white, np.array([[0.0] * 3, [1.0] * 3]))
    assert stands_out(fabric, white, np.array([[0.0] * 3, [0.6] * 3, [0.6] * 3]))


@pytest.mark.parametrize("index", range(28))
def test_every_fabric_finds_a_table_that_it_stands_out_from(index):
    looks = shipped()
    alone = Looks(
        folder=looks.folder,
        fabrics=looks.fabrics[index : index + 1],
        scanned=looks.scanned,
        tables=looks.tables,
        rooms=looks.rooms,
    )
    for number in range(4):
        look = draw(alone, number)
        assert look.fabric.name == looks.fabrics[index].name
        assert stands_out(look.fabric, look.table)


def test_every_name_is_drawn_and_none_much_oftener_than_another():
    looks = [draw(shipped(), number) for number in range(280)]
    fabrics = Counter(look.fabric.name for look in looks)
    assert len(fabrics) == 28
    assert max(fabrics.values()) < 30  # 10 are expected of each
    assert len({look.table.name for look in looks}) == 17
    assert len({look.room.name for look in looks}) > 75  # 86 of 90 are expected in 280 draws


def test_an_appearance_is_a_function_of_its_chance():
    assert draw(shipped(), 3) == draw(shipped(), 3)
    assert draw(shipped(), 3) != draw(shipped(), 4)


def test_a_changed_fabric_changes_the_appearances_that_show_it_and_no_others(folder):
    before = [draw(shipped(), number) for number in range(60)]
    edit(folder, "fabrics.yaml", "share: [0.12, 0.3]", "share: [0.13, 0.3]")  # of the polka dots
    edited = read_looks(folder)
    after = [draw(edited, number) for number in range(60)]
    changed = {old.fabric.name for old, new in zip(before, after) if old != new}
    assert changed == {"polka_dots"}


def test_a_new_fabric_takes_its_share_of_the_appearances_and_leaves_the_others(folder):
    before = [draw(shipped(), number) for number in range(120)]
    text = (folder / "fabrics.yaml").read_text()
    start = text.index("  poplin:")
    poplin = text[start : text.index("  canvas:")]
    (folder / "fabrics.yaml").write_text(text + poplin.replace("poplin", "batiste"))
    edited = read_looks(folder)
    after = [draw(edited, number) for number in range(120)]
    changed = [new.fabric.name for old, new in zip(before, after) if old != new]
    assert set(changed) == {"batiste"}
    assert len(changed) < 20


def test_without_a_table_that_stands_out_the_files_are_at_fault(folder):
    text = (folder / "tables.yaml").read_text()
    start = text.index("  concrete:")
    (folder / "tables.yaml").write_text(
        text[: text.index("tables:\n") + 8] + text[start : text.index("  brushed_steel:")]
    )
    with pytest.raises(
        BadInput, match=r"tables\.yaml: no table stands out from fabric scanned, by 0\.3 .*60 %.*0\.5.*add a dark"
    ):
        draw(read_looks(folder), 0, share=1.0)


def test_whole_numbers_are_drawn_all_alike():
    floral = next(fabric for fabric in shipped().fabrics if fabric.pattern.kind == "flowers")
    petals = Counter(floral.draw(np.random.default_rng(number)).pattern.values["petals"] for number in range(600))
    assert set(petals) == {5.0, 6.0, 7.0}
    assert max(petals.values()) < 1.3 * min(petals.values())


def test_drawn_numbers_lie_in_the_entry_s_ranges():
    gingham = next(fabric for fabric in shipped().fabrics if fabric.name == "gingham")
    drawn = [gingham.draw(np.random.default_rng(number)) for number in range(50)]
    periods = [fabric.pattern.values["period_m"] for fabric in drawn]
    assert min(periods) >= 0.02
    assert max(periods) <= 0.05
    assert np.ptp(periods) > 0.02
    assert {fabric.pattern.values["share"] for fabric in drawn} == {0.5}
    assert all(max(fabric.colors[0]) >= 0.9 for fabric in drawn)
