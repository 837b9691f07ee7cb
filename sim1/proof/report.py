"""The files for people and programs: `proof.json` and `proof.html`, written anew after every case."""

from collections.abc import Sequence

from sim1.proof.campaign import lost_record, read_record
from sim1.proof.files import Drawn, Files, Record, case_names, write_model
from sim1.proof.outcome import Outcome
from sim1.proof.page import write_page
from sim1.proof.proof import NotScored, Proof, judge, keep, proof_of
from sim1.proof.start import read_campaign
from sim1.stage import BadInput


def scored(files: Files) -> Proof:
    """What is known of a campaign, scored again; nothing is written, as another process may be at work on it.

    Raises:
        BadInput: no campaign, or its list or commitments are damaged.
    """
    drawn, records, judged, lost = _again(files)
    return proof_of(files, drawn, records, [*judged, *lost])


def rewrite(files: Files) -> Proof:
    """Score again what is there, and write outcomes and both files; the campaign is locked by the caller. Raises as `scored` does."""
    drawn, records, judged, lost = _again(files)
    for record, one in zip(records, judged, strict=True):
        keep(files, record, one)
    return _written(files, proof_of(files, drawn, records, [*judged, *lost]))


def _again(files: Files) -> tuple[Drawn, list[Record], list[Outcome | NotScored], list[NotScored]]:
    """The list, records and what each case is worth; last, cases whose record is lost."""
    drawn = read_campaign(files)
    records, judged, lost = [], [], []
    for case in case_names(len(drawn.cases)):
        try:
            record = read_record(files, case)
        except BadInput as damage:
            lost.append(NotScored(case=case, why=str(damage)))
            continue
        if record is not None:
            records.append(record)
            judged.append(judge(files, drawn, record))
        elif files.outcome(case).is_file():
            lost.append(NotScored(case=case, why=lost_record(files, case)))
    return drawn, records, judged, lost


def write_proof(files: Files, drawn: Drawn, records: Sequence[Record], judged: Sequence[Outcome | NotScored]) -> Proof:
    """Write both files about the cases so far."""
    return _written(files, proof_of(files, drawn, records, judged))


def _written(files: Files, proof: Proof) -> Proof:
    write_model(files.root / "proof.json", proof)
    write_page(files.root / "proof.html", proof)
    return proof
