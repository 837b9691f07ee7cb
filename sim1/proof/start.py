"""How a campaign begins, or goes on: the drawn list, committed to before anything is filmed."""

import secrets
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sim1.mismatch.strict_json import read_json
from sim1.proof.closure import laboratory_sha256
from sim1.proof.draw import Strength, draw_cases, read_cases
from sim1.proof.files import Drawn, Files, write_model
from sim1.proof.fresh import FILE, null_seeds
from sim1.proof.laboratory import Laboratory
from sim1.proof.seal import LIST, check, commit, committed
from sim1.stage import BadInput


@dataclass(frozen=True, kw_only=True)
class Wish:
    """What a person asks of a new campaign; None: not said."""

    cases: int | None = None
    cases_file: Path | None = None
    seed: int | None = None
    strength: Strength | None = None
    laboratory: tuple[str, ...] | None = None

    def said(self) -> list[str]:
        """Options that were given."""
        return [f"--{name.replace('_', '-')}" for name, value in vars(self).items() if value is not None]


def open_campaign(files: Files, wish: Wish, laboratory: tuple[str, ...], home: Path, code: str) -> Drawn:
    """The drawn list of a campaign: the one that is there, or a new one, which is then committed to.

    Raises:
        BadInput: there is one and something else is asked for; or too little is said to begin; or the list has changed;
            or the seed draws a case by which thresholds were set.
    """
    if files.drawn.is_file():
        if said := wish.said():
            raise BadInput(
                f"{files.root}: holds a campaign, and its cases were drawn and committed to; leave out {', '.join(said)}, or take another --out"
            )
        drawn = read_campaign(files)
        _commit(files, drawn, home, code)  # in case it was killed in between
        return drawn
    if wish.cases_file is not None:
        if extra := [name for name in wish.said() if name in ("--cases", "--seed", "--strength")]:
            raise BadInput(f"--cases-file says all of it; leave out {', '.join(extra)}")
        seed, cases = None, read_cases(wish.cases_file)
    elif wish.cases is None:
        raise BadInput(
            f"{files.root}: no campaign yet; say how many cases to draw (--cases 60) or which (--cases-file)"
        )
    else:
        seed = wish.seed if wish.seed is not None else int(np.random.SeedSequence().entropy)
        table, outside = Laboratory(command=wish.laboratory or laboratory, home=home).effects()
        cases = draw_cases(wish.cases, seed, table=table, outside=outside, strength=wish.strength)
        chosen_by = null_seeds()
        if known := [case.seed for case in cases if not case.effects and case.seed in chosen_by]:
            raise BadInput(
                f"--seed {seed}: draws nothing concealed with seed {known[0]} ({len(known)} such), a case by which {FILE} was set, so that it proves nothing; "
                "give another --seed or none. To set thresholds anew by such cases, list them for --cases-file"
            )
    drawn = Drawn(
        nonce=secrets.token_hex(16),
        seed=None if seed is None else str(seed),
        by_chance=None if seed is None else wish.seed is None,
        laboratory=wish.laboratory or laboratory,
        cases=cases,
    )
    write_model(files.drawn, drawn)
    _commit(files, drawn, home, code)
    return drawn


def _commit(files: Files, drawn: Drawn, home: Path, code: str) -> None:
    commit(files.root, LIST, [files.drawn], code, laboratory_sha256(home, drawn.laboratory))


def read_campaign(files: Files) -> Drawn:
    """The drawn list of a campaign that is there.

    Raises:
        BadInput: there is none, it is damaged, or it is not the one that was committed to.
    """
    if (commitment := committed(files.root, LIST)) is not None:
        check(files.root, commitment)
    return read_json(files.drawn, Drawn, "begin a campaign with `sim1 prove --cases 60 --out DIR`")
