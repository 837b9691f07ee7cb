from types import SimpleNamespace

import numpy as np
import pytest

from sim1.validity.raster import Camera, draw_table, in_view_share, render, render_head_view


def looking_down(height_m: float = 1.0, size: int = 80, fy_px: float = 80.0) -> Camera:
    pose = np.eye(4)
    pose[2, 3] = height_m
    return Camera(camera_to_world=pose, fy_px=fy_px, width=size, height=size)


def sheet(count: int, size_m: float, z_m: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    axis = np.linspace(-size_m / 2, size_m / 2, count)
    x, y = np.meshgrid(axis, axis, indexing="ij")
    vertices = np.stack([x.ravel(), y.ravel(), np.full(count**2, z_m)], axis=-1)
    corner = (np.arange(count - 1)[:, None] * count + np.arange(count - 1)).ravel()
    low = np.stack([corner, corner + count, corner + 1], axis=-1)
    high = np.stack([corner + 1, corner + count, corner + count + 1], axis=-1)
    return vertices, np.concatenate([low, high])


def a_scene(camera: Camera) -> SimpleNamespace:
    head = SimpleNamespace(pose=camera.camera_to_world, fy_px=camera.fy_px, width=camera.width, height=camera.height)
    return SimpleNamespace(table_size_m=np.array([0.8, 1.2, 0.03]), table_top_m=0.0, cameras={"head": head})


def drawn(vertices, faces, colors, camera):
    canvas = np.zeros((camera.height, camera.width, 3))
    depth = np.full((camera.height, camera.width), np.inf)
    render(vertices, faces, np.asarray(colors, float), camera, canvas, depth)
    return canvas, depth


def test_a_square_covers_the_pixels_that_the_pinhole_model_says():
    camera = looking_down()
    canvas, depth = drawn(*sheet(9, 0.5), [200, 100, 50], camera)
    covered = np.isfinite(depth)
    assert covered.sum() == 40 * 40  # 0.5 m at 1 m and f = 80 px
    assert covered[20:60, 20:60].all()
    np.testing.assert_allclose(depth[covered], 1.0)
    assert (canvas[~covered] == 0).all()


def test_a_mesh_leaves_no_pixel_open_along_its_inner_edges():
    rng = np.random.default_rng(3)
    vertices, faces = sheet(20, 0.5)
    inner = (np.abs(vertices[:, :2]) < 0.24).all(axis=1)
    vertices[inner] += rng.uniform(-0.008, 0.008, (inner.sum(), 3))
    _, depth = drawn(vertices, faces, [200, 100, 50], looking_down())
    assert np.isfinite(depth[21:59, 21:59]).all()


def test_the_nearer_of_two_sheets_is_seen_whatever_their_order():
    low, faces = sheet(5, 0.5, 0.0)
    high, _ = sheet(5, 0.2, 0.3)
    camera = looking_down()
    colors = np.repeat([[200.0, 0, 0], [0, 200.0, 0]], len(faces), axis=0)
    both, _ = drawn(np.concatenate([low, high]), np.concatenate([faces, faces + len(low)]), colors, camera)
    swapped, _ = drawn(np.concatenate([high, low]), np.concatenate([faces, faces + len(low)]), colors[::-1], camera)
    assert both[40, 40, 1] > 0
    assert both[40, 40, 0] == 0
    np.testing.assert_array_equal(both, swapped)


def test_depth_inside_a_tilted_triangle_is_that_of_its_plane():
    vertices = np.array([[-0.4, -0.4, 0.0], [0.4, -0.4, 0.4], [0.0, 0.4, 0.2]])
    camera = looking_down()
    _, depth = drawn(vertices, np.array([[0, 1, 2]]), [200, 200, 200], camera)
    rays = camera.rays()
    hit = np.array([0, 0, 1.0]) + depth[..., None] * rays
    seen = np.isfinite(depth)
    np.testing.assert_allclose(hit[seen][:, 2], 0.2 + 0.5 * hit[seen][:, 0], atol=1e-6)


def test_the_back_of_a_fabric_is_darker_than_its_front():
    vertices, faces = sheet(4, 0.5)
    front, _ = drawn(vertices, faces, [200, 200, 200], looking_down())
    back, _ = drawn(vertices, faces[:, ::-1], [200, 200, 200], looking_down())
    assert 0 < back[40, 40, 0] < 0.8 * front[40, 40, 0]


def test_a_triangle_behind_the_camera_is_not_drawn():
    vertices, faces = sheet(4, 0.5, z_m=1.5)
    _, depth = drawn(vertices, faces, [200, 200, 200], looking_down())
    assert not np.isfinite(depth).any()


def test_the_table_fills_its_rectangle_and_ends_at_its_edge():
    camera = looking_down(height_m=2.0)
    _, depth = draw_table(np.array([0.8, 1.2, 0.03]), 0.0, camera)
    assert np.isfinite(depth).sum() == 32 * 48


def test_the_head_view_keeps_the_field_of_view_at_any_size():
    vertices, faces = sheet(20, 0.4)
    scene = a_scene(looking_down(size=480, fy_px=480.0))
    small = render_head_view(vertices, faces, scene, 48, 48)
    large = render_head_view(vertices, faces, scene, 96, 96)
    assert small.dtype == np.uint8
    blue = [(image[..., 2] > image[..., 0] + 20).mean() for image in (small, large)]
    assert blue[0] == pytest.approx(0.16, abs=0.02)
    assert blue[1] == pytest.approx(blue[0], abs=0.02)


def test_the_share_in_view_is_that_of_the_worst_frame():
    """Half a metre around the middle is seen from one metre up; a sheet pushed half out of it is half seen."""
    vertices, _ = sheet(11, 0.5)
    scene = a_scene(looking_down())
    assert in_view_share(vertices[None], scene) == 1.0
    half_out = vertices + np.array([0.51, 0, 0])
    assert in_view_share(np.stack([vertices, half_out, vertices]), scene) == pytest.approx(5 / 11)
    behind = vertices + np.array([0, 0, 2.0])
    assert in_view_share(behind[None], scene) == 0.0
