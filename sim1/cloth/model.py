"""The cell as a newton model: cloth, table and gripper bodies, their contact material, and the solver."""

from typing import Any

import numpy as np

from sim1.cloth.config import GRAVITY_M_S2, PATH_SHARE, CellConfig
from sim1.cloth.garment import GarmentMesh, unique_edges
from sim1.cloth.physics import ClothPhysics, membrane
from sim1.stage import BadInput

TABLE = 0  # number of the table's shape
CONTACT_GAP_M = 0.005  # solids are looked for this near


def build_model(
    garment: GarmentMesh, physics: ClothPhysics, config: CellConfig, table_size_m: tuple[float, float]
) -> Any:
    import newton
    import warp as wp

    builder = newton.ModelBuilder(gravity=(0.0, 0.0, -GRAVITY_M_S2))
    shape = newton.ModelBuilder.ShapeConfig
    solid = {"kd": config.contact_damping_n_s_m, "density": 0.0}
    table = shape(ke=config.table_stiffness_n_m, mu=physics.friction.table.value, margin=0.0, **solid)
    pad = shape(
        ke=config.robot_stiffness_n_m, mu=physics.friction.robot.value, margin=config.finger_rounding_m, **solid
    )
    half = 0.5 * np.asarray(table_size_m)
    deep = 0.1  # thicker than any table top: a vertex pressed in is always pushed out upwards
    builder.add_shape_box(  # the first shape: TABLE
        -1, xform=wp.transform((0.0, 0.0, -deep), wp.quat_identity()), hx=half[0], hy=half[1], hz=deep, cfg=table
    )
    inset = config.finger_rounding_m
    for arm in ("left", "right"):
        for part in ("palm", "finger_a", "finger_b"):
            body = builder.add_body(label=f"{arm}_{part}", is_kinematic=True, mass=1.0, inertia=wp.mat33(np.eye(3)))
            if part == "palm":
                middle, half = -config.finger_length_m - 0.02, (0.02, 0.055, 0.024)  # as in the URDF
            else:
                middle = -0.5 * config.finger_length_m
                half = (0.5 * config.finger_length_m, 0.5 * config.finger_thickness_m, 0.5 * config.finger_width_m)
            builder.add_shape_box(
                body,
                xform=wp.transform((middle, 0.0, 0.0), wp.quat_identity()),
                hx=half[0] - inset,
                hy=half[1] - inset,
                hz=half[2] - inset,
                cfg=pad,
                label=f"{arm}_{part}",
            )
    lame = membrane(physics)
    builder.add_cloth_mesh(
        vertices=[wp.vec3(*map(float, point)) for point in garment.rest_m],
        indices=garment.faces.reshape(-1).tolist(),
        pos=wp.vec3(0.0),
        rot=wp.quat_identity(),
        vel=wp.vec3(0.0),
        scale=1.0,
        density=physics.area_density_kg_m2.value,
        tri_ke=lame.mu_n_m,
        tri_ka=lame.lambda_n_m,
        tri_kd=lame.viscosity_n_s_m,
        edge_ke=1.0,
        edge_kd=0.0,
        particle_radius=config.contact_radius_m,
    )
    builder.color()
    model = builder.finalize()
    stiffness = hinge_stiffness(garment, model.edge_indices.numpy(), physics.bending_n_m.value)
    model.edge_bending_properties.assign(
        np.stack([stiffness, physics.damping_s.value * stiffness], axis=1).astype(np.float32)
    )
    return model


def hinge_stiffness(garment: GarmentMesh, edges: np.ndarray, bending_n_m: float) -> np.ndarray:
    """Stiffness per edge length [N] of the hinges (opposite, opposite, start, end) that make a plate of rigidity D.

    The solver's hinge energy is k L theta^2 / 2. A sheet of equilateral triangles of hinge stiffness k L has D = sqrt(3)/2 k L
    (Seung and Nelson 1988); written with the areas of the two faces that is k = D L / (A1 + A2), used for all meshes.
    """
    points = garment.rest_m
    first, second, start, end = (np.where(edges[:, i] < 0, edges[:, 2], edges[:, i]) for i in range(4))
    along = points[end] - points[start]
    area = 0.5 * np.linalg.norm(np.cross(along, points[first] - points[start]), axis=1)
    area += 0.5 * np.linalg.norm(np.cross(along, points[second] - points[start]), axis=1)
    return bending_n_m * np.linalg.norm(along, axis=1) / np.maximum(area, 1e-12)


def contacts_of(model: Any, physics: ClothPhysics, config: CellConfig) -> tuple[Any, Any]:
    """Detection of the cloth against solids: vertices against all; edges and faces against the fingers alone.

    As far as the cloth clings, if it does.

    A finger is narrower than the cloth's edges are long: with vertices alone it would slip through a triangle and stay
    hooked in it. The table is flat, vertices are enough there.
    """
    import newton
    import warp as wp

    from sim1.cloth.effects import acted_effects
    from sim1.cloth.effects.adhesion import Adhesion

    pipeline = newton.CollisionPipeline(
        model,
        soft_contact_gap=max(
            [CONTACT_GAP_M, *(e.reach for e in acted_effects(physics.effects) if isinstance(e, Adhesion))]
        ),
        include_static_kinematic_pairs=False,
        broad_phase="explicit",
        enable_rigid_soft_full_surface_contact=config.finger_surface_contact,
    )
    contacts = pipeline.contacts()
    if config.finger_surface_contact:
        fingers = [i for i, label in enumerate(model.shape_label) if "finger" in label]
        for name in ("soft_edge_rigid_pairs", "soft_face_rigid_pairs"):
            pairs = getattr(pipeline, name).numpy()
            kept = pairs[np.isin(pairs[:, 1], fingers)]
            setattr(pipeline, name, wp.array(kept, dtype=wp.vec2i, device=model.device))
    return pipeline, contacts


def solver_of(model: Any, garment: GarmentMesh, physics: ClothPhysics, config: CellConfig) -> Any:
    """The cloth solver of the cell: bodies are moved from outside and act on the cloth, not the reverse.

    Raises:
        BadInput: the generic solver is asked for physics that it cannot act.
    """
    from sim1.cloth.avbd import AVBDConfig, SelfContact, SolverAVBD
    from sim1.cloth.effects import acted_effects
    from sim1.cloth.generic import GenericCloth

    edges = unique_edges(garment.faces)
    shortest = float(np.linalg.norm(garment.rest_m[edges[:, 0]] - garment.rest_m[edges[:, 1]], axis=1).min())
    rest_exclusion_m = min(2.0 * config.self_margin_m, 0.9 * shortest)
    if config.solver == "vbd":
        if physics.effects:
            raise BadInput(
                f"cell: solver vbd acts no named physics, and the fabric has {', '.join(str(e['name']) for e in physics.effects)}; "
                "simulate with the baseline (stage calibrated_physics, simulate_with: baseline), or with solver avbd"
            )
        return GenericCloth(model, config, physics.friction.self.value, rest_exclusion_m)
    layers = None
    if config.self_contact:
        layers = SelfContact(
            radius_m=config.self_margin_m,
            search_m=config.self_search_m,
            rest_exclusion_m=rest_exclusion_m,
            stiffness_n_m=config.self_stiffness_n_m,
            damping_n_s_m=0.0,
            friction=physics.friction.self.value,
            share=PATH_SHARE,
        )
    return SolverAVBD(
        model,
        AVBDConfig(
            iterations=config.iterations,
            max_strain=config.max_strain,
            compression_share=config.compression_share,
            friction_speed_m_s=config.friction_speed_m_s,
            self_contact=layers,
        ),
        effects=acted_effects(physics.effects),
        table=TABLE,
    )
