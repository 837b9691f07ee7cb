"""The stage on painted pictures: a world to make it in, and what its files hold."""

import hashlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import pytest
from painted_world import Painter, write_mite, write_world

from sim1.policy.image.stage import ImagePolicyConfig, image_policy
from sim1.stage import Inputs

CONFIG = ImagePolicyConfig(
    policy="mite", steps=4, batch=4, chunk_s=0.5, device="cpu", shifted_trajectories=3, checkpoint_s=0.0
)


@dataclass
class World:
    inputs: Inputs
    painter: Painter

    def make(self, out: Path, config: ImagePolicyConfig = CONFIG, **inputs):
        out.mkdir(exist_ok=True)
        return image_policy({**self.inputs, **inputs}, out, config)


class Killed(Exception):
    pass


@contextmanager
def painted_stage(folder: Path) -> Iterator[World]:
    """Inputs in a folder; nothing renders but the painter while it lasts."""
    painter = Painter()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("sim1.render.blender.run_blender", painter)
        patch.setattr("sim1.policy.image.views.run_blender", painter)
        yield World({**write_world(folder), **write_mite(folder / "policies")}, painter)


def contents(folder: Path) -> dict[str, str]:
    return {
        str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


def failed(findings) -> list[str]:
    return [finding.name for finding in findings if finding.blocking and not finding.passed]
