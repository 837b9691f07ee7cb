"""`proof.html`: a proof for a person who doubts it; one file that needs no other."""

from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from sim1.proof.proof import Proof
from sim1.proof.totals import NAMELESS, Share, Totals
from sim1.whole_file import whole_file


def write_page(path: Path, proof: Proof) -> None:
    """Write the page; links lead to the cases' own reports beside it."""
    loader = FileSystemLoader(Path(__file__).parent)
    surroundings = Environment(loader=loader, autoescape=True, undefined=StrictUndefined)
    surroundings.filters["share"] = said
    shades = [_shades(row) for row in proof.confusion.counts]
    template = surroundings.get_template("proof.html.jinja")
    with whole_file(path) as part:
        part.write_text(template.render(proof=proof, shades=shades, nameless=NAMELESS), encoding="utf-8")


def said(share: Share) -> str:
    """A share as people read it: `3 of 10 (95 % interval 7 to 65 %)`."""
    if not share.of:
        return "none tried"
    if share.low is None or share.high is None:
        return f"{share.count} of {share.of}"
    return f"{share.count} of {share.of} (95 % interval {100 * share.low:.0f} to {100 * share.high:.0f} %)"


def by_strength(totals: Totals) -> list[str]:
    """Single effects by their strength, lines for a person who reads a terminal; none of a strength that was not tried."""
    return [
        f"  one effect, {name}: named right {said(of.named)}; first in the ranking {said(of.first_ranked)}; called none {of.called_none}, "
        f"unknown or ambiguous {of.called_unknown}, a wrong name {of.wrong_name}, failed {of.failed}"
        for name, of in totals.by_strength.items()
        if of.named.of
    ]


def _shades(row: tuple[int, ...]) -> list[float]:
    """Opacity of each cell, by its share of the row."""
    most = max(sum(row), 1)
    return [round(0.75 * count / most, 3) for count in row]
