"""The laboratory that films the cases: another program, called by its command line, which is all that is known of it here."""

import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

from sim1.proof.draw import Case
from sim1.proof.processes import LAST_LINES, NotDone, Processes
from sim1.stage import BadInput


@dataclass(frozen=True, kw_only=True)
class Laboratory:
    """Called as `COMMAND list` and `COMMAND make --effect E ... --bundle DIR --held-out DIR --answers FILE.json --strength S --seed K`."""

    command: tuple[str, ...]
    home: Path  # where it is run

    @property
    def argv(self) -> tuple[str, ...]:
        """What is started: `python` is the one that runs this, wherever it lies."""
        return (sys.executable, *self.command[1:]) if self.command[0] == "python" else self.command

    def effects(self) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """Names of the effects that it can conceal: those of the format's table, and those outside it.

        Raises:
            BadInput: it cannot be run, or lists something else.
        """
        try:
            done = subprocess.run([*self.argv, "list"], cwd=self.home, capture_output=True, text=True, check=False)
        except OSError as error:
            raise BadInput(f"--laboratory {' '.join(self.command)}: cannot be run ({error})") from error
        rows = [line.split() for line in done.stdout.splitlines() if line.strip()]
        if done.returncode or any(len(row) < 2 or row[1] not in ("table", "outside") for row in rows):
            said = " | ".join((done.stderr or done.stdout).splitlines()[-LAST_LINES:])
            raise BadInput(f"--laboratory {' '.join(self.command)}: `list` gave no list of effects ({said})")
        table, outside = (tuple(row[0] for row in rows if row[1] == kind) for kind in ("table", "outside"))
        return table, outside

    def film(self, case: Case, bundle: Path, unseen: Path, answers: Path, processes: Processes) -> None:
        """Film a case: the folder `bundle`, other motions of the same cloth in `unseen`, the file `answers` and its arrays beside it.

        Raises:
            NotDone: it failed, or did not write what was asked for.
        """
        effects = [word for name in case.effects or ("none",) for word in ("--effect", name)]
        places = ["--bundle", str(bundle), "--held-out", str(unseen), "--answers", str(answers)]
        drawn = ["--strength", case.strength, "--seed", str(case.seed)]
        answers.parent.mkdir(parents=True, exist_ok=True)
        processes.run([*self.argv, "make", *effects, *places, *drawn], cwd=self.home)
        if not filmed(bundle, unseen, answers):
            raise NotDone(
                f"the laboratory ended well and did not write all of {bundle}, {unseen}, {answers} and its .npz"
            )


def filmed(bundle: Path, unseen: Path, answers: Path) -> bool:
    """Whether all files of a case are there."""
    bundles = (bundle / "bundle.yaml", unseen / "bundle.yaml")
    return all(path.is_file() for path in (*bundles, answers, answers.with_suffix(".npz")))
