"""Numerics and contact of the simulated cell."""

from typing import Literal

from pydantic import Field

from sim1.stage import stage_config

FRAME_S = 1.0 / 30.0
GRAVITY_M_S2 = 9.81
PATH_SHARE = 0.42  # beta of the paper's appendix A: of the room to the next layer that a vertex may use in one go
BODIES_PER_ARM = 3  # palm and two fingers, in this order


@stage_config
class CellConfig:
    """Numerics and contact of the simulated cell."""

    solver: Literal["avbd", "vbd"] = (
        "avbd"  # vbd: newton's own, without strain limit and named physics, to compare with
    )
    substeps: int = Field(8, ge=2, multiple_of=2)  # per 1/30 s; even, so that the two states end where they began
    iterations: int = Field(5, ge=1)  # per substep
    finer_mesh: bool = (
        False  # every triangle cut in two or more, see `bisect.py`; who looks on sees the garment's own vertices
    )
    contact_radius_m: float = Field(0.002, gt=0)  # distance kept between the cloth's middle surface and solids
    max_strain: float = Field(0.05, gt=0)  # no edge gets longer than this share of its rest length
    compression_share: float = Field(
        0.02, gt=0, le=1
    )  # of compressive strain that makes stress: wrinkles below the mesh
    self_margin_m: float = Field(0.002, gt=0)  # distance kept between two layers
    self_search_m: float = Field(0.005, gt=0)  # detection looks this far around the expected motion
    self_contact: bool = True  # layers collide
    finger_surface_contact: bool = True  # fingers touch edges and faces of the cloth, not its vertices alone
    table_stiffness_n_m: float = 300.0  # penalty per vertex: sags 7 um under 0.2 g; stiffer makes friction too strong
    robot_stiffness_n_m: float = 1.5e3  # rubber pads: yield 1 mm at 1.5 N per vertex
    self_stiffness_n_m: float = 2.0e2  # gentle, layers are light
    contact_damping_n_s_m: float = 0.2  # per vertex, takes the bounce out of landings
    friction_speed_m_s: float = 5.0e-4  # sticking creeps below this speed (regularised Coulomb)
    closed_gap_m: float = Field(0.002, gt=0)  # left between closed pads: their rubber; holds the cloth by its yield
    finger_length_m: float = 0.060  # along the tool's x, ends at the tool's origin; as in the URDF
    finger_width_m: float = 0.022  # along the tool's z; as in the URDF
    finger_thickness_m: float = 0.010  # along the tool's y; as in the URDF
    finger_rounding_m: float = 0.0015  # edges of a pad are round
    far_limit_m: float = 50.0  # a vertex further than this from the origin means that the simulation broke
