"""What many diagnoses come to, in Markdown."""

import numpy as np

from benchmarks.diagnosis.trial import Number, Trial


def tables(trials: list[Trial]) -> str:
    """A line for every case, and what they come to together."""
    lines = [
        "| concealed | vertices | places | verdict | found | nats | runner-up | held out [mm] | misfit | place AUC | s | simulating |",
        "| --- " * 12 + "|",
        *(_line(trial) for trial in sorted(trials, key=lambda trial: (trial.concealed, trial.case))),
        "",
        *_together(trials),
    ]
    return "\n".join(lines)


def _line(trial: Trial) -> str:
    ranked = sorted(trial.gains.items(), key=lambda item: -item[1])
    found = " + ".join(trial.named)
    best = trial.gains.get(found, ranked[0][1] if ranked else 0.0)
    runner = next((f"{name} {gain:.0f}" for name, gain in ranked if name != found and len(name.split(" + ")) == 1), "-")
    before, after = trial.heldout_mm
    numbers = "; ".join(
        f"{name} {n.value:.4g} [{n.low:.4g}, {n.high:.4g}]" + (f" (true {n.true:.4g})" if n.true is not None else "")
        for parameters in trial.effects.values()
        for name, n in parameters.items()
    )
    verdict = trial.verdict if trial.right else f"**{trial.verdict}**"
    place = "-" if trial.place_auc is None else f"{trial.place_auc:.2f}"
    return (
        f"| {trial.case} | {trial.vertices} | {'given' if trial.places_given else 'unknown'} | {verdict} | {found or '-'} {numbers} | {best:.0f} | "
        f"{runner} | {before:.2f} -> {after:.2f} | {trial.misfit[0]:.2f} -> {trial.misfit[1]:.2f} | {place} | {trial.seconds:.0f} | "
        f"{100 * trial.simulating_s / trial.seconds:.0f} % |"
    )


def _together(trials: list[Trial]) -> list[str]:
    nulls, missing = [t for t in trials if not t.concealed], [t for t in trials if t.concealed]
    effects = [n for t in missing for p in t.effects.values() for n in p.values() if n.true is not None]
    places = [t.place_auc for t in missing if t.place_auc is not None]
    fabric = [n for t in trials for n in t.baseline.values()]
    off = [abs(n.value / n.true - 1.0) for n in effects if n.true]
    said = [
        f"* {sum(t.right for t in nulls)} of {len(nulls)} cases with nothing missing were called `none`.",
        f"* {sum(t.right for t in missing)} of {len(missing)} cases with something missing were named right and alone, or called unknown where no name fits.",
        f"* Coefficients of effects: {_share(effects)}; median error {100 * np.median(off):.0f} %." if off else "",
        f"* Parameters of the fabric: {_share(fabric)}.",
        f"* Place of local effects: median AUC {np.median(places):.2f}, least {min(places):.2f}." if places else "",
        f"* Median time {np.median([t.seconds for t in trials]):.0f} s, longest {max(t.seconds for t in trials):.0f} s.",
    ]
    return [line for line in said if line]


def _share(numbers: list[Number]) -> str:
    inside = sum(n.low <= n.true <= n.high for n in numbers)
    return f"{inside} of {len(numbers)} inside their 95 % intervals"
