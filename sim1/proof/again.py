"""Films of cases that were scored elsewhere: the same laboratory films them again, and what was committed to says whether they are the same."""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from sim1.proof.files import Drawn, Files, case_names
from sim1.proof.laboratory import Laboratory, filmed
from sim1.proof.processes import NotDone, Processes
from sim1.proof.seal import check, committed
from sim1.stage import BadInput


@dataclass(frozen=True, kw_only=True)
class Films:
    """Films and answers of a campaign's scored cases. Those that stayed behind where a case was scored are made anew, below `again/`."""

    files: Files
    drawn: Drawn
    home: Path  # where the laboratory runs
    tell: Callable[[str], None]
    processes: Processes = field(default_factory=Processes)

    def of(self, case: str) -> Files | None:
        """Where films and answers of a case are; None: filmed again it is another film, or none, of which a line is told.

        Scoring has held those of a case that is here against the commitments.
        """
        if not self.files.carried(case):
            return self.files
        again = self.files.again
        try:
            if not filmed(again.bundle(case), again.unseen(case), again.answers(case)):
                self.tell(f"{case}: filming again, as its films stayed behind")
                self._film(case, again)
            if (commitment := committed(self.files.root, case)) is not None:  # else the case would not be scored
                check(again.root, commitment)
        except (NotDone, BadInput) as error:
            self.tell(f"{case}: not asked, as it cannot be filmed again as it was ({error})")
            return None
        return again

    def _film(self, case: str, again: Files) -> None:
        asked = dict(zip(case_names(len(self.drawn.cases)), self.drawn.cases, strict=True))[case]
        laboratory = Laboratory(command=self.drawn.laboratory, home=self.home)
        laboratory.film(asked, again.bundle(case), again.unseen(case), again.answers(case), self.processes)
