"""The whole proof: run a campaign, score each case as it comes, keep the report up to date."""

import time
from contextlib import closing

from sim1.proof.campaign import Campaign, read_record, run_campaign
from sim1.proof.files import Record
from sim1.proof.outcome import Outcome
from sim1.proof.proof import NotScored, Proof, judge, keep
from sim1.proof.report import rewrite, write_proof


def prove(campaign: Campaign, *, only_films: bool = False) -> Proof:
    """Do what is not done yet of a campaign and write `proof.json` and `proof.html`.

    Raises:
        BadInput: a record or the commitments are damaged.
    """
    files, drawn, total = campaign.files, campaign.drawn, len(campaign.drawn.cases)
    records: list[Record] = []
    judged: list[Outcome | NotScored] = []
    began, new = time.monotonic(), 0
    before = {case for case in campaign.cases() if (one := read_record(files, case)) and one.step == "diagnose"}
    with closing(run_campaign(campaign, only_films=only_films)) as ended:
        for record in ended:
            records.append(record)
            judged.append(judge(files, drawn, record))
            keep(files, record, judged[-1])
            if record.case in before:
                continue
            write_proof(files, drawn, records, judged)
            new += 1
            left = total - len(records)
            hours = left * (time.monotonic() - began) / new / 3600
            campaign.tell(f"{line(judged[-1])}; {len(records)} of {total} done{_time_left(left, hours)}")
    return rewrite(files)


def line(judged: Outcome | NotScored) -> str:
    """What became of a case, for a person who waits."""
    if isinstance(judged, NotScored):
        return f"{judged.case}: not scored, {judged.why}"
    concealed, named = (" + ".join(sorted(names)) or "nothing" for names in (judged.concealed, judged.named))
    found = f" {named}" if judged.named else ""
    return (
        f"{judged.case}: {judged.verdict}{found} in {judged.seconds:.0f} s; concealed was {concealed}: {_worth(judged)}"
    )


def _worth(outcome: Outcome) -> str:
    if outcome.right:
        return "right"
    return "WRONG" if outcome.wrong else "weak, not named"


def _time_left(left: int, hours: float) -> str:
    if not left:
        return ""
    return f", about {hours:.1f} h left" if hours >= 1 else f", about {60 * hours:.0f} min left"
