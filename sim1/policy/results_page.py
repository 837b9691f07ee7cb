"""What a whole run found, in sections of one page: curves, tables in the paper's form, film strips.

Each report keeps its own page with how it was measured; here stands what it found. What was not run is said to be missing.
"""

from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from sim1.policy import ablation_page, cost_page, paper, scaling_page
from sim1.policy.claims.page import READ, Plans, claims_section
from sim1.policy.counting import rate, read_table
from sim1.policy.image import page as image_page
from sim1.policy.image.measures import read_points
from sim1.policy.image_trials import page as image_trials_page
from sim1.policy.image_trials.measures import read_result
from sim1.report import Picture, Section
from sim1.stage import BadInput, Inputs
from sim1.validity.outcomes import ACCEPTED, OUTCOME, outcome

type Artifacts = Mapping[str, Path]
"""Of one stage, by garment; "" for a joint one."""


@dataclass(frozen=True, kw_only=True)
class Part:
    """A stage whose findings stand on the page."""

    stage: str
    heading: str  # where there is nothing to show
    sections: Callable[[Artifacts], list[Section]]


def results(made: Inputs, remarks: Mapping[str, str], plans: Plans | None = None) -> list[Section]:
    """Sections of what was found, the paper's claims first; what is missing, or cannot be read, says so in its place.

    Args:
        made: the artifacts that there are, of stages that the graph has: a stage without one was not run.
        remarks: what a reader must know of a stage's artifacts, as that they are not of this state of the inputs.
        plans: what each profile runs, so that a claim that was not measured says which would measure it.
    """
    found = [_claims(made, remarks, plans or Plans())] if any(stage in made for stage in READ) else []
    for part in PARTS:
        if part.stage not in made:
            continue
        remark = [f"Mind: {remarks[part.stage]}."] if part.stage in remarks else []
        try:
            sections = part.sections(made[part.stage]) if made[part.stage] else [_missing(part, "not run")]
        except BadInput as error:
            sections = [_missing(part, f"cannot be shown: {error}")]
        found += [replace(section, paragraphs=[*remark, *section.paragraphs]) for section in sections]
    return found


def _claims(made: Inputs, remarks: Mapping[str, str], plans: Plans) -> Section:
    section = claims_section(made, plans)
    old = [f"Of what was read, mind: {remarks[stage]}." for stage in READ if stage in remarks]
    return replace(section, paragraphs=[*section.paragraphs, *old])


def _missing(part: Part, why: str) -> Section:
    return Section(heading=part.heading, paragraphs=[f"{why[0].upper()}{why[1:]} (stage {part.stage})."])


def _scaling(artifacts: Artifacts) -> list[Section]:
    return scaling_page.result_sections(artifacts[""])


def _ablation(artifacts: Artifacts) -> list[Section]:
    return ablation_page.result_sections(artifacts[""])


def _cost(artifacts: Artifacts) -> list[Section]:
    return cost_page.result_sections(artifacts[""])


def _trials(artifacts: Artifacts) -> list[Section]:
    pictures = [Picture(path=path) for path in sorted(artifacts[""].glob("trials_*.png"))]
    said = (
        "Simulated, in the world that the heading names, the arms not drawn. For each source of training the first success and the first failure "
        "of each class, in the order of the trials: nobody chose them. Counts are of all sizes and networks together."
    )
    none = "None: no trial was run, or the artifact is older than film strips."
    return [Section(heading="Film strips of trials", paragraphs=[said if pictures else none], pictures=pictures)]


def _generated(artifacts: Artifacts) -> list[Section]:
    """How generated attempts ended, counted and shown."""
    tables = {
        garment: read_table(folder / "decisions.parquet", OUTCOME) for garment, folder in sorted(artifacts.items())
    }
    rows = []
    for garment, table in tables.items():
        decisions = table.to_dict("records")
        counts = Counter(outcome(row) for row in decisions if not row["perturbed"])
        on_purpose = Counter(outcome(row) for row in decisions if row["perturbed"])
        for name in sorted({*counts, *on_purpose}, key=lambda name: (name != ACCEPTED, -counts[name], name)):
            share = rate(counts[name], counts.total())
            printed = paper.ABLATION[paper.FULL][paper.PASS_RATE] if name == ACCEPTED else None
            rows.append(
                {
                    "Garment": garment,
                    "Outcome": name,
                    "Attempts (%) | here": share,
                    "Attempts (%) | paper": printed,
                    "Disturbed on purpose": on_purpose[name],
                }
            )
    pictures = [Picture(path=path) for folder in artifacts.values() if (path := folder / "film_strips.png").exists()]
    return [
        Section(
            heading="Generated episodes",
            paragraphs=[
                "How every generated attempt ended: accepted by judge, state rules and video; or the class of its failure; or which filter rejected what "
                "the judge found folded. Percent with 95 % Wilson intervals, without attempts that were disturbed on purpose so that the filters see "
                "failures; these are counted in a column of their own. An attempt that is out of the arms' reach from the start never runs, and has no film strip.",
                "The paper's pass rate is of T-shirts, by its discriminator.",
            ],
            table=rows,
            pictures=pictures,
        )
    ]


def _pictures(artifacts: Artifacts) -> list[Section]:
    printed = paper.ABLATION[paper.FULL]
    note = (
        "No success is measured here: the policy drives in stage image_trials. The paper's success on a real robot with other textures, lighting and "
        f"viewpoint: {printed['texture']}, {printed['lighting']} and {printed['viewpoint']} %. Rendered pictures, simulated cloth, a scripted expert."
    )
    heading = "Image policy: pictures with one thing changed"
    return [image_page.result_section(heading, artifacts[""], read_points(artifacts[""]), [note])]


def _image_trials(artifacts: Artifacts) -> list[Section]:
    folder = artifacts[""]
    about, tried = read_result(folder)
    return [
        image_trials_page.result_section("Image policy in the closed loop", folder, tried, about),
        image_trials_page.strip_section(folder, "Film strips of the image policy's trials"),
    ]


PARTS = (  # in the order of the page: figures, then film strips, which are long
    Part(stage="scaling_report", heading="Scaling curves, success by shift and by garment", sections=_scaling),
    Part(stage="ablation_report", heading="Ablation", sections=_ablation),
    Part(stage="image_policy", heading="Image policy: pictures with one thing changed", sections=_pictures),
    Part(stage="image_trials", heading="Image policy in the closed loop", sections=_image_trials),
    Part(stage="cost_report", heading="Cost of a trajectory", sections=_cost),
    Part(stage="policy", heading="Film strips of trials", sections=_trials),
    Part(stage="valid_trajectories", heading="Generated episodes", sections=_generated),
)
