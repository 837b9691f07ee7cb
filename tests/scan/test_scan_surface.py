"""From points to surface: support, normals, openings, triangles."""

from pathlib import Path

import numpy as np
import pytest

from sim1.scan.cloud import Shape, read_scan
from sim1.scan.fit import fitted
from sim1.scan.garment_file import read_garment_file
from sim1.scan.ingest import ingest
from sim1.scan.normals import oriented_normals
from sim1.scan.poisson import cut_open, poisson
from sim1.scan.remesh import area_m2, clean, corner_angles_rad, remesh
from sim1.scan.removal import register, separate
from sim1.scan.rest import rest_shape
from sim1.scan.rims import rim_edges, rim_lengths_m
from sim1.scan.sliver import without_slivers
from sim1.scan.surface import closest_points
from sim1.scan.virtual.bodies import board, loft, slab
from sim1.scan.virtual.scanner import look_at
from sim1.stage import BadInput

GARMENTS, SCANS = (Path(__file__).parents[2] / "data" / name for name in ("garments", "scans"))


def tube_points(count=12_000, radius=0.08, length=0.30, noise=1e-4, seed=0):
    rng = np.random.default_rng(seed)
    angle, height = rng.uniform(0, 2 * np.pi, count), rng.uniform(0, length, count)
    outward = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    return outward * radius + np.stack([0 * angle, 0 * angle, height], axis=1) + rng.normal(
        0, noise, (count, 1)
    ) * outward, outward


@pytest.fixture(scope="module")
def towel_scan(small_scan):
    garment = read_garment_file(GARMENTS / "towel.yaml")
    return ingest(small_scan, garment, size_m=(0.08, 4.0), point_count=1000, spacing_m=0.003, seed=1)


def test_support_is_registered_and_removed(towel_scan):
    found = separate(towel_scan.cloud, towel_scan.support, None)
    hit = (found.garment & towel_scan.truth_label).sum()
    assert hit / found.garment.sum() > 0.995  # precision
    assert (
        hit / towel_scan.truth_label.sum() > 0.99
    )  # recall; the vote of neighbours takes some corners of so coarse a scan
    assert found.support_rms_m < 0.4e-3


def test_without_registration_the_support_would_not_be_recognised(towel_scan):
    support = towel_scan.support
    points = towel_scan.cloud.points_m[~towel_scan.truth_label]
    unregistered = closest_points(points, support.vertices_m, support.faces)[2]
    _, registered = register(towel_scan.cloud.points_m.astype(float), support)
    assert np.median(unregistered) > 2e-3
    assert np.median(np.abs(registered[~towel_scan.truth_label])) < 2e-4


def test_a_manual_mask_is_obeyed(towel_scan):
    mask = towel_scan.cloud.points_m[:, 0] > 0
    np.testing.assert_array_equal(separate(towel_scan.cloud, towel_scan.support, mask).garment, mask)


def test_normals_seen_from_inside_are_turned_outwards():
    points, outward = tube_points()
    poses = np.stack(
        [
            look_at(np.array(eye), np.array([0, 0, 0.15]))
            for eye in ((1, 0, 0.2), (-1, 0.2, 0.2), (0, 1, 0.2), (0, -1, 0.2), (0.0, 0.01, 0.4))
        ]
    )
    view = np.argmax(outward @ (poses[:4, :3, 3] / np.linalg.norm(poses[:4, :3, 3], axis=1, keepdims=True)).T, axis=1)
    view[points[:, 2] > 0.24] = 4  # a view down into the tube: it sees the inside of a whole band
    normals, facts = oriented_normals(points, np.zeros_like(points), view, poses)
    assert ((normals * outward).sum(axis=1) > 0).all()
    assert facts["overruled"] == pytest.approx((view == 4).mean(), abs=0.02)


def test_normals_without_views_point_outwards():
    points, outward = tube_points()
    normals, facts = oriented_normals(points, np.zeros_like(points), np.full(len(points), -1), np.zeros((0, 4, 4)))
    assert ((normals * outward).sum(axis=1) > 0.9).mean() > 0.99
    assert facts["voting"] == 0.0


def test_openings_are_kept_and_occlusion_holes_closed():
    points, outward = tube_points(20_000)
    hole = (np.abs(points[:, 2] - 0.15) < 0.018) & (np.abs(np.arctan2(points[:, 1], points[:, 0])) < 0.25)
    points, outward = points[~hole], outward[~hole]
    closed = poisson(points, outward, 0.005)
    surface, gaps = cut_open(closed, points, openings=2, reach_m=0.012, edge_m=0.006)
    assert len(gaps) == 3
    surface = clean(surface, points, 0.003, 3)
    lengths = rim_lengths_m(surface.vertices_m, surface.faces)
    assert lengths == pytest.approx([2 * np.pi * 0.08] * 2, rel=0.03)
    # The closed hole lies on the tube, not across it.
    radius = np.linalg.norm(surface.vertices_m[:, :2], axis=1)
    assert np.abs(radius - 0.08).max() < 2e-3
    assert area_m2(surface.vertices_m, surface.faces) == pytest.approx(2 * np.pi * 0.08 * 0.30, rel=0.03)


def test_more_openings_than_gaps_are_refused():
    points, outward = tube_points()
    with pytest.raises(BadInput, match="2 gaps, but the garment file says openings: 4"):
        cut_open(poisson(points, outward, 0.006), points, openings=4, reach_m=0.012, edge_m=0.008)


def test_remeshing_leaves_no_slivers_and_keeps_the_openings():
    angle = np.linspace(0, 1, 40)[:, None]
    rough = loft(
        np.array([0, 0, 0.4]) * angle, np.array([0.1, 0, 0]) + 0 * angle, np.array([0, 0.06, 0]) + 0 * angle, 90
    )
    tube = Shape(
        vertices_m=rough.vertices_m[:-2], faces=rough.faces[(rough.faces < len(rough.vertices_m) - 2).all(axis=1)]
    )
    mesh = without_slivers(remesh(tube, 0.025), tube, np.radians(18))
    assert np.degrees(corner_angles_rad(mesh.vertices_m, mesh.faces).min()) >= 15
    assert len(rim_lengths_m(mesh.vertices_m, mesh.faces)) == 2
    assert len(np.unique(mesh.faces)) == len(mesh.vertices_m)


def test_fitting_takes_out_the_bias_of_chords():
    angle = np.linspace(0, 1, 60)[:, None]
    rough = loft(
        np.array([0, 0, 0.4]) * angle, np.array([0.1, 0, 0]) + 0 * angle, np.array([0, 0.1, 0]) + 0 * angle, 120
    )
    keep = (rough.faces < len(rough.vertices_m) - 2).all(axis=1)
    tube = Shape(vertices_m=rough.vertices_m[:-2], faces=rough.faces[keep])
    mesh = without_slivers(remesh(tube, 0.05), tube, np.radians(18))
    fit = fitted(mesh, tube, np.radians(15))
    inward, even = (np.mean(closest_points(tube.vertices_m, m.vertices_m, m.faces)[2]) for m in (mesh, fit))
    assert even < 0.6 * inward
    assert np.degrees(corner_angles_rad(fit.vertices_m, fit.faces).min()) >= 15


def test_a_bent_sheet_is_laid_flat_with_its_lengths():
    x, y = np.meshgrid(np.linspace(-0.2, 0.2, 21), np.linspace(-0.15, 0.15, 16), indexing="ij")
    sheet = slab(x, y, 0.3, 0.0)
    rest = rest_shape(sheet.vertices_m, sheet.faces)
    assert rest.flat
    assert rest.stretch_rms < 1e-3
    size = np.linalg.svd(rest.rest_m - rest.rest_m.mean(axis=0), compute_uv=False)
    assert size[2] < 1e-9
    assert area_m2(rest.rest_m, sheet.faces) == pytest.approx(0.12, rel=2e-3)


def test_a_dome_keeps_its_scanned_shape():
    x, y = np.meshgrid(np.linspace(-0.2, 0.2, 21), np.linspace(-0.2, 0.2, 21), indexing="ij")
    sheet = slab(x, y, 10.0, 0.0)
    dome = sheet.vertices_m.copy()
    dome[:, 2] = np.sqrt(0.4**2 - dome[:, 0] ** 2 - dome[:, 1] ** 2)
    rest = rest_shape(dome, sheet.faces)
    assert not rest.flat
    assert rest.stretch_rms > 0.005
    np.testing.assert_array_equal(rest.rest_m, dome)


def test_board_is_closed_and_faces_outwards():
    shape = board((0.5, 0.4), 0.02, 0.9)
    corners = shape.vertices_m[shape.faces]
    assert len(rim_edges(shape.faces)) == 0
    volume = (corners[:, 0] * np.cross(corners[:, 1], corners[:, 2])).sum() / 6
    assert volume == pytest.approx(0.5 * 0.4 * 0.02, rel=0.02)


def test_shipped_scans_read(tmp_path):
    for path in sorted(GARMENTS.glob("*.yaml")):
        garment = read_garment_file(path)
        size = sum(file.stat().st_size for file in (SCANS / path.stem).iterdir())
        assert size < 2.5e6, path.stem
        scan = ingest(SCANS / path.stem, garment, size_m=(0.08, 4.0), point_count=1000, spacing_m=0.003, seed=1)
        assert scan.truth is not None
        assert 0.4 < scan.truth_label.mean() < 0.95
        assert len(rim_lengths_m(scan.truth.vertices_m.astype(float), scan.truth.faces)) == garment.openings, path.stem


def test_scan_artifact_reads_back(small_scan, ingest_plain):
    scan = read_scan(ingest_plain(small_scan, GARMENTS / "towel.yaml"))
    assert len(scan.scanner_to_world) == 7
    assert scan.truth_label.shape == (len(scan.cloud),)
