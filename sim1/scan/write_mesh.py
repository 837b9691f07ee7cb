"""Makes a `garment_mesh` artifact: builds the mesh, bakes its texture, measures it, draws it, writes it."""

import json
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from sim1.scan.accuracy import deviations
from sim1.scan.build import Built, build
from sim1.scan.cloud import Scan, read_scan
from sim1.scan.mesh_pictures import draw_errors, draw_preview, draw_separation
from sim1.scan.remesh import area_m2, corner_angles_rad
from sim1.scan.rims import rim_lengths_m
from sim1.scan.texture import bake, write_textured_obj
from sim1.stage import BadInput, Facts, random_stream

if TYPE_CHECKING:
    from sim1.scan.stage import GarmentMeshConfig


def make_garment_mesh(scan_folder: Path, out: Path, config: "GarmentMeshConfig", garment: str) -> Facts:
    """Write the artifact into `out`; returns the facts for its reader.

    Raises:
        BadInput: the scan is damaged, or no mesh can be made of it (`build`).
    """
    scan = read_scan(scan_folder)
    about = json.loads((scan_folder / "garment.json").read_text())
    try:
        built = build(
            scan,
            openings=about["openings"],
            edge_m=config.edge_m,
            vertex_count=config.vertex_count,
            cell_m=config.cell_m,
            gap_spacings=config.gap_spacings,
            taubin_steps=config.taubin_steps,
            angle_rad=float(np.radians(config.angle_deg)),
        )
    except BadInput as error:
        made_from = f"data/scans/{garment}, data/garments/{garment}.yaml"  # what a person can change
        raise BadInput(f"{scan_folder} ({made_from}): {error}") from error
    mesh = built.mesh
    texture = bake(
        mesh.vertices_m.astype(float), mesh.faces, built.cloud.points_m, built.cloud.colors, config.texture_pixels
    )
    write_textured_obj(out, about["title"], mesh.vertices_m, mesh.faces, texture)
    np.savez(
        out / "mesh.npz",
        vertices_m=mesh.vertices_m,
        faces=mesh.faces.astype(np.int32),
        uv=texture.uv,
        rest_m=built.rest.rest_m.astype(np.float32),
    )
    figures, distance = _figures(scan, built, about, random_stream(config.seed, garment, "accuracy"))
    (out / "accuracy.json").write_text(json.dumps(figures, indent=1, sort_keys=True) + "\n")
    kind = "virtual scan" if about["virtual"] else "scan"
    before, after = (figures[name]["points_to_mesh"]["rms_mm"] for name in ("before_remeshing", "after_remeshing"))
    draw_preview(mesh, f"{about['title']} ({kind}): simulation mesh, {len(mesh.vertices_m)} vertices", out / "mesh.png")
    title = f"{about['title']} ({kind}): error before remeshing, RMS {before:.2f} mm (after it {after:.2f} mm)"
    draw_errors(mesh, built.cloud.points_m, built.normals, distance, title, out / "error_map.png")
    title = f"{about['title']} ({kind}): from points to mesh"
    draw_separation(scan.cloud.points_m, built.separation.garment, mesh, title, out / "separation.png")
    return _facts(figures)


def _figures(scan: Scan, built: Built, about: dict, rng: np.random.Generator) -> tuple[dict, np.ndarray]:
    points = built.cloud.points_m.astype(float)
    before, distance = deviations(built.surface, points, built.normals, scan.truth, rng)
    after, _ = deviations(built.mesh, points, built.normals, scan.truth, rng)
    vertices, faces = built.mesh.vertices_m.astype(float), built.mesh.faces
    angles = np.degrees(corner_angles_rad(vertices, faces))
    edges = np.linalg.norm(vertices[faces] - vertices[np.roll(faces, 1, axis=1)], axis=2)
    separation: dict = {"method": built.separation.method, "garment_points": len(points), "all_points": len(scan.cloud)}
    if built.separation.support_rms_m is not None:
        separation["support_rms_mm"] = round(built.separation.support_rms_m * 1e3, 4)
    if scan.truth_label is not None:
        hit = float((built.separation.garment & scan.truth_label).sum())
        separation["precision"] = round(hit / float(built.separation.garment.sum()), 6)
        separation["recall"] = round(hit / float(scan.truth_label.sum()), 6)
    figures = {
        "virtual": about["virtual"],
        "openings_expected": about["openings"],
        "openings_m": [round(value, 4) for value in rim_lengths_m(vertices, faces)],
        "gaps_of_the_scan_m": [round(value, 4) for value in built.gaps_m],
        "holes_closed": len(built.gaps_m) - about["openings"],
        "vertices": len(vertices),
        "faces": len(faces),
        "area_m2": round(area_m2(vertices, faces), 5),
        "area_before_remeshing_m2": round(area_m2(built.surface.vertices_m, built.surface.faces), 5),
        "edge_target_m": round(built.edge_m, 5),
        "edge_mean_m": round(float(edges.mean()), 5),
        "minimum_angle_deg": round(float(angles.min()), 2),
        "median_smallest_angle_deg": round(float(np.median(angles.min(axis=1))), 2),
        "before_remeshing": before,
        "after_remeshing": after,
        "separation": separation,
        "normals_from_viewpoint_overruled": round(built.orientation["overruled"], 6),
        "normals_agree": round(_agreement(built), 4),
        "rest_shape": {
            "flat": built.rest.flat,
            "why": "developable: laid flat"
            if built.rest.flat
            else "not developable: the scanned shape is taken as stress-free",
            "stretch_rms": None if built.rest.stretch_rms is None else round(built.rest.stretch_rms, 6),
        },
    }
    return figures, distance


def _agreement(built: Built) -> float:
    """Share of the mesh's faces whose normal agrees with that of the nearest scan point."""
    from scipy.spatial import cKDTree

    corners = built.mesh.vertices_m[built.mesh.faces].astype(float)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    _, near = cKDTree(built.cloud.points_m).query(corners.mean(axis=1))
    return float(((normal * built.normals[near]).sum(axis=1) > 0).mean())


def _facts(figures: dict) -> Facts:
    before, after = figures["before_remeshing"], figures["after_remeshing"]
    facts: Facts = {
        "origin": "virtual scan" if figures["virtual"] else "scan of the user",
        "vertices": figures["vertices"],
        "faces": figures["faces"],
        "area_m2": figures["area_m2"],
        "separation": figures["separation"]["method"],
        "points_left_out": figures["separation"]["all_points"] - figures["separation"]["garment_points"],
        "openings": len(figures["openings_m"]),
        "holes_closed": figures["holes_closed"],
        "minimum_angle_deg": figures["minimum_angle_deg"],
        "points_rms_before_remeshing_mm": before["points_to_mesh"]["rms_mm"],
        "points_rms_after_remeshing_mm": after["points_to_mesh"]["rms_mm"],
        "rest_shape": figures["rest_shape"]["why"],
    }
    if "mesh_to_truth" in before:
        facts["truth_rms_before_remeshing_mm"] = before["mesh_to_truth"]["rms_mm"]
        facts["truth_rms_after_remeshing_mm"] = after["mesh_to_truth"]["rms_mm"]
    return facts
