"""The triangles that the laboratory hands over: uneven as those of a scan, even where grips hold."""

import numpy as np
import pytest

from benchmarks.concealed.case import Case, plans
from benchmarks.concealed.film import grid_for
from benchmarks.concealed.markers import draw_markers
from benchmarks.concealed.mesh import SCATTER, draw_mesh

CASES = [Case((), "medium", seed) for seed in range(12)]


def drawn(case: Case):
    setting = case.setting()
    motions = [plan.motion for plan in plans(case, setting)]
    held = sorted({v for m in motions for block in m.blocks for v in block.vertices(setting.columns)})
    return setting, held, draw_mesh(setting, motions, case.stream("mesh"))


@pytest.mark.parametrize("case", CASES, ids=lambda case: str(case.seed))
def test_triangles_tile_the_sheet_and_none_is_a_sliver(case):
    setting, _, mesh = drawn(case)
    corner = mesh.uv_m[mesh.faces]
    area = 0.5 * np.linalg.det(corner[:, 1:] - corner[:, :1])
    assert area.sum() == pytest.approx(setting.cloth.size_u_m * setting.cloth.size_v_m, rel=1e-5)
    even = setting.cloth.size_u_m * setting.cloth.size_v_m / len(area)
    assert area.min() >= 0.2 * even * (1 - 1e-3)


@pytest.mark.parametrize("case", CASES, ids=lambda case: str(case.seed))
def test_what_grips_hold_lies_on_the_laboratorys_nodes_and_nearly_nothing_else_does(case):
    setting, held, mesh = drawn(case)
    grid = grid_for(setting)
    spacing = np.array([grid.du_m, grid.dv_m])
    off = np.abs(mesh.uv_m / spacing - np.round(mesh.uv_m / spacing))
    assert off[held].max() < 1e-3
    rest = np.setdiff1d(np.arange(len(mesh.uv_m)), held)
    column = rest % setting.columns
    inside = (column > 0) & (column < setting.columns - 1) & (rest >= setting.columns)
    inside &= rest < len(mesh.uv_m) - setting.columns
    away = np.linalg.norm(off[rest[inside]], axis=1)  # in spacings of the laboratory, of which SCATTER is two
    assert np.median(away) > SCATTER / 2
    assert (away < 0.02).mean() < 0.05


@pytest.mark.parametrize("case", CASES[:4], ids=lambda case: str(case.seed))
def test_anchors_say_where_the_markers_are(case):
    setting, _, mesh = drawn(case)
    markers = draw_markers(setting, grid_for(setting), case.stream("markers"))
    face, barycentric = mesh.anchors(markers.uv_m)
    assert barycentric.min() > -1e-9
    there = (mesh.uv_m[mesh.faces[face]] * barycentric[:, :, None]).sum(axis=1)
    assert there == pytest.approx(markers.uv_m, abs=1e-9)


def test_every_motion_leaves_vertices_to_scatter():
    for case in CASES:
        _, held, mesh = drawn(case)
        assert len(set(held)) < 0.6 * len(mesh.uv_m)
