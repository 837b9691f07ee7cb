"""The models of a diagnosis in their order, as `summary.json` lists them."""

from typing import Any

from sim1.mismatch.decide import rating, steady, there, worth_over
from sim1.mismatch.diagnose import Diagnosis
from sim1.mismatch.excess import mean_square
from sim1.mismatch.models import Model
from sim1.mismatch.thresholds import Thresholds
from sim1.mismatch.uncertainty import unsteadiness

TOLD = 10  # models


def ranked(found: Diagnosis, thresholds: Thresholds) -> list[dict[str, Any]]:
    """Rows of `summary.Ranked`, best first."""
    null, heard = found.baseline, {model.terms: model for model in found.heard}
    return [
        {
            "name": joined(model),
            "gain": rating(null, thresholds) - rating(model, thresholds),
            "worth": worth_over(null, model, thresholds),
            "unsteadiness": unsteadiness(model.fit, null.fit),
            "established": there(list(found.models), model, thresholds),
            "steady": steady(list(found.models), model, thresholds, found.measured),
            "misfit": mean_square(model.fit),
            **(
                _heard(heard[()], heard[model.terms], found, thresholds) if model.terms and model.terms in heard else {}
            ),
        }
        for model in found.models[:TOLD]
    ]


def joined(model: Model) -> str:
    """Names of a model's effects, for people."""
    return " with ".join(model.terms) or "the baseline"


def _heard(null: Model, model: Model, found: Diagnosis, thresholds: Thresholds) -> dict[str, Any]:
    """What a model is worth with motion held out, and whether it is steady by that."""
    return {
        "heard_worth": worth_over(null, model, thresholds),
        "heard_steady": steady(list(found.heard), model, thresholds, found.measured),
    }
