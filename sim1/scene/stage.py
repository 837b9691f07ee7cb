"""Stage `scene`: two arms, a table, cameras and the garment in one metric frame. Paper: robot and environment."""

import json
from pathlib import Path

from sim1.progress import report
from sim1.stage import BadInput, Facts, Finding, Inputs, garment_of, only, stage_config


@stage_config
class SceneConfig:
    """Which table, and how the garment lies on it."""

    table: str = "workbench"  # of data/environment/tables.yaml
    gap_m: float = 0.003  # garment above the table top; more than the thickness of a fabric, less than it would bounce
    grasp_height_m: float = 0.01  # of the finger tips when they take hold of cloth on the table
    largest_tilt_deg: float = 45.0  # leaning of the tool at which it still grasps from above
    smallest_reached_share: float = 0.9  # of the garment's points, by at least one arm


def scene(inputs: Inputs, out: Path, config: SceneConfig) -> Facts:
    """Put robot, table, cameras and garment together, as `scene.json` and as USD.

    Raises:
        BadInput: see `place_arms`, `read_table`, `read_cameras`, `read_garment`, `lying_pose`; a camera names an unknown
            link; the home posture is beyond the joint limits.
    """
    from sim1.scene.assemble import assemble
    from sim1.scene.parts import TABLE_RGB, arm_parts, solid
    from sim1.scene.picture import draw_reach, draw_scene
    from sim1.scene.reach import reach_of, work_region
    from sim1.scene.usd import write_usd

    report(0, 3, "assembling")
    name = garment_of(inputs)
    made = assemble(only(inputs, "garment_mesh"), only(inputs, "robot"), only(inputs, "environment"), out, config)
    lying = made.scene.place_garment(made.garment_m)
    parts = [
        solid("table", made.table.vertices, made.table.faces, TABLE_RGB),
        *arm_parts(made.scene, made.arm),
        solid("garment", made.garment_m, made.garment_faces, made.garment_rgb, made.scene.garment_place),
    ]
    report(1, 3, "writing USD")
    write_usd(out / "scene.usda", made.scene, parts)
    report(2, 3, "reach and pictures")
    grasped = lying.copy()
    grasped[:, 2] = made.scene.table_top_m + config.grasp_height_m
    garment_reach = reach_of(grasped, made.scene, made.planar)
    region = reach_of(work_region(made.scene), made.scene, made.planar)
    draw_scene(out / "scene.png", made.scene, parts, f"Scene: {name} on {config.table}")
    draw_reach(out / "reach.png", made.scene, made.planar, lying, config.grasp_height_m)
    measured = {
        "table_tolerance_m": made.table_tolerance_m,
        "grasp_height_m": config.grasp_height_m,
        "largest_tilt_deg": config.largest_tilt_deg,
        "smallest_reached_share": config.smallest_reached_share,
        "calibration_virtual": made.placement.virtual,
        "calibration_between_arms_rms_mm": made.placement.between_arms_rms_mm,
        "calibration_to_world_rms_mm": made.placement.to_world_rms_mm,
        "calibration_largest_residual_mm": made.arms.largest_residual_mm,
    }
    (out / "measured.json").write_text(json.dumps(measured, indent=1, sort_keys=True) + "\n")
    return {
        "table": config.table,
        "table_size_m": [float(value) for value in made.scene.table_size_m],
        "garment_size_lying_m": [round(float(value), 4) for value in lying.max(axis=0) - lying.min(axis=0)],
        "garment_reached_share": round(garment_reach.share(config.largest_tilt_deg), 4),
        "garment_reached_straight_down_share": round(garment_reach.share(0), 4),
        "arm_stretched_length_m": round(made.planar.stretched_m, 4),
        "work_region_straight_down_share": round(region.share(0), 4),
        f"work_region_leaning_{config.largest_tilt_deg:.0f}_deg_share": round(region.share(config.largest_tilt_deg), 4),
        "calibration": "virtual (model of touching marks)" if made.placement.virtual else "measured",
        "calibration_marks": made.placement.mark_count,
        "calibration_between_arms_rms_mm": round(made.placement.between_arms_rms_mm, 3),
        "calibration_to_world_rms_mm": round(made.placement.to_world_rms_mm, 3),
    }


def check_scene(artifact: Path) -> list[Finding]:
    """Does the scene hold together: sizes, limits, placement, reach, calibration, USD?"""
    try:
        from sim1.scene.check import findings

        return findings(artifact)
    except (BadInput, OSError, LookupError, ValueError) as error:
        return [Finding(name="scene_readable", passed=False, detail=str(error))]
