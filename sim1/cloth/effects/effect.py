"""What an effect is to the solver."""

from dataclasses import dataclass, fields
from typing import Any, ClassVar

from sim1.stage import BadInput


@dataclass(frozen=True, kw_only=True)
class Effect:
    """One physical effect; subclasses add parameters and one or both of the hooks."""

    name: ClassVar[str]
    signature: ClassVar[str]  # how it shows in a recording, one line for reports
    source: ClassVar[str]  # of the formula

    def shape(self, solver: Any) -> None:
        """Change the arrays of `solver.sheet`, once, when the solver is made or the model changed."""

    def push(self, solver: Any, dt: float) -> None:
        """Add to `solver.now.force` and `solver.now.slope`, in every step, before the sweeps."""


def effect_of(entry: dict[str, Any], known: dict[str, type[Effect]]) -> Effect:
    """One `{name, parameters: {p: {value, ci95, unit}}}` entry as an effect.

    Raises:
        BadInput: unknown name or parameter, missing parameter, or a value that is not allowed.
    """
    name = entry.get("name")
    if name not in known:
        raise BadInput(f"effects: {name!r} is not an effect that the simulation knows; known: {sorted(known)}")
    kind = known[name]
    given = {key: item["value"] for key, item in (entry.get("parameters") or {}).items()}
    allowed = {field.name for field in fields(kind)}
    if set(given) - allowed:
        raise BadInput(
            f"effects: {name} has unknown parameters {sorted(set(given) - allowed)}, allowed: {sorted(allowed)}"
        )
    try:
        return kind(**given)
    except (TypeError, ValueError) as error:
        raise BadInput(f"effects: {name}: {error}") from error
