"""`report.html`: a diagnosis for a person who has ten minutes, put together from its small files."""

import base64
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from sim1.cloth.effects import EFFECTS
from sim1.mismatch.summary import Summary
from sim1.mismatch.verdict import Verdict, in_mm

CAPTIONS = {  # pictures of a diagnosis, in their order on the page
    "forces.png": "Where and when: the force that the baseline lacks",
    "heldout_error.png": "Held-out motion",
    "key_frames.png": "Measured and simulated",
}


def write_page(path: Path, verdict: Verdict, summary: Summary, pictures: Path, *, stand_in: bool = False) -> None:
    """Write the page, pictures inside; `pictures` is the folder of `CAPTIONS`' files, `stand_in` says that no real cloth was recorded."""
    images = [
        (base64.b64encode((pictures / name).read_bytes()).decode(), caption) for name, caption in CAPTIONS.items()
    ]
    loader = FileSystemLoader(Path(__file__).parent)
    surroundings = Environment(loader=loader, autoescape=True, undefined=StrictUndefined)
    surroundings.filters |= {"in_mm": in_mm, "change": change}
    # What the verdict tells as published is not told again as it was searched.
    searched = {c.name for name in summary.effects for c in EFFECTS[name].coefficients}
    template = surroundings.get_template("diagnosis.html.jinja")
    path.write_text(
        template.render(
            verdict=verdict,
            summary=summary,
            images=images,
            effects=[EFFECTS[name] for name in summary.effects],
            baseline=[row for row in summary.estimates if row.name not in searched],
            stand_in=stand_in,
        )
    )


def change(reduction: float | None) -> str:
    """By what share of itself an error falls, as people read it."""
    if reduction is None:
        return "not known"
    return f"{'falls' if reduction >= 0.0 else 'rises'} by {100 * abs(reduction):.0f} %"
