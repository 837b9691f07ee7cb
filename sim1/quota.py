"""Which attempts are to be made: numbered series, each with a rule that says when it has enough.

The rule looks at the attempts in the order of their numbers alone. What is made is therefore the same however many processes
make it, in whatever order they finish, and however often they were killed.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

type Row = dict[str, Any]


@dataclass(frozen=True, kw_only=True)
class Ticket:
    """One attempt: series and number decide everything about it."""

    series: str  # of its own name; the plain one has none
    number: int

    @property
    def name(self) -> str:
        """Of its files: 0007, or perturbed_0007."""
        return f"{self.series}_{self.number:04d}" if self.series else f"{self.number:04d}"


@dataclass(frozen=True, kw_only=True)
class Quota:
    """When a series has enough."""

    series: str
    run_count: int  # attempts that run, at least; draws out of the arms' reach do not
    target: int  # with fewer that count among them, more are made ...
    counted: str  # ... where this key of a row, success or accepted, says what counts
    run_limit: int  # ... up to this many that run
    try_limit: int  # and never more than this, run or not

    @classmethod
    def of(cls, series: str, count: int) -> "Quota":
        """Just so many attempts, whatever becomes of them."""
        return cls(series=series, run_count=count, target=0, counted="ran", run_limit=count, try_limit=count)

    def wants_more(self, rows: Sequence[Row]) -> bool:
        """Whether another attempt is to be made after the first ones, `rows`."""
        ran, counted = sum(row["ran"] for row in rows), sum(row[self.counted] for row in rows)
        if len(rows) >= self.try_limit:
            return False
        return ran < self.run_count or (counted < self.target and ran < self.run_limit)


def open_tickets(quotas: Sequence[Quota], done: Mapping[str, Row]) -> list[Ticket]:
    """Attempts that are wanted for certain and not made, in order.

    Attempts before them that are not made either are taken to run and to count. Whatever becomes of them, a series asks for
    no less than that, so nothing is made in vain. The list ends where it depends on them whether more is wanted.
    """
    tickets = []
    for quota in quotas:
        rows: list[Row] = []
        while quota.wants_more(rows):
            ticket = Ticket(series=quota.series, number=len(rows))
            if ticket.name not in done:
                tickets.append(ticket)
            rows.append(done.get(ticket.name, {"ran": True, quota.counted: True}))
    return tickets
