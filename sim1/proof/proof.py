"""`proof.json`, schema `sim1.proof/5`: all that a campaign has shown so far. It tells of diagnosed cases alone: what comes stays concealed."""

from collections.abc import Collection, Sequence
from pathlib import Path
from typing import Literal

import pydantic

from sim1.cloth.effects import EFFECTS
from sim1.mismatch.strict_json import Strict, read_json
from sim1.mismatch.verdict import read_verdict
from sim1.proof.answers import kind_from
from sim1.proof.draw import Case
from sim1.proof.files import Drawn, Files, Record, case_names, write_model
from sim1.proof.found_seal import Diagnosed, check_found, check_verdict, diagnosed
from sim1.proof.fresh import null_seeds
from sim1.proof.ledger import Begun, Commitment, Ended, read_lines
from sim1.proof.methods import Method, methods_of
from sim1.proof.outcome import Outcome, is_right
from sim1.proof.score import OtherCode, asked_besides, score
from sim1.proof.seal import check_committed, committed, covers_films, made_again, read_commitments
from sim1.proof.totals import Confusion, Totals, confusion_of, totals_of
from sim1.stage import BadInput


class NotScored(Strict):
    """A case that was begun and counts nowhere."""

    case: str
    why: str


class Proof(Strict):
    """Contents of `proof.json`."""

    schema_: Literal["sim1.proof/5"] = pydantic.Field(default="sim1.proof/5", alias="schema")
    drawn: int  # cases
    chosen: bool  # by a person, in a file, rather than drawn
    seed: str | None  # of the draw; told when no case is left
    by_chance: bool | None  # whether it is fresh entropy; None: chosen cases, or earlier code, which did not tell
    laboratory: tuple[str, ...]
    laboratory_sha256: tuple[
        str, ...
    ]  # of the program that films, as it was when films were committed to; earlier code did not tell
    one_code: bool  # all cases were diagnosed by one and the same code, the one that the list was committed beside
    code_sha256: tuple[str, ...]  # of all that diagnosed
    cores: tuple[int, ...]
    parallel: tuple[int, ...]
    limits_s: tuple[float, ...]  # that a diagnosis might take; earlier code did not tell
    totals: Totals
    totals_as_first_filmed: Totals | None  # without `films_again`; None: there are none
    methods: tuple[Method, ...]  # the diagnosis and simpler ones
    confusion: Confusion
    outcomes: tuple[Outcome, ...]
    not_scored: tuple[NotScored, ...]
    carried: tuple[str, ...]  # cases that were scored elsewhere: their answers are not here to be checked again
    carried_unsealed: tuple[
        str, ...
    ]  # of these, whose verdict is not here either: nothing but the outcome says what was found
    of_thresholds: tuple[
        str, ...
    ]  # scored cases with nothing concealed by which the thresholds in force were chosen: no proof
    films_again: tuple[
        str, ...
    ]  # committed to anew, as they were made again, and were others, before a diagnosis ended
    films_unsealed: tuple[str, ...]  # scored cases that were committed to by earlier code, to their answers alone
    diagnosed: Diagnosed
    commitments: tuple[Commitment, ...]
    diagnoses: tuple[Begun | Ended, ...]  # in their order


def judge(files: Files, drawn: Drawn, record: Record) -> Outcome | NotScored:
    """Score a case whose answers and films are still those that were committed to; of any other, say why not.

    A case whose answers are not here stays as it was scored where they were, if that fits what was drawn and committed to: `outcomes/`
    goes with a campaign from machine to machine. What oracle and baselines said here of its films made again is put to it.

    Raises:
        OtherCode: the case was diagnosed by code that wrote other files.
    """
    return _carried(files, drawn, record.case) if files.carried(record.case) else _scored(files, drawn, record)


def keep(files: Files, record: Record, judged: Outcome | NotScored) -> None:
    """Store an outcome beside its campaign, which the caller has locked; one that holds no more is removed."""
    if files.carried(record.case):
        return
    if isinstance(judged, Outcome):
        write_model(files.outcome(record.case), judged)
    elif record.step == "diagnose":  # what was scored before answers changed must not come back once they are gone
        files.outcome(record.case).unlink(missing_ok=True)


def _scored(files: Files, drawn: Drawn, record: Record) -> Outcome | NotScored:
    if record.step != "diagnose":
        return NotScored(case=record.case, why=f"{record.step}: {record.error}")
    asked = _asked(drawn, record.case)
    try:
        answers = files.answers(record.case)
        whole = record.error is None  # a diagnosis that failed has, whatever became of its films
        check_committed(files.root, record.case, [answers, answers.with_suffix(".npz")], films=whole)
        check_found(files, record)
        return score(files, asked, record)
    except OtherCode:
        raise
    except BadInput as error:
        return NotScored(case=record.case, why=str(error))


def _carried(files: Files, drawn: Drawn, case: str) -> Outcome | NotScored:
    """What a stored outcome says, held to the list and to the commitments; its figures cannot be taken again without the answers."""
    path, asked = files.outcome(case), _asked(drawn, case)
    try:
        stored = read_json(path, Outcome, "bring it again, or remove it and the case's record")
    except BadInput as damage:
        return NotScored(case=case, why=str(damage))
    of, drawn_was = _of(stored.concealed, stored.strength, stored.seed), _of(asked.effects, asked.strength, asked.seed)
    if (stored.case, of) != (case, drawn_was):
        why = f"is of {stored.case}, {of}; drawn was {drawn_was}"
    elif committed(files.root, case) is None:
        why = "has no line in commitments.jsonl: nobody committed to its answers"
    elif stored.kind != (kind := kind_from([name in EFFECTS for name in asked.effects])):
        why = f"takes what was concealed for {stored.kind}; it is {kind}"
    elif stored.right != is_right(stored.kind, tuple(stored.concealed), stored.verdict, stored.named):
        why = f"says right: {stored.right} of verdict {stored.verdict} {'+'.join(stored.named)}, which does not follow"
    elif (differs := _other_verdict(files, stored)) is not None:
        why = differs
    else:
        try:
            return stored.model_copy(update=asked_besides(files, case))
        except BadInput as damage:
            return NotScored(case=case, why=str(damage))
    return NotScored(
        case=case, why=f"{path}: {why}; bring the outcome and the commitments of the machine that scored it"
    )


def _verdict_of(files: Files, case: str) -> Path:
    return files.found(case) / "verdict.json"


def _other_verdict(files: Files, stored: Outcome) -> str | None:
    """In what a stored outcome is not the verdict that came along and was sealed; None where it is, or none came along."""
    path = _verdict_of(files, stored.case)
    if not path.is_file() or stored.verdict == "failed":
        return None
    try:
        check_verdict(files, stored.case, path)
        verdict = read_verdict(path)
    except BadInput as damage:
        return str(damage)
    named = tuple(sorted(effect.name for effect in verdict.missing_physics))
    if (verdict.verdict, named) == (stored.verdict, stored.named):
        return None
    return f"says {stored.verdict} {'+'.join(stored.named)}; {path} says {verdict.verdict} {'+'.join(named)}"


def _of(effects: Collection[str], strength: str, seed: int) -> str:
    return f"{'+'.join(sorted(effects))}, {strength}, seed {seed}" if effects else f"nothing, seed {seed}"


def _asked(drawn: Drawn, case: str) -> Case:
    return dict(zip(case_names(len(drawn.cases)), drawn.cases, strict=True))[case]


def proof_of(files: Files, drawn: Drawn, records: Sequence[Record], judged: Sequence[Outcome | NotScored]) -> Proof:
    """Put together what is known of the cases so far."""
    outcomes = sorted((one for one in judged if isinstance(one, Outcome)), key=lambda one: one.case)
    commitments, lines = read_commitments(files.root), read_lines(files.root)
    sealed = {one.of for one in commitments if covers_films(one)}
    known = null_seeds()
    carried = tuple(one.case for one in outcomes if files.carried(one.case))
    again = made_again(commitments)
    codes = {one.code_sha256 for one in outcomes} | {line.code_sha256 for line in lines}
    return Proof(
        drawn=len(drawn.cases),
        chosen=drawn.seed is None,
        by_chance=drawn.by_chance,
        seed=drawn.seed if len(judged) == len(drawn.cases) else None,
        laboratory=drawn.laboratory,
        laboratory_sha256=tuple(sorted({c.laboratory_sha256 for c in commitments if c.laboratory_sha256 is not None})),
        one_code=len(codes) <= 1 and not any(one.code_changed for one in outcomes),
        code_sha256=tuple(sorted({one.code_sha256 for one in outcomes})),
        cores=tuple(sorted({record.cores for record in records})),
        parallel=tuple(sorted({record.parallel for record in records})),
        limits_s=tuple(sorted({record.limit_s for record in records if record.limit_s is not None})),
        totals=totals_of(outcomes),
        totals_as_first_filmed=totals_of([one for one in outcomes if one.case not in again]) if again else None,
        methods=methods_of(outcomes),
        confusion=confusion_of(outcomes),
        outcomes=tuple(outcomes),
        not_scored=tuple(sorted((one for one in judged if isinstance(one, NotScored)), key=lambda one: one.case)),
        carried=carried,
        carried_unsealed=tuple(case for case in carried if not _verdict_of(files, case).is_file()),
        of_thresholds=tuple(one.case for one in outcomes if one.kind == "null" and one.seed in known),
        films_again=again,
        films_unsealed=tuple(one.case for one in outcomes if one.case not in sealed),
        diagnosed=diagnosed(lines, [one.case for one in outcomes]),
        commitments=commitments,
        diagnoses=tuple(line for line in lines if not isinstance(line, Commitment)),
    )
