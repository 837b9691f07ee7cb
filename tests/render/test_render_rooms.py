"""Rooms: light as bright as it says, from where it says, and furniture that leaves the table free."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from towel_cell import LOOKS

from sim1.render.appearance import Glow, Lamp, Piece, Room
from sim1.render.looks.blocks import Block
from sim1.render.looks.colors import hsv, light_color, linear
from sim1.render.looks.draw import read_looks
from sim1.render.looks.furniture import FURNITURE
from sim1.render.looks.lamps import lamp_power_w
from sim1.render.looks.room_meshes import CLEAR_M, FLOOR_BELOW_M, room_meshes
from sim1.render.looks.sky import GLOWS, directions, sky
from sim1.stage import BadInput

ROOMS = {entry.name: entry for entry in read_looks(LOOKS).rooms}
HUES = st.floats(0.0, 360.0)
PLATE = np.array([[-0.4, -0.6, -0.03], [0.4, 0.6, 0.0]])


def room(**changes) -> Room:
    return replace(ROOMS["kitchen-skylight-cool_tiles"].draw(np.random.default_rng(0)), **changes)


def light_on_a_sheet(picture: np.ndarray, normal: tuple[float, float, float]) -> np.ndarray:
    """Radiance of a white sheet with that normal, under a picture of all directions."""
    around = directions(len(picture))
    weight = np.clip(around.to @ np.array(normal), 0.0, None) * around.solid_angle / np.pi
    return (picture * weight[..., None]).sum(axis=(0, 1))


@st.composite
def glows(draw) -> Block:
    kind = draw(st.sampled_from(sorted(GLOWS.limits)))
    return Block(kind=kind, values={name: draw(st.floats(*limits)) for name, limits in GLOWS.limits[kind].items()})


@settings(deadline=None)
@given(shape=glows(), level=st.floats(0.1, 5.0), bearing=st.floats(0.0, 6.3), hue=HUES)
def test_a_glow_lights_the_table_as_bright_as_its_level_whatever_its_colour(shape, level, bearing, hue):
    glow = Glow(shape=shape, bearing_rad=bearing, color=hsv(hue, 0.4, 1.0), level=level)
    picture = sky(room(glows=(glow,)))
    assert np.isfinite(picture).all()
    red, green, blue = light_on_a_sheet(picture, (0.0, 0.0, 1.0))
    assert 0.2126 * red + 0.7152 * green + 0.0722 * blue == pytest.approx(level, rel=0.01)


def test_a_light_keeps_its_hue():
    light = light_color((1.0, 0.8, 0.6))
    np.testing.assert_allclose(light / light[0], linear(np.array([1.0, 0.8, 0.6])))


def test_a_glow_that_falls_between_the_points_of_the_sky_s_picture_is_refused():
    shape = Block(kind="panel", values={"offset": 2.8, "width": 0.1, "length": 0.1})
    glow = Glow(shape=shape, bearing_rad=0.0, color=(1.0, 1.0, 1.0), level=1.0)
    with pytest.raises(BadInput, match=r"glow panel of .*2\.8.* would light nothing; make it wider"):
        sky(room(glows=(glow,)), rows=32)


@pytest.mark.parametrize(("elevation_deg", "distance_m"), [(90.0, 1.0), (30.0, 1.0), (30.0, 2.0)])
def test_a_lamp_s_power_makes_the_sheet_as_bright_as_its_level(elevation_deg, distance_m):
    up, along = np.sin(np.radians(elevation_deg)), np.cos(np.radians(elevation_deg))
    position = (distance_m * along, 0.0, distance_m * up)
    lamp = Lamp(position_m=position, side_m=0.01, color=(1.0, 1.0, 1.0), level=0.7)
    radiance = lamp_power_w(lamp) / (np.pi * 0.01**2)  # of a small Lambertian square
    solid_angle = 0.01**2 / distance_m**2
    assert radiance * solid_angle * up / np.pi == pytest.approx(0.7)  # white paper sends 1/pi of what it gets


def test_the_floor_s_picture_is_turned_with_the_room():
    straight, turned = (room_meshes(room(yaw_rad=yaw), PLATE) for yaw in (0.0, 0.7))
    np.testing.assert_allclose(turned.floor_flat_m, straight.floor_flat_m)
    np.testing.assert_allclose(straight.floor[:, :2], straight.floor_flat_m, atol=1e-12)
    assert np.abs(turned.floor[:, :2] - turned.floor_flat_m).max() > 0.5


@pytest.mark.parametrize("bearing", [0.0, 0.5 * np.pi, np.pi, 1.5 * np.pi])
def test_a_low_sun_lights_the_wall_that_it_shines_on(bearing):
    sun = Block(kind="sun", values={"elevation_deg": 20.0, "width_deg": 10.0})
    picture = sky(room(glows=(Glow(shape=sun, bearing_rad=bearing, color=(1.0, 1.0, 1.0), level=1.0),)))
    towards = (np.cos(bearing), np.sin(bearing), 0.0)
    away = (-towards[0], -towards[1], 0.0)
    assert light_on_a_sheet(picture, towards)[0] == pytest.approx(1.0 / np.tan(np.radians(20.0)), rel=0.1)
    assert light_on_a_sheet(picture, away)[0] < 0.2


@pytest.mark.parametrize("name", ROOMS)
def test_the_lights_of_a_room_add_up_to_a_level_of_its_range(name):
    entry = ROOMS[name]
    for seed in range(3):
        drawn = entry.draw(np.random.default_rng(seed))
        level = sum(light.level for light in (*drawn.glows, *drawn.lamps))
        assert entry.light.level.low - 1e-9 <= level <= entry.light.level.high + 1e-9


@settings(deadline=None)
@given(
    name=st.sampled_from(sorted(ROOMS)),
    seed=st.integers(0, 1000),
    half=st.tuples(st.floats(0.2, 0.8), st.floats(0.2, 0.9)),
)
def test_furniture_stands_clear_of_the_table_on_the_floor_and_within_the_walls(name, seed, half):
    table = np.array([[-half[0], -half[1], -0.03], [half[0], half[1], 0.0]])
    drawn = ROOMS[name].draw(np.random.default_rng(seed))
    meshes = room_meshes(replace(drawn, yaw_rad=0.0), table)
    ground = -0.03 - FLOOR_BELOW_M
    np.testing.assert_allclose(meshes.floor[:, 2], ground)
    for part in meshes.furniture:
        assert part.vertices_m[:, 2].min() >= ground - 1e-9
        assert (np.abs(part.vertices_m[:, :2]) <= np.abs(meshes.floor[:, :2]).max(axis=0) + 1e-9).all()
    for piece in drawn.furniture:
        alone = replace(drawn, furniture=(piece,))
        # Without the legs of the table itself, which every room has.
        corners = np.concatenate([part.vertices_m for part in room_meshes(alone, table).furniture])
        legs = np.concatenate([part.vertices_m for part in room_meshes(replace(drawn, furniture=()), table).furniture])
        own = [corner for corner in corners if not (np.abs(legs - corner).max(axis=1) < 1e-9).any()]
        assert np.hypot(*np.array(own)[:, :2].T).min() >= np.hypot(*half) + CLEAR_M - 0.05  # handles stand out by 2 cm


def test_a_table_with_legs_of_its_own_stands_on_the_floor():
    standing = np.array([[-0.4, -0.6, -0.74], [0.4, 0.6, 0.0]])
    meshes = room_meshes(room(furniture=()), standing)
    np.testing.assert_allclose(meshes.floor[:, 2], -0.74)
    assert meshes.furniture == ()


def test_walls_face_the_table_and_stand_on_the_floor_s_edge():
    meshes = room_meshes(room(yaw_rad=0.4), PLATE)
    for wall in meshes.walls:
        normal = np.cross(wall[1] - wall[0], wall[2] - wall[0])
        assert np.dot(normal, -wall.mean(axis=0)) > 0.0
        assert {tuple(corner.round(6)) for corner in wall[:2]} <= {tuple(corner.round(6)) for corner in meshes.floor}


@pytest.mark.parametrize("kind", sorted(FURNITURE.limits))
@pytest.mark.parametrize("size", [0.3, 0.6, 2.0])
def test_a_piece_has_its_front_in_the_plane_that_it_is_placed_by(kind, size):
    block = Block(kind=kind, values=dict.fromkeys(FURNITURE.limits[kind], size))
    parts = FURNITURE.make(block)
    corners = np.concatenate([part.vertices_m for part in parts])
    assert corners[:, 0].min() >= -0.04  # a handle, a door
    assert corners[:, 2].min() >= -1e-9
    for part in parts:
        assert part.faces.min() >= 0
        assert part.faces.max() < len(part.vertices_m)
    assert sum(len(part.faces) for part in parts) < 400  # background stays cheap


def test_a_room_is_turned_about_the_table():
    piece = Piece(shape=Block(kind="stool", values={"width_m": 0.3, "height_m": 0.5}), bearing_rad=np.pi / 2, gap_m=0.1)
    meshes = room_meshes(room(furniture=(piece,), yaw_rad=np.pi / 2), PLATE)
    body = next(part for part in meshes.furniture if part.color == 0)
    np.testing.assert_allclose(body.vertices_m[:, :2].mean(axis=0)[1], 0.0, atol=0.02)
    assert body.vertices_m[:, 0].max() < -0.8
