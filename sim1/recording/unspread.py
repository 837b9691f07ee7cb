"""Priors of which a bundle does not say how sure one is: what a diagnosis takes as exact, and what it assumes."""

from sim1.recording.bundle import Bundle

POISSON_STD = 0.1  # where the bundle states none: woven cloth lies between 0 and 0.5
UNITS = {"area_density_kg_m2": "kg/m^2", "stretch_n_m": "N/m", "bending_n_m": "N m", "damping_s": "s"}


def taken_as_exact(bundle: Bundle) -> str | None:
    """What no search varies, as no spread of it is stated, in one sentence; None: nothing."""
    frozen = [
        f"garment.prior.{name} ({prior.value:g} {unit})"
        for name, unit in UNITS.items()
        if (prior := getattr(bundle.prior, name)).log_spread is None
    ]
    table = bundle.environment.table
    if table is not None and table.friction.spread is None:
        frozen.append(f"environment.table.friction ({table.friction.value:g})")
    if not frozen:
        return None
    return f"bundle.yaml gives no spread to {', '.join(frozen)}: taken as exact and not calibrated"


def assumed(bundle: Bundle) -> str | None:
    """The spread that a search assumes, in one sentence; None: it is stated."""
    if bundle.prior.poisson.spread is not None:
        return None
    return f"bundle.yaml gives no spread to garment.prior.poisson ({bundle.prior.poisson.value:g}): {POISSON_STD:g} is assumed for its std"


def unspread(bundle: Bundle) -> list[str]:
    """All that has to be said of a bundle's priors without a spread."""
    return [said for said in (taken_as_exact(bundle), assumed(bundle)) if said]
