"""`sim1 prove`: does the diagnosis name what was concealed? Cases drawn by chance, answers committed to, all scored."""

import os
import shlex
import signal
import sys
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Literal

import typer

from assets_defs._open import stop


def prove(
    cases: Annotated[int | None, typer.Option(min=1, help="Cases to draw; from 60 on, every effect is there.")] = None,
    seed: Annotated[int | None, typer.Option(min=0, help="Of the draw; fresh entropy where not given.")] = None,
    out: Annotated[Path, typer.Option(help="Folder of the campaign; one that is there goes on.")] = Path("build/proof"),
    strength: Annotated[
        Literal["weak", "medium", "strong"] | None,
        typer.Option(help="Of all concealed effects, in place of one drawn for each case."),
    ] = None,
    cases_file: Annotated[
        Path | None,
        typer.Option(help="YAML list of {effects: [..], strength: medium, seed: 1}: chosen cases in place of drawn."),
    ] = None,
    laboratory: Annotated[
        str | None, typer.Option(help="Command that films; default: this project's benchmarks.concealed.")
    ] = None,
    parallel: Annotated[
        int | None, typer.Option(min=1, help="Cases at once; a diagnosis alone uses all cores; 1.")
    ] = None,
    limit_minutes: Annotated[
        float | None, typer.Option(min=0.1, help="A diagnosis that takes longer has failed; 60.")
    ] = None,
    only_films: Annotated[bool, typer.Option("--only-films", help="Film and commit, diagnose nothing.")] = False,
    oracle: Annotated[
        bool, typer.Option("--oracle", help="Of what is diagnosed: what a model that is told the effects gains.")
    ] = False,
    baselines: Annotated[
        bool, typer.Option("--baselines", help="Of what is diagnosed: what simpler methods say and gain.")
    ] = False,
    calibrate: Annotated[
        bool,
        typer.Option("--calibrate", help="Thresholds from the cases with nothing concealed: DIR/thresholds.yaml."),
    ] = False,
    beside: Annotated[
        list[Path] | None, typer.Option("--with", help="For --calibrate: another campaign whose cases count too.")
    ] = None,
    report: Annotated[bool, typer.Option("--report", help="Score again and rewrite the page, no more.")] = False,
) -> None:
    """Prove on concealed cases what `sim1 diagnose` can do. A killed campaign goes on where it was."""
    from sim1.lock import Taken, exclusive
    from sim1.proof.report import rewrite, scored
    from sim1.proof.start import Wish
    from sim1.stage import BadInput

    if beside and not calibrate:
        stop("--with names campaigns for --calibrate; give both")
    root = out.resolve()
    counted = [root, *(other.resolve() for other in beside or ())]
    if twice := next((path for path in counted if counted.count(path) > 1), None):
        stop(f"--with {twice}: the cases of a campaign count once; name each once, and the one of --out not at all")
    wish = Wish(
        cases=cases,
        cases_file=cases_file,
        seed=seed,
        strength=strength,
        laboratory=tuple(shlex.split(laboratory)) if laboratory else None,
    )
    of_what_is_there = report or oracle or baselines or calibrate
    if of_what_is_there and (said_too := _of_a_run(wish, parallel, limit_minutes, only_films)):
        stop(f"nothing is drawn or diagnosed for this; leave out {', '.join(said_too)}")
    try:
        with exclusive(root / "campaign.lock"):
            from sim1.proof.files import Files

            if of_what_is_there:
                found = rewrite(Files(root))
            else:
                found = _run(root, wish, parallel or 1, 60 * (limit_minutes or 60.0), only_films)
            if oracle:
                from sim1.proof.oracle import ask_oracle

                _ask(root, ask_oracle, found)
                found = rewrite(Files(root))
            if baselines:
                from sim1.proof.baselines.ask import ask_baselines

                _ask(root, ask_baselines, found)
                found = rewrite(Files(root))
            if calibrate:
                _calibrate(root / "thresholds.yaml", found, [scored(Files(other)) for other in counted[1:]])
    except BadInput as error:
        stop(str(error))
    except Taken as taken:
        stop(f"{out}: process {taken.holder} works on this campaign; wait for it or end it")
    except KeyboardInterrupt:
        again = [*(["--oracle"] if oracle else []), *(["--baselines"] if baselines else []), "--out", str(out)]
        typer.secho(f"stopped; `sim1 prove {' '.join(again)}` goes on where it was", err=True)
        raise typer.Exit(130) from None
    from sim1.proof.page import by_strength, said

    totals = found.totals
    print(
        f"{len(found.outcomes)} of {found.drawn} cases scored: single effects, medium and strong, named: {said(totals.named)}; "
        f"nothing concealed called none: {said(totals.nulls_called_none)}; {out / 'proof.html'}"
    )
    for line in by_strength(totals):
        print(line)


def _of_a_run(wish, parallel: int | None, limit_minutes: float | None, only_films: bool) -> list[str]:
    """Options that were given and that say how cases are drawn, filmed and diagnosed."""
    given = {"--parallel": parallel, "--limit-minutes": limit_minutes, "--only-films": only_films or None}
    return [*wish.said(), *(name for name, value in given.items() if value is not None)]


def _ask(root: Path, ask, found) -> None:
    from pipeline.home import REPOSITORY
    from sim1.proof.again import Films
    from sim1.proof.files import Files
    from sim1.proof.start import read_campaign

    files = Files(root)
    with _ended_by_kill():
        ask(Films(files=files, drawn=read_campaign(files), home=REPOSITORY, tell=_say), found.outcomes)


def _calibrate(path: Path, found, others) -> None:
    from sim1.proof.calibrate import calibrated, write_thresholds

    measured = calibrated([outcome for proof in (found, *others) for outcome in proof.outcomes])
    write_thresholds(path, measured)
    low, high = measured.named_ci95
    _say(
        f"a name needs {measured.named:g} nats [{low:g}, {high:g}], a misfit counts from {measured.misfit:g}, in one recording from "
        f"{measured.misfit_alone:g}, and what any established model gains from {measured.gain:g}: "
        f"{len(measured.nulls)} cases with nothing concealed, of which {measured.level:.0%} may exceed any of "
        f"the four: {path}; in force as sim1/mismatch/thresholds.yaml"
    )


def _run(root: Path, wish, parallel: int, limit_s: float, only_films: bool):
    import sim1
    from pipeline.home import REPOSITORY
    from sim1.proof.campaign import Campaign
    from sim1.proof.closure import ENTRY, code_sha256
    from sim1.proof.files import Files
    from sim1.proof.prove import prove
    from sim1.proof.seal import read_commitments
    from sim1.proof.start import open_campaign

    files, code = Files(root), Path(sim1.__file__).parents[1]
    films_here = ("python", "-m", "benchmarks.concealed")  # as in the list, which must not tell of this machine
    drawn = open_campaign(files, wish, films_here, REPOSITORY, code_sha256(code))
    made = read_commitments(root)[0]
    _say(f"{len(drawn.cases)} cases, committed at {made.at} to {made.sha256['answers/drawn.json']}")
    campaign = Campaign(
        files=files,
        drawn=drawn,
        home=REPOSITORY,
        diagnose=(sys.executable, "-P", "-m", ENTRY, "diagnose"),
        predict=(sys.executable, "-P", "-m", ENTRY, "predict"),
        environment={**os.environ, "PYTHONPATH": str(code)},  # this code, wherever it is started
        code=code,
        tell=_say,
        parallel=parallel,
        limit_s=limit_s,
    )
    with _ended_by_kill():
        return prove(campaign, only_films=only_films)


@contextmanager
def _ended_by_kill():
    """A plain `kill` ends what films and diagnoses too."""
    before = signal.signal(signal.SIGTERM, _interrupt)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


def _say(line: str) -> None:
    print(line, flush=True)


def _interrupt(number, frame) -> None:
    raise KeyboardInterrupt
