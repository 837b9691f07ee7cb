"""What a lamp has to send out to light the table as brightly as it says."""

import numpy as np

from sim1.render.appearance import Lamp


def lamp_power_w(lamp: Lamp) -> float:
    """Power of a square area light at which a white sheet at the world's origin, facing up, has the radiance `lamp.level`.

    A square of power P that looks at a sheet lights it, at a distance d, by P cos / (pi d^2); a white sheet sends 1/pi of it on.
    """
    position = np.array(lamp.position_m)
    distance = np.linalg.norm(position)
    return float(lamp.level * np.pi**2 * distance**3 / position[2])
