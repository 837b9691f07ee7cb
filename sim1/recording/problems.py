"""What is wrong with a bundle: the reader stops at the first problem, the check wants to see all that are cheap to find."""

from collections.abc import Callable, Sequence

from sim1.stage import BadInput


class Several(BadInput):
    """One or more problems; as text, the first of them and how many more there are."""

    def __init__(self, messages: Sequence[str]) -> None:
        self.messages = tuple(messages)
        more = f" (and {len(messages) - 1} more: see `sim1 recordings check`)" if len(messages) > 1 else ""
        super().__init__(self.messages[0] + more)


class Problems:
    """Gathers the problems of several readings."""

    def __init__(self) -> None:
        self.found: list[str] = []

    def attempt[T](self, work: Callable[..., T], *arguments: object) -> T | None:
        """What `work(*arguments)` gives, or None after noting what was wrong."""
        try:
            return work(*arguments)
        except Several as error:
            self.found += error.messages
        except BadInput as error:
            self.found.append(str(error))
        return None

    def stop(self) -> None:
        """Raise what was found.

        Raises:
            BadInput: there was something.
        """
        if self.found:
            raise Several(self.found)
