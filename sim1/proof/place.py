"""How well a located force lies where the concealed one acts."""

from collections.abc import Mapping

import numpy as np
from scipy.interpolate import interp1d
from sklearn.metrics import roc_auc_score

from sim1.mismatch.forces_file import ForceCourses

ACTS = 0.1  # of the largest force per area: from there on something acts
NOTHING_N_M2 = (
    1e-6  # what a laboratory's rounding leaves where nothing acts: no force, though some markers have more of it
)
LOCAL = 0.002, 0.5  # shares of markers and frames between which an effect is called local


def place_auc(forces: ForceCourses, answers: Mapping[str, np.ndarray]) -> float | None:
    """Area under the ROC curve: size of the located force at markers and frames, against `ACTS` of the largest concealed one.

    `answers` holds `NAME/stamps_s` (F,) and `NAME/missing_n_m2` (F, M). None: force was concealed nowhere or everywhere.
    """
    sizes, concealed = [], []
    for name, (time_s, force_n) in forces.items():
        size = np.linalg.norm(force_n, axis=-1)
        course = interp1d(time_s, size, axis=0, bounds_error=False, fill_value=(size[0], size[-1]))
        sizes.append(course(answers[f"{name}/stamps_s"]))
        concealed.append(answers[f"{name}/missing_n_m2"])
    most = max((float(part.max()) for part in concealed), default=0.0)
    if most < NOTHING_N_M2:
        return None
    acts = np.concatenate([part.ravel() > ACTS * most for part in concealed])
    if not LOCAL[0] < acts.mean() < LOCAL[1]:
        return None
    return float(roc_auc_score(acts, np.concatenate([part.ravel() for part in sizes])))
