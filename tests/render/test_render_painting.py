"""Patterns, dyes, weaves and surfaces: colours in range, of the size and share that their numbers say."""

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from towel_cell import LOOKS

from sim1.render.appearance import SCANNED
from sim1.render.looks import cloth_colors, surface_colors
from sim1.render.looks.blocks import Block, Whole
from sim1.render.looks.colors import encoded, linear
from sim1.render.looks.draw import read_looks
from sim1.render.looks.dyes import DYES
from sim1.render.looks.figures import FIGURES
from sim1.render.looks.joints import JOINTS
from sim1.render.looks.noise import clouds, scatter
from sim1.render.looks.patterns import PATTERNS
from sim1.render.looks.weaves import REPEAT, WEAVES, weave_tile

SHIPPED = read_looks(LOOKS)
PLACES = np.meshgrid(np.linspace(-0.4, 0.4, 161), np.linspace(-0.4, 0.4, 161))
SHARES = [("stripes", "share"), ("dots", "share"), ("chevron", "share"), ("checks", "share")]


@st.composite
def blocks(draw, kinds) -> Block:
    """Any block within its kind's limits."""
    kind = draw(st.sampled_from(sorted(kinds.limits)))
    numbers = {
        name: st.sampled_from([float(number) for number in limits.numbers])
        if isinstance(limits, Whole)
        else st.floats(*limits)
        for name, limits in kinds.limits[kind].items()
    }
    return Block(kind=kind, values={name: draw(number) for name, number in numbers.items()})


@settings(deadline=None)
@given(pattern=blocks(PATTERNS), seed=st.integers(0, 2**31 - 1))
def test_a_pattern_shares_every_place_among_three_colours(pattern, seed):
    weights = PATTERNS.make(pattern, *PLACES, seed)
    np.testing.assert_allclose(weights.sum(axis=-1), 1.0)
    assert weights.min() >= 0.0
    assert (weights[..., PATTERNS.color_counts[pattern.kind] :] == 0.0).all()


@settings(deadline=None)
@given(figure=blocks(FIGURES), seed=st.integers(0, 2**31 - 1))
def test_a_surface_shares_every_place_among_three_colours(figure, seed):
    weights = FIGURES.make(figure, *PLACES, seed)
    np.testing.assert_allclose(weights.sum(axis=-1), 1.0)
    assert weights.min() >= -1e-12
    assert (weights[..., FIGURES.color_counts[figure.kind] :] == 0.0).all()


@settings(deadline=None)
@given(dye=blocks(DYES), seed=st.integers(0, 2**31 - 1))
def test_a_dye_gives_colours(dye, seed):
    palette = np.array([[0.9, 0.1, 0.1], [0.1, 0.9, 0.1], [0.1, 0.1, 0.9]])
    color = np.broadcast_to(palette[0], (*PLACES[0].shape, 3))
    dyed = DYES.make(dye, color, *PLACES, palette, seed)
    assert dyed.shape == color.shape
    assert dyed.min() >= 0.0
    assert dyed.max() <= 1.0


@settings(deadline=None)
@given(weave=blocks(WEAVES))
def test_a_weave_s_tile_can_be_laid_beside_itself(weave):
    height, weft = weave_tile(weave, 8 * REPEAT)
    assert height.min() >= 0.0
    assert height.max() <= 1.0
    assert set(np.unique(weft)) <= {0.0, 1.0}
    place = np.linspace(0.25, REPEAT - 0.25, 60)
    x, y = np.meshgrid(place, place)
    here = np.stack(WEAVES.make(weave, x, y))
    for dx, dy in ((REPEAT, 0), (0, REPEAT)):
        np.testing.assert_allclose(np.stack(WEAVES.make(weave, x + dx, y + dy)), here, atol=1e-9)


@pytest.mark.parametrize(("kind", "name"), SHARES)
def test_the_second_colour_covers_the_share_that_the_pattern_names(kind, name):
    place = (np.arange(400) + 0.5) / 400 * 0.4  # ten periods
    pattern = Block(kind=kind, values={"period_m": 0.04, name: 0.25})
    weights = PATTERNS.make(pattern, *np.meshgrid(place, place), 5)
    assert weights[..., 1].mean() == pytest.approx(0.25, abs=0.01)


def test_camouflage_covers_about_its_share():
    place = np.linspace(0.0, 4.0, 500)
    weights = PATTERNS.make(Block(kind="blobs", values={"period_m": 0.05, "share": 0.5}), *np.meshgrid(place, place), 1)
    assert 1.0 - weights[..., 0].mean() == pytest.approx(0.45, abs=0.06)  # two quarters that overlap


def test_a_gingham_s_squares_are_as_large_as_its_period_says():
    x = np.arange(0.0, 0.2, 0.001) + 0.0005
    weights = PATTERNS.make(Block(kind="checks", values={"period_m": 0.04, "share": 0.5}), x, np.full_like(x, 0.01), 0)
    assert np.nonzero(np.diff(weights[:, 1]))[0].tolist() == [19, 39, 59, 79, 99, 119, 139, 159, 179]
    assert set(weights[:, 1]) == {0.5, 1.0}  # y lies in a band of the second colour


def test_denim_shows_its_weft_at_one_crossing_of_four():
    _, weft = weave_tile(Block(kind="twill", values={"over": 3.0}), 4 * REPEAT)
    assert weft.mean() == 0.25


def test_a_plank_s_gaps_are_as_wide_as_they_say_and_its_neighbours_are_shifted():
    y = np.arange(0.0, 1.0, 0.001) + 0.0005
    planks = Block(kind="planks", values={"width_m": 0.1, "length_m": 2.0, "gap_m": 0.005})
    first, row, gap = JOINTS.make(planks, np.full_like(y, 1.0), y)
    assert gap.mean() == pytest.approx(0.05)
    assert set(row) == set(range(10))
    assert len(set(first)) > 1


@settings(deadline=None)
@given(seed=st.integers(0, 2**31 - 1), octaves=st.integers(1, 4))
def test_noise_is_smooth_fills_its_range_and_repeats_where_it_is_told_to(seed, octaves):
    x, y = np.random.default_rng(0).uniform(0.0, 16.0, (2, 4000))
    here = clouds(x, y, seed, octaves=octaves, wrap=16)
    assert here.min() >= 0.0
    assert here.max() <= 1.0
    assert 0.45 < here.mean() < 0.55
    assert here.std() > 0.07
    assert np.abs(clouds(x + 1e-4, y, seed, octaves=octaves, wrap=16) - here).max() < 2e-3
    np.testing.assert_allclose(clouds(x + 16.0, y - 16.0, seed, octaves=octaves, wrap=16), here, atol=1e-9)


def test_cells_of_a_lattice_are_independent_and_know_their_seed():
    i, j = np.meshgrid(np.arange(-200, 200), np.arange(-200, 200))
    here = scatter(i, j, 1)
    assert here.mean() == pytest.approx(0.5, abs=0.01)
    assert np.histogram(here, 10, (0.0, 1.0))[0].min() > 0.09 * here.size
    assert abs(np.corrcoef(here[:, 1:].ravel(), here[:, :-1].ravel())[0, 1]) < 0.02
    assert abs(np.corrcoef(here.ravel(), scatter(i, j, 2).ravel())[0, 1]) < 0.02


BLACK, WHITE = (0.0, 0.0, 0.0), (1.0, 1.0, 1.0)


@pytest.fixture
def cloth():
    """Plain white cloth without shade or weft."""
    poplin = next(entry for entry in SHIPPED.fabrics if entry.name == "poplin").draw(np.random.default_rng(0))
    plain, even = Block(kind="plain", values={}), Block(kind="even", values={})
    return replace(poplin, colors=(WHITE, BLACK, BLACK), pattern=plain, dye=even, weave=plain, weft=0.0, shade=0.0)


def test_a_fabric_s_mean_is_the_colour_of_its_mean_light(cloth):
    stripes = Block(kind="stripes", values={"period_m": 0.02, "share": 0.5})
    half = 0.7354  # the sRGB grey that sends half of white's light
    assert cloth_colors.mean_color(cloth) == pytest.approx(WHITE)
    assert cloth_colors.mean_color(replace(cloth, pattern=stripes)) == pytest.approx((half,) * 3, abs=0.01)
    assert cloth_colors.mean_color(replace(cloth, weft=1.0)) == pytest.approx((half,) * 3, abs=0.01)


def test_a_weave_s_hollows_darken_the_mean(cloth):
    dark = [cloth_colors.mean_color(replace(cloth, shade=shade))[0] for shade in (0.0, 0.3, 1.0)]
    assert dark[0] > dark[1] + 0.05 > dark[2] + 0.1
    pile = replace(cloth, weave=Block(kind="pile", values={}), shade=0.4)  # its height is about 0.5 in the mean
    assert cloth_colors.mean_color(pile)[0] == pytest.approx(0.8, abs=0.04)


def test_a_measured_texture_is_judged_by_its_places(cloth):
    scanned = replace(cloth, name=SCANNED, colors=((0.5,) * 3,) * 3)
    assert cloth_colors.mean_color(scanned) == pytest.approx((0.5,) * 3)
    places = np.array([BLACK, WHITE, WHITE])
    np.testing.assert_allclose(cloth_colors.shown_light(scanned, places), places)


@pytest.mark.parametrize("entry", SHIPPED.fabrics, ids=lambda entry: entry.name)
def test_a_fabric_s_mean_is_that_of_a_cloth_looked_at_thread_by_thread(entry):
    fabric = entry.draw(np.random.default_rng(0))
    stream = np.random.default_rng(1)
    x, y = stream.uniform(-0.3, 0.3, (2, 60_000))
    height, weft = WEAVES.make(fabric.weave, *stream.uniform(0.0, REPEAT, (2, 60_000)))
    light = linear(cloth_colors.cloth_colors(fabric, x, y))
    on_top = weft == 1.0
    light[on_top] += fabric.weft * (linear(fabric.colors[1]) - light[on_top])
    seen = light * (1.0 - fabric.shade * (1.0 - height[:, None])) ** 2
    np.testing.assert_allclose(cloth_colors.mean_color(fabric), encoded(seen.mean(axis=0)), atol=0.04)


@pytest.mark.parametrize("entry", SHIPPED.tables, ids=lambda entry: entry.name)
def test_a_table_s_mean_is_that_of_what_it_shows(entry):
    surface = entry.draw(np.random.default_rng(0)).surface
    x, y = np.meshgrid(np.linspace(-0.4, 0.4, 301), np.linspace(-0.6, 0.6, 451))
    shown = encoded(linear(surface_colors.surface_colors(surface, x, y)).mean(axis=(0, 1)))
    np.testing.assert_allclose(surface_colors.mean_color(surface), shown, atol=0.04)


def test_srgb_and_linear_light_are_each_other_s_inverse():
    values = np.linspace(0.0, 1.0, 1001)
    np.testing.assert_allclose(encoded(linear(values)), values, atol=1e-6)
    assert linear(np.array(0.5)) == pytest.approx(0.2140, abs=1e-4)


SPREAD = np.random.default_rng(0).uniform(-0.4, 0.4, (2, 40_000))
SHARED = {  # what covers a share of the plane: the share of a second colour there
    "heather": lambda share: dyed("heather", amount=share, fibre_m=0.002),
    "wash": lambda share: dyed("wash", amount=share, patch_m=0.01),
    "mottled": lambda share: FIGURES.make(
        Block(kind="mottled", values={"size_m": 0.1, "share": 0.0, "fleck_m": 0.005, "flecks": share}), *SPREAD, 3
    )[..., 2],
}


def dyed(kind: str, **values: float) -> np.ndarray:
    black = np.zeros((*SPREAD[0].shape, 3))
    return DYES.make(Block(kind=kind, values=values), black, *SPREAD, np.array([BLACK, WHITE, WHITE]), 3)[..., 0]


@pytest.mark.parametrize("kind", SHARED)
def test_a_share_is_that_of_the_plane_and_nothing_or_all_at_its_ends(kind):
    assert (SHARED[kind](0.0) == 0.0).all()
    assert (SHARED[kind](1.0) == 1.0).all()
    for share in (0.05, 0.3, 0.7):
        assert SHARED[kind](share).mean() == pytest.approx(share, abs=0.04)


def told_apart(one, other) -> bool:
    """Whether two drawn fabrics differ enough to be seen: in colour, or in the relief of their threads."""
    place = np.meshgrid(*[np.linspace(-0.1, 0.1, 80)] * 2)
    threads = np.meshgrid(*[np.linspace(0.0, 0.02, 60)] * 2)

    def relief(fabric):
        height, weft = WEAVES.make(fabric.weave, *(axis / fabric.thread_m for axis in threads))
        return np.stack([fabric.shade * height, fabric.weft * weft])

    pairs = [[cloth_colors.cloth_colors(fabric, *place) for fabric in (one, other)], [relief(one), relief(other)]]
    return any(np.abs(a - b).mean() > 0.02 for a, b in pairs)


def drawn(entry, seed=1):
    return entry.draw(np.random.default_rng(seed))


def test_fabrics_can_be_told_apart():
    """No two names give the same picture: the numbers of each differ enough to be seen."""
    for one, other in combinations(SHIPPED.fabrics, 2):
        assert told_apart(drawn(one), drawn(other)), (one.name, other.name)


@pytest.mark.parametrize("entry", SHIPPED.fabrics, ids=lambda entry: entry.name)
def test_a_fabric_under_another_name_would_not_be_told_apart(entry):
    assert not told_apart(drawn(entry), drawn(replace(entry, name="twin")))


def test_tables_can_be_told_apart():
    place = np.meshgrid(*[np.linspace(-0.1, 0.1, 80)] * 2)
    tables = {entry.name: surface_colors.surface_colors(drawn(entry).surface, *place) for entry in SHIPPED.tables}
    for one, other in combinations(sorted(tables), 2):
        assert np.abs(tables[one] - tables[other]).mean() > 0.02, (one, other)
