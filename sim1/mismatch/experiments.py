"""Which recording would settle what a verdict leaves open, or put a name to the test that others can imitate."""

from sim1.mismatch.diagnose import Diagnosis
from sim1.mismatch.ranked import joined
from sim1.mismatch.thresholds import THRESHOLDS

SEPARATING = {  # the recording that tells two explanations apart
    frozenset(
        ("air_drag", "added_mass")
    ): "swing at two amplitudes with the same period: drag grows with the square of the speed, carried air with the acceleration",
    frozenset(
        ("air_drag", "wind")
    ): "hang the cloth still, then turn the rig by 90 degrees: a stream pushes at rest too",
    frozenset(
        ("clock_offset", "actuator_lag")
    ): "stop suddenly and let the cloth swing free for 2 s: an offset shifts the free swing, a lag does not",
    frozenset(("grip_slip", "grip_compliance")): "pull and let go: what slipped does not come back",
    frozenset(
        ("frame_offset", "gravity_tilt")
    ): "turn the rig by 180 degrees about the vertical at rest: a tilt turns with the room, an offset with the camera",
    frozenset(
        ("stiff_region", "heavy_region")
    ): "swing slowly and fast: weight shows at rest, stiffness where the cloth folds",
}
TESTING = {  # a name that physics outside of the table was taken for, and the recording that would show it
    "gravity_tilt": "hang a plumb line beside the rig: a tilt pulls it, too, a static charge or a magnet does not",
    "heavy_region": "weigh the cloth, and film the same motion again an hour later: water dries, a weight stays",
    "plastic_crease": "lay the cloth flat, and film the same motion again an hour later: a crease stays, creep comes back",
    "wind": "film the same motion with the rig half a metre aside: a stream is the same there, a jet is not",
}


def next_experiment(found: Diagnosis) -> str:
    """One sentence: what to record next."""
    if found.stopped:
        return "the search was stopped before all was tried: diagnose again with more time"
    names = list(found.chosen.terms) + [name for rival in found.rivals for name in rival.terms]
    for one in names:
        for other in names:
            if frozenset((one, other)) in SEPARATING:
                return SEPARATING[frozenset((one, other))]
    if found.verdict == "unknown" or found.misfit["chosen"] > THRESHOLDS.misfit:
        return "repeat the worst motion slower, and once held still after it: what vanishes tells speed from stiffness and slip"
    if found.verdict == "ambiguous":
        return f"repeat the motion in which {joined(found.chosen)} and {joined(found.rivals[0])} differ most, at another speed"
    tests = [TESTING[name] for name in found.chosen.terms if name in TESTING]
    return f"none needed; to be sure, {tests[0]}" if tests else "none needed for this difference"
