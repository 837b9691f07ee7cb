"""Figures that the paper publishes, in its own words for methods and shifts, to stand beside ours.

A figure that is not here the paper does not print: its curves (figure “Curves of performance versus data scale”) and the bars of
“In-domain and out-of-domain evaluation” are pictures without numbers, of which the text quotes a few.
"""

from collections.abc import Mapping

SOURCE = "Y. Zhou, H. Liu, X. Jiang, X. Shen et al., “SIM1: Physics-Aligned Simulator as Zero-Shot Data Scaler in Deformable Worlds”"
_PRINTED = f"Paper: {SOURCE}. Its success rates are of a real robot that folds a T-shirt, 30 trials each, by an image policy (π0.5); ours are of "
_BESIDE = " They stand side by side to show what was measured in the same form, not as the same quantity."
MEANT = f"{_PRINTED}a simulated cell and of a small policy that knows the garment's keypoints.{_BESIDE}"
MEANT_WITH_PICTURES = f"{_PRINTED}a simulated cell, and of the garments and the policy that are named here.{_BESIDE}"
TRIALS = 30  # "evaluated over 30 trials per configuration", section "Protocol and setup"

PASS_RATE, AVERAGE = "pass rate", "average"
SHIFTS = ("in-domain", "spatial", "texture", "lighting", "viewpoint")
FULL = "+ deformation-stable solver"
# Table "Ablation on designs": pass rate, success by shift, average, in percent; a dash there is missing here.
ABLATION: Mapping[str, Mapping[str, int]] = {
    "Baseline": {PASS_RATE: 0},
    "+ trajectory decomposition": {PASS_RATE: 65, **dict.fromkeys(SHIFTS, 0), AVERAGE: 0},
    "+ diffusion-based generation": {
        PASS_RATE: 38, "in-domain": 47, "spatial": 33, "texture": 60, "lighting": 20, "viewpoint": 7, AVERAGE: 33,
    },
    FULL: {PASS_RATE: 40, "in-domain": 67, "spatial": 93, "texture": 90, "lighting": 82, "viewpoint": 47, AVERAGE: 76},
}  # fmt: skip
# Section "Main experiment results": from 200 demonstrations each; which shifts the average is taken over is not said.
TELEOPERATED: Mapping[str, int] = {AVERAGE: 87}  # in the simulator
REAL: Mapping[str, int] = {AVERAGE: 97}
# Same section: success after generated trajectories minus that after real demonstrations, in percentage points.
GENERATED_OVER_REAL: Mapping[str, int] = {"spatial": 50, "texture": 13, "lighting": 47}
# Section "Scaling analysis": generated trajectories that are worth one real demonstration.
WORTH: Mapping[str, int] = {"in-domain": 15, "texture": 5}
# Table "Generalization performance on additional tasks", success in percent; the polo shirt without demonstrations of it.
TASKS: Mapping[str, int] = {"towel": 80, "shorts": 93, "polo": 93}
# Table "Comparison of data acquisition efficiency": trajectories a day, dollars a trajectory, relative cost.
COSTS: Mapping[str, tuple[float, float, float]] = {"real": (104, 2.71, 1.0), "simulation": (710, 0.10, 0.037)}
# Appendix "Cost-efficiency Analysis": dollars a day.
COST_PER_DAY: Mapping[str, int] = {"real": 282, "simulation": 71}
ZERO_SHOT = 90  # abstract, and contributions: percent, by π0.5 from generated trajectories alone
SOLVER_ADDS = (
    ABLATION[FULL][AVERAGE] - ABLATION["+ diffusion-based generation"][AVERAGE]
)  # printed there beside the average
