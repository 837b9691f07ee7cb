"""Where a project's inputs, artifacts and state lie on disk."""

import os
import re
from dataclasses import dataclass
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[1]
PROFILES = ("smoke", "quick", "study", "paper")
DEFAULT_PROFILE = "quick"


@dataclass(frozen=True)
class Home:
    """A folder with `data/`, `pipeline/*.yaml` and `dagster.yaml`: the repository, or a copy of that shape."""

    root: Path

    @staticmethod
    def here() -> "Home":
        """The home named by SIM1_HOME, or the repository."""
        return Home(Path(os.environ.get("SIM1_HOME", REPOSITORY)).resolve())

    @property
    def definitions(self) -> Path:
        """Folder of `stages.yaml`, `ablations.yaml` and `profiles/`."""
        own = self.root / "pipeline"
        return own if (own / "stages.yaml").is_file() else REPOSITORY / "pipeline"

    @property
    def store(self) -> Path:
        return self.root / "data" / "store"

    @property
    def state(self) -> Path:
        return self.root / ".dagster"

    def relative(self, text: str) -> str:
        """`text` with every path below the home written from there, as a person would type it."""
        return text.replace(f"{self.root}/", "")

    def garments(self) -> list[str]:
        """Names of the garments: one file each in `data/garments/`.

        Raises:
            ValueError: a file name that can't be a partition key.
        """
        names = sorted(path.stem for path in (self.root / "data" / "garments").glob("*.yaml"))
        for name in names:
            if not re.fullmatch(r"[a-z0-9][a-z0-9_-]*", name):
                raise ValueError(
                    f"data/garments/{name}.yaml: a garment's name is made of a-z, 0-9, _ and - (got {name!r}); rename the file"
                )
        return names

    def profile(self) -> str:
        """The profile in force: SIM1_PROFILE, else the remembered one."""
        return os.environ.get("SIM1_PROFILE") or self.remembered_profile()

    def remembered_profile(self) -> str:
        """The profile of the last run of everything, else 'quick'."""
        remembered = self.state / "profile"
        return remembered.read_text().strip() if remembered.is_file() else DEFAULT_PROFILE

    def remember_profile(self, name: str) -> None:
        self.state.mkdir(parents=True, exist_ok=True)
        part = self.state / "profile.part"
        part.write_text(name + "\n")
        part.rename(self.state / "profile")
