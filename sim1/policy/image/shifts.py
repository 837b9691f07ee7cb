"""Looks of the cell that differ from one seen in training in one thing alone (paper, section 4.1: shifts)."""

from dataclasses import replace

from sim1.render.appearance import Appearance
from sim1.render.looks.draw import Chance, Looks, draw_appearance

IN_DOMAIN = "in_domain"
TITLES = {  # shift -> what a person calls it; in the order in which views are rendered
    IN_DOMAIN: "a look of training",
    "lighting": "other lighting",
    "viewpoint_down": "head camera lower",
    "viewpoint_up": "head camera higher",
    "texture": "other fabric and table",
}
_LIGHT = ("lamps", "glows")
_TEXTURE = ("fabric", "table")  # a fabric is drawn together with a table that it stands out from


def shifted_looks(trained: Appearance, chance: Chance, looks: Looks, viewpoint_rad: float) -> dict[str, Appearance]:
    """The look itself, and with one thing changed each: light, elevation of the head camera, fabric and table.

    What is new is drawn from the distribution that training looks are drawn from, with a made-up fabric.

    Args:
        trained: a look that the policy was trained on.
        chance: source of randomness of the new things.
        looks: what they are drawn from.
        viewpoint_rad: turn of the head camera about the table's middle, downwards and upwards.
    """
    grey = (0.5, 0.5, 0.5)  # of a scanned texture, which is never drawn here
    other = draw_appearance(chance, looks, scanned=grey, scanned_share=0.0, elevation_jitter_rad=0.0)
    changes = {
        "lighting": {"room": replace(trained.room, **{name: getattr(other.room, name) for name in _LIGHT})},
        "viewpoint_down": {"elevation_offset_rad": trained.elevation_offset_rad - viewpoint_rad},
        "viewpoint_up": {"elevation_offset_rad": trained.elevation_offset_rad + viewpoint_rad},
        "texture": {name: getattr(other, name) for name in _TEXTURE},
    }
    return {shift: replace(trained, **changes.get(shift, {})) for shift in TITLES}
