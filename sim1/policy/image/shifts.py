"""Looks of the cell that differ from one seen in training in one thing alone (paper, section 4.1: shifts)."""

from dataclasses import replace

import numpy as np

from sim1.render.appearance import Appearance
from sim1.render.looks.draw import Chance, Looks, draw_appearance
from sim1.render.looks.rooms import light_of, lit_as
from sim1.stage import BadInput

IN_DOMAIN = "in_domain"
TITLES = {  # shift -> what a person calls it; in the order in which views are rendered
    IN_DOMAIN: "a look of training",
    "lighting": "other lighting",
    "viewpoint_down": "head camera lower",
    "viewpoint_up": "head camera higher",
    "texture": "other fabric and table",
}
_TEXTURE = ("fabric", "table")  # a fabric is drawn together with a table that it stands out from


def shifted_looks(
    trained: Appearance, chance: Chance, looks: Looks, *, viewpoint_rad: float, jitter_rad: float
) -> dict[str, Appearance]:
    """The look itself, and with one thing changed each: light, elevation of the head camera, fabric and table.

    Light, fabric and table are drawn from the distribution that training looks are drawn from: a light of another name, a made-up
    fabric. Viewpoints lie outside of all that training has seen: the head camera stands `viewpoint_rad` below the lowest and above
    the highest of them, whichever `trained` has.

    Args:
        trained: a look that the policy was trained on.
        chance: source of randomness of the new things.
        looks: what they are drawn from.
        viewpoint_rad: turn of the head camera about the table's middle, beyond what training has seen.
        jitter_rad: largest turn, either way from where the scene has the camera, that training has seen.

    Raises:
        BadInput: there is but one light, or no table that a fabric stands out from.
    """
    rooms = tuple(room for room in looks.rooms if light_of(room.name) != light_of(trained.room.name))
    if not rooms:
        raise BadInput(
            f"{looks.folder}/rooms.yaml: lights has {light_of(trained.room.name)!r} alone, in which the policy was trained; add "
            "another one, or set shifted_trajectories of image_policy and trial_count of image_trials to 0"
        )
    grey = np.full((1, 3), 0.5)  # of a scanned texture, which is never drawn here
    others = replace(looks, rooms=rooms)
    other = draw_appearance(chance, others, scanned=grey, scanned_share=0.0, elevation_jitter_rad=0.0)
    beyond_rad = jitter_rad + viewpoint_rad
    changes = {
        "lighting": {"room": lit_as(trained.room, other.room)},
        "viewpoint_down": {"elevation_offset_rad": -beyond_rad},
        "viewpoint_up": {"elevation_offset_rad": beyond_rad},
        "texture": {name: getattr(other, name) for name in _TEXTURE},
    }
    return {shift: replace(trained, **changes.get(shift, {})) for shift in TITLES}
