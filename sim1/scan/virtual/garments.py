"""The project's virtual garments: true shape, support, colours, and the poses of the scanner."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from sim1.scan.cloud import Shape
from sim1.scan.virtual.bodies import bend, board, slab


@dataclass(frozen=True, kw_only=True)
class Staged:
    """A garment on its support, ready to be scanned."""

    garment: Shape
    support: Shape
    color: Callable[[np.ndarray], np.ndarray]  # points (n, 3) m of the garment -> RGB (n, 3) 0..255
    support_rgb: tuple[int, int, int]
    eyes: np.ndarray  # (v, 3) m, where the scanner stands
    targets: np.ndarray  # (v, 3) m, what it looks at
    cell_m: float  # point distance of the fused scan


def towel() -> Staged:
    """Hand towel, 0.40 x 0.30 m, on a slightly bent rack board; dented by the weave's folds, so not quite a cylinder."""
    radius, lift = 0.9, 0.003  # the towel lies 3 mm above the board: 2 mm of fabric, 1 mm of air
    x, y = np.meshgrid(np.linspace(-0.20, 0.20, 129), np.linspace(-0.15, 0.15, 97), indexing="ij")
    sheet = slab(x, y, radius, 0.0)
    height = lift + 0.0006 * (1 + np.sin(40 * x + 12 * y)) + 0.0004 * (1 + np.sin(55 * y))
    garment = Shape(vertices_m=bend(x, y, height, radius).reshape(-1, 3), faces=sheet.faces)
    angles = np.arange(6) / 6 * 2 * np.pi
    eyes = np.concatenate(
        [np.stack([0.35 * np.cos(angles), 0.35 * np.sin(angles), 0.55 + 0 * angles], axis=1), [[0.02, 0.0, 0.7]]]
    )

    def color(points: np.ndarray) -> np.ndarray:
        along, across = np.abs(radius * np.arctan2(points[:, 0], radius + points[:, 2])), np.abs(points[:, 1])
        rgb = np.where((along * 1000 // 12 % 2 == 0)[:, None], (236, 238, 240), (214, 226, 238))
        rgb = np.where(((along > 0.150) & (along < 0.172))[:, None], (38, 84, 150), rgb)
        rgb = np.where(((along > 0.178) & (along < 0.184))[:, None], (206, 60, 52), rgb)
        return np.where(((along > 0.195) | (across > 0.145))[:, None], (190, 200, 214), rgb)

    return Staged(
        garment=garment,
        support=board((0.50, 0.40), 0.02, radius),
        color=color,
        support_rgb=(70, 66, 62),
        eyes=eyes,
        targets=np.zeros_like(eyes),
        cell_m=0.0016,
    )


def tshirt() -> Staged:
    """The shirt that the newton package ships (centimetres, y up), made smooth, on a torso with arms."""
    from sim1.scan.virtual.mannequin import dressed, shirt_mannequin
    from sim1.scan.virtual.newton_shirt import newton_shirt

    parts = shirt_mannequin()
    garment = dressed(newton_shirt(), parts, gap_m=0.003)

    def color(points: np.ndarray) -> np.ndarray:
        x, y, z = points.T
        rgb = np.where((z * 1000 // 30 % 2 == 0)[:, None], (32, 122, 128), (44, 146, 148))
        rgb = np.where(((np.abs(y) < 0.08) & (z > 1.12) & (z < 1.28) & (x > -0.05))[:, None], (240, 202, 70), rgb)
        print_hole = (y**2 + (z - 1.2) ** 2 < 0.05**2) & (x > -0.05)
        rgb = np.where(print_hole[:, None], (226, 86, 52), rgb)
        return np.where((z < 0.91)[:, None], (20, 80, 92), rgb)

    eyes, targets = around(centre=(-0.06, 0.0, 1.2), reach=0.85, below=4)
    return staged_on(parts, garment, color, eyes, targets, 0.0032)


def staged_on(
    parts: list[Shape], garment: Shape, color: Callable, eyes: np.ndarray, targets: np.ndarray, cell_m: float
) -> Staged:
    """A worn garment on a mannequin of several tubes."""
    from sim1.scan.virtual.bodies import joined

    return Staged(
        garment=garment,
        support=joined(*parts),
        color=color,
        support_rgb=(214, 186, 160),
        eyes=eyes,
        targets=targets,
        cell_m=cell_m,
    )


def around(centre: tuple[float, float, float], reach: float, below: int) -> tuple[np.ndarray, np.ndarray]:
    """Scanner positions and targets: a ring of 8 slightly above, a ring from below (few of them leave holes), 2 from above."""
    rings = []
    for count, height, phase in ((8, 0.25, 0.0), (below, -0.45, 0.4)):
        angle = np.arange(count) / count * 2 * np.pi + phase
        rings.append(np.stack([reach * np.cos(angle), reach * np.sin(angle), np.full(count, height)], axis=1))
    top = np.array([[0.35, 0.1, 0.75], [-0.35, -0.1, 0.75]])
    eyes = np.concatenate([*rings, top]) + centre
    return eyes, np.broadcast_to(centre, eyes.shape).copy()


def shorts() -> Staged:
    """Shorts of the project's own shape, on hips with legs."""
    from sim1.scan.virtual.shorts import hips, shorts_color, shorts_shape

    eyes, targets = around(centre=(0.0, 0.0, 0.82), reach=0.75, below=6)
    return staged_on(hips(), shorts_shape(), shorts_color, eyes, targets, 0.0032)


def polo() -> Staged:
    """Polo shirt of the project's own shape, on the mannequin of the T-shirt."""
    from sim1.scan.virtual.mannequin import shirt_mannequin
    from sim1.scan.virtual.polo import polo_color, polo_shape

    eyes, targets = around(centre=(-0.06, 0.0, 1.2), reach=0.85, below=4)
    return staged_on(shirt_mannequin(), polo_shape(), polo_color, eyes, targets, 0.0032)


GARMENTS: dict[str, Callable[[], Staged]] = {"towel": towel, "tshirt": tshirt, "shorts": shorts, "polo": polo}
