"""A fault in the files of fabrics, tables and rooms is told with file, entry, key, value and remedy."""

import re
import shutil
from pathlib import Path

import pytest
from towel_cell import LOOKS

from sim1.render.looks.draw import FILES, read_looks
from sim1.stage import BadInput


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A copy of the shipped looks that a test may edit."""
    return Path(shutil.copytree(LOOKS, tmp_path / "appearance"))


def edit(folder: Path, file: str, old: str, new: str) -> None:
    text = (folder / file).read_text()
    assert text.count(old) >= 1, old
    (folder / file).write_text(text.replace(old, new, 1))


FAULTS = {
    "a key is misspelt": (
        "fabrics.yaml",
        "sheen: [0.0, 0.15]",
        "shine: [0.0, 0.15]",
        r"fabrics\.poplin\.shine is \[0\.0, 0\.15\]: the key 'shine' is unknown; remove it, or write one of .*sheen",
    ),
    "a key is missing": (
        "fabrics.yaml",
        "    roughness: [0.6, 0.8]\n",
        "",
        r"fabrics\.poplin is .*: the key 'roughness' is missing; add it",
    ),
    "a number is out of range": (
        "fabrics.yaml",
        "roughness: [0.6, 0.8]",
        "roughness: [0.6, 1.8]",
        r"fabrics\.poplin\.roughness is \[0\.6, 1\.8\]: expected a number or \[low, high\] within 0 to 1",
    ),
    "a range is upside down": (
        "fabrics.yaml",
        "roughness: [0.6, 0.8]",
        "roughness: [0.8, 0.6]",
        r"fabrics\.poplin\.roughness is \[0\.8, 0\.6\]: expected a number or \[low, high\]",
    ),
    "a truth value stands for a number": (
        "fabrics.yaml",
        "roughness: [0.6, 0.8]",
        "roughness: yes",
        r"fabrics\.poplin\.roughness is True: expected a number",
    ),
    "a kind is unknown": (
        "fabrics.yaml",
        "{kind: checks,",
        "{kind: chequers,",
        r"fabrics\.gingham\.pattern\.kind is 'chequers': there is no such pattern; write kind: plain, stripes, checks",
    ),
    "a list stands for a kind": (
        "fabrics.yaml",
        "{kind: checks,",
        "{kind: [checks],",
        r"fabrics\.gingham\.pattern\.kind is \['checks'\]: there is no such pattern; write kind: plain, stripes, checks",
    ),
    "a fraction stands for a whole number": (
        "fabrics.yaml",
        "petals: [5, 7]",
        "petals: 5.5",
        r"pattern\.petals is 5\.5: expected one of 3, 4, 5, 6, 7, 8, 9, or \[low, high\] of these",
    ),
    "a width that does not divide the tile": (
        "fabrics.yaml",
        "{kind: herringbone, width: 8}",
        "{kind: herringbone, width: 6}",
        r"fabrics\.herringbone\.weave\.width is 6: expected one of 2, 4, 8, 16",
    ),
    "half a light": (
        "rooms.yaml",
        "count: [2, 4]",
        "count: [0.5, 4]",
        r"lights\.ceiling_panels\.glows\.1\.count is \[0\.5, 4\]: expected one of 0, 1, 2, 3, 4, 5, 6",
    ),
    "a panel too far off to be seen": (
        "rooms.yaml",
        "offset: [-1.0, 1.0]",
        "offset: [-1.0, 2.8]",
        r"lights\.skylight\.glows\.1\.offset is \[-1\.0, 2\.8\]: expected a number or \[low, high\] within -2 to 2",
    ),
    "a block has a number of another kind": (
        "fabrics.yaml",
        "weave: {kind: satin}",
        "weave: {kind: satin, over: 2}",
        r"fabrics\.satin\.weave\.over is 2: the key 'over' is unknown",
    ),
    "a pattern shows more colours than there are": (
        "fabrics.yaml",
        "    pattern: {kind: tartan",
        "      - {hue_deg: 0, saturation: 0, value: 1}\n    pattern: {kind: tartan",
        r"fabrics\.tartan\.colors is .*: expected a list of 1 to 3 entries",
    ),
    "the weft has a colour that is not there": (
        "fabrics.yaml",
        "shade: [0.03, 0.1]\n    weft: 0.0",
        "shade: [0.03, 0.1]\n    weft: 0.5",
        r"fabrics\.poplin\.colors is .*: 1 colours, and weft shows 2; add 1",
    ),
    "a name occurs twice": ("fabrics.yaml", "  canvas:\n", "  poplin:\n", r"'poplin' occurs twice line 32"),
    "a fabric takes the measured texture's name": (
        "fabrics.yaml",
        "  canvas:\n",
        "  scanned:\n",
        r"fabrics\.scanned is .*this name is the measured texture's; give another",
    ),
    "the measured texture gets a weft": (
        "fabrics.yaml",
        "weft: 0.0",
        "weft: 0.2",
        r"scanned\.weft is 0\.2: a measured texture has no second colour; write 0",
    ),
    "another schema": (
        "tables.yaml",
        "sim1.table_looks/1",
        "sim1.table_looks/9",
        r"schema is 'sim1\.table_looks/9', expected .*write schema: sim1\.table_looks/1",
    ),
    "a name is a number": (
        "fabrics.yaml",
        "  canvas:\n",
        "  7:\n",
        r"fabrics is .*: the key 7 is no text; put it in quotes",
    ),
    "a hue is no number": (
        "tables.yaml",
        "hue_deg: [32, 40]",
        "hue_deg: brown",
        r"tables\.light_oak\.colors\.0\.hue_deg is 'brown': expected a number",
    ),
    "a table is empty": (
        "tables.yaml",
        "  walnut:\n",
        "  beech:\n  walnut:\n",
        r"tables\.beech is None: expected lines",
    ),
    "a piece of furniture is unknown": (
        "rooms.yaml",
        "{kind: sofa,",
        "{kind: settee,",
        r"layouts\.living_room\.furniture\.1\.kind is 'settee': there is no such furniture; write kind: cabinet, desk",
    ),
    "two rooms could have one name": (
        "rooms.yaml",
        "  living_room:\n",
        "  living-room:\n",
        r"layouts\.living-room is .*: the name 'living-room' has the '-' that joins names; write '_' in its place",
    ),
    "a light is sure of no source": (
        "rooms.yaml",
        "{kind: ambient, count: 1, share: [0.5, 0.9], hue_deg: [20, 35]",
        "{kind: ambient, count: [0, 1], share: [0.5, 0.9], hue_deg: [20, 35]",
        r"lights\.evening_lamps\.glows is .*: no glow is always there; give one a count of 1",
    ),
    "a floor's joints are unknown": (
        "rooms.yaml",
        "joints: {kind: tiles,",
        "joints: {kind: bricks,",
        r"palettes\.cool_tiles\.floor\.joints\.kind is 'bricks': there is no such joints; write kind: none, planks, tiles",
    ),
    "two colours for three sorts of furniture": (
        "rooms.yaml",
        "      - {hue_deg: [80, 130], saturation: [0.2, 0.5], value: [0.15, 0.4]}\n",
        "",
        r"palettes\.warm_wood\.furniture is .*: expected a list of 3 to 3 entries",
    ),
}


@pytest.mark.parametrize("name", FAULTS)
def test_a_fault_is_named_with_file_entry_key_value_and_remedy(folder, name):
    file, old, new, said = FAULTS[name]
    edit(folder, file, old, new)
    with pytest.raises(BadInput, match=rf"(?s){re.escape(file)}: .*{said}"):
        read_looks(folder)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", r"rooms\.yaml: the file is None, not lines of .* write schema: sim1\.rooms/1"),
        (
            "schema: sim1.rooms/1\n",
            r"rooms\.yaml: the file is {}: it is empty; write the keys layouts, lights, palettes",
        ),
    ],
)
def test_an_empty_file_is_told_what_belongs_in_it(folder, text, said):
    (folder / "rooms.yaml").write_text(text)
    with pytest.raises(BadInput, match=said):
        read_looks(folder)


@pytest.mark.parametrize("file", FILES)
def test_a_missing_file_is_named(folder, file):
    (folder / file).unlink()
    with pytest.raises(BadInput, match=rf"{file}: cannot be read"):
        read_looks(folder)
