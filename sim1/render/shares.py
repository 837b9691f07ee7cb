"""Which pictures a worker renders next: it stays with the clip that it has set up, as setting up another costs some pictures.

Pictures are handed out few at a time to whoever is ready, so that workers finish together however fast each of them is.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass

from sim1.render.job import Picture

BATCH = 8  # pictures: they take longer than setting up a clip where another worker has begun it


@dataclass(frozen=True, kw_only=True)
class Order:
    """Pictures of one clip, for one worker."""

    clip: str  # its key
    pictures: tuple[Picture, ...]
    moment: str = ""  # file in the job's folder with the states to be shown, in place of the clip's footage

    def line(self) -> str:
        """As it is sent."""
        return json.dumps(asdict(self)) + "\n"

    @classmethod
    def of(cls, line: str) -> "Order":
        content = json.loads(line)
        pictures = tuple((camera, frame) for camera, frame in content["pictures"])
        return cls(clip=content["clip"], pictures=pictures, moment=content["moment"])


class Shares:
    """Pictures that nobody renders yet.

    Args:
        missing: pictures to render, in order, by the clip's key.
    """

    def __init__(self, missing: Mapping[str, Sequence[Picture]]):
        self._left = {clip: tuple(pictures) for clip, pictures in missing.items() if pictures}
        self._begun: set[str] = set()

    @property
    def batches(self) -> int:
        """How many orders there are at least, and so how many workers find one."""
        return sum(-(-len(pictures) // BATCH) for pictures in self._left.values())

    def take(self, shown: str | None) -> Order | None:
        """Pictures for a worker that has set up the clip `shown`; nothing where all are taken.

        Of its clip, else of the longest one that nobody has begun, else of the one where most is left.
        """
        if not self._left:
            return None
        if shown not in self._left:
            among = [clip for clip in self._left if clip not in self._begun] or self._left
            shown = max(among, key=lambda clip: len(self._left[clip]))
        self._begun.add(shown)
        pictures = self._left.pop(shown)
        if rest := pictures[BATCH:]:
            self._left[shown] = rest
        return Order(clip=shown, pictures=pictures[:BATCH])
