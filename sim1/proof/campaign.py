"""Film, commit, diagnose, score: one case after the other, or several at once. What is whole stays, whatever happens."""

import shutil
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass, field
from os import cpu_count, getpid
from pathlib import Path
from threading import Lock

from sim1.mismatch.strict_json import read_json
from sim1.proof.closure import code_sha256, laboratory_sha256
from sim1.proof.draw import Case
from sim1.proof.files import Drawn, Files, Record, case_names, write_model
from sim1.proof.found_seal import begin, end
from sim1.proof.laboratory import Laboratory, filmed
from sim1.proof.processes import NotDone, Processes
from sim1.proof.seal import commit
from sim1.proof.unseen import MODELS
from sim1.stage import BadInput

LIMIT_S = 3600.0  # that a diagnosis may take: one that hangs must not hold up the others
LOG = "diagnose.log"


@dataclass(frozen=True, kw_only=True)
class Campaign:
    """What a campaign works with."""

    files: Files
    drawn: Drawn
    home: Path  # where the laboratory runs
    diagnose: tuple[str, ...]  # command; a bundle and --out FOLDER are put behind it
    predict: tuple[str, ...]  # command; a bundle, --model FILE and --out FILE are put behind it
    environment: Mapping[str, str]  # of both
    code: Path  # folder of the packages with the diagnosing code
    tell: Callable[[str], None]  # lines for a person
    parallel: int = 1
    limit_s: float = LIMIT_S
    processes: Processes = field(default_factory=Processes)
    lock: Lock = field(default_factory=Lock)  # of the commitments

    def cases(self) -> dict[str, Case]:
        """Names and what was drawn."""
        return dict(zip(case_names(len(self.drawn.cases)), self.drawn.cases, strict=True))


def run_campaign(campaign: Campaign, *, only_films: bool = False) -> Iterator[Record]:
    """Do what is not done yet; gives each case's record when it is there, those of earlier runs first.

    With `only_films`, cases are filmed and committed to, and nothing is diagnosed. An interruption ends all that runs, and raises on.

    Raises:
        BadInput: a record or the commitments are damaged, or a case was scored and its record is not here.
    """
    files, todo = campaign.files, []
    for scratch in (files.root / "found").glob(".*"):
        shutil.rmtree(scratch, ignore_errors=True)  # a diagnosis that outlived its campaign may be writing there still
    for case in campaign.cases():
        record = read_record(files, case)
        if record is not None and record.step == "diagnose":
            yield record
        elif files.outcome(case).is_file():  # diagnosed anew, it would be written over
            raise BadInput(lost_record(files, case))
        else:  # not begun, or not begun to be diagnosed
            todo.append(case)
    work = _prepare if only_films else _whole_case
    with ThreadPoolExecutor(campaign.parallel) as pool:
        running = [pool.submit(work, campaign, case) for case in todo]
        try:
            for future in as_completed(running):
                if (record := future.result()) is not None:
                    yield record
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            campaign.processes.stop()
            raise


def read_record(files: Files, case: str) -> Record | None:
    """How a case ended; None where it has not.

    Raises:
        BadInput: the file is damaged, or of another case.
    """
    path = files.record(case)
    if not path.is_file():
        return None
    record = read_json(
        path, Record, f"restore it, or remove it and {files.outcome(case)} to have the case diagnosed again"
    )
    if record.case != case:
        raise BadInput(f"{path}: case is {record.case!r}, expected {case!r}; restore it")
    return record


def lost_record(files: Files, case: str) -> str:
    """What is to be said of a case that was scored and has no record of its diagnosis."""
    return (
        f"{files.outcome(case)}: {case} was scored, and {files.record(case)} does not say that it was diagnosed; bring that file from where "
        "it was scored, or remove the outcome to have the case diagnosed here"
    )


def _whole_case(campaign: Campaign, case: str) -> Record | None:
    return _prepare(campaign, case) or _diagnosed(campaign, case)


def _prepare(campaign: Campaign, case: str) -> Record | None:
    """Film a case unless that is done, and commit to its answers and films. Returns a record only where that fails."""
    files, asked = campaign.files, campaign.cases()[case]
    answers, code = files.answers(case), code_sha256(campaign.code)
    films_by = laboratory_sha256(campaign.home, campaign.drawn.laboratory)
    files.record(case).unlink(missing_ok=True)
    try:
        places = files.bundle(case), files.unseen(case), answers
        if made_anew := not filmed(*places):
            campaign.tell(f"{case}: filming")
            laboratory = Laboratory(command=campaign.drawn.laboratory, home=campaign.home)
            laboratory.film(asked, *places, campaign.processes)
    except NotDone as error:
        campaign.tell(f"{case}: not filmed; {files.record(case)} says why")
        return _written(campaign, _record(campaign, case, "film", error=str(error), code=code))
    try:
        with campaign.lock:
            made = commit(files.root, case, files.sealed(case), code, films_by, made_anew=made_anew)
    except BadInput as error:
        remedy = f"{error}; or remove {files.bundle(case)}, so that the case is filmed again"
        return _written(campaign, _record(campaign, case, "seal", error=remedy, code=code))
    hashes = ", ".join(f"{name} {hashed}" for name, hashed in made.sha256.items())
    campaign.tell(f"{case}: committed at {made.at} to {hashes}")
    return None


def _diagnosed(campaign: Campaign, case: str) -> Record:
    """Diagnose a case from its bundle alone, in a process of its own."""
    files, before = campaign.files, code_sha256(campaign.code)
    bundle, found, scratch = files.bundle(case), files.found(case), files.found(f".{case}.{getpid()}")
    with campaign.lock:
        begin(files, case, before)
    for earlier in files.findings(case):  # of a diagnosis that was killed
        shutil.rmtree(earlier, ignore_errors=True)
    for besides in (files.oracle(case), files.baselines(case)):  # of another diagnosis, maybe another recording
        besides.unlink(missing_ok=True)
    scratch.mkdir(
        parents=True
    )  # of this process: one that was killed may have left a diagnosis that still runs and writes
    campaign.tell(f"{case}: diagnosing")
    error, began = None, time.monotonic()
    try:
        said = _run(campaign, [*campaign.diagnose, str(bundle), "--out", str(scratch)])
        (scratch / LOG).write_text(said)
        if not (scratch / "verdict.json").is_file():
            error = "the diagnosis ended well and wrote no verdict.json"
    except NotDone as failure:
        error = str(failure)
    seconds = time.monotonic() - began
    scratch.rename(found)
    lost = _foretell(campaign, case) if error is None else {}
    record = _record(campaign, case, "diagnose", error=error, seconds=seconds, code=before, not_foretold=lost)
    with campaign.lock:
        hashed = end(files, record)
    campaign.tell(f"{case}: what was found is sealed; SHA-256 of that line of commitments.jsonl: {hashed}")
    return _written(campaign, record)


def _run(campaign: Campaign, command: list[str]) -> str:
    """Run a program in an empty folder that is nobody's: what it leaves where it stands is no part of a film."""
    with tempfile.TemporaryDirectory(prefix="sim1_prove_", ignore_cleanup_errors=True) as empty:
        return campaign.processes.run(command, cwd=Path(empty), env=campaign.environment, limit_s=campaign.limit_s)


def _foretell(campaign: Campaign, case: str) -> dict[str, str]:
    """Have the motions that the diagnosis was not given foretold by its models. Returns why, of a model that does not."""
    files, unseen, lost = campaign.files, campaign.files.unseen(case), {}
    for model in MODELS:
        file, out = files.found(case) / f"{model}.yaml", files.foretold(case, model)
        out.parent.mkdir(parents=True, exist_ok=True)
        try:
            _run(campaign, [*campaign.predict, str(unseen), "--model", str(file), "--out", str(out)])
        except NotDone as failure:
            out.unlink(missing_ok=True)  # half a file
            lost[model] = str(failure)
            campaign.tell(f"{case}: {model}.yaml foretells no motion: {failure}")
    return lost


def _record(
    campaign: Campaign,
    case: str,
    step: str,
    *,
    error: str | None,
    code: str,
    seconds: float | None = None,
    not_foretold: dict[str, str] | None = None,
) -> Record:
    return Record(
        case=case,
        step=step,
        error=error,
        seconds=None if seconds is None else round(seconds, 3),
        limit_s=campaign.limit_s,
        not_foretold=not_foretold or {},
        code_sha256=code,
        code_changed=code_sha256(campaign.code) != code,
        cores=cpu_count() or 1,
        parallel=campaign.parallel,
    )


def _written(campaign: Campaign, record: Record) -> Record:
    write_model(campaign.files.record(record.case), record)
    return record
