import numpy as np
import pytest
from motion_synthetic import HOME, a_demo, reaching_demos, two_arms

from sim1.motion.assembly import Source
from sim1.motion.commands import Arms
from sim1.motion.home import Home
from sim1.motion.pool import Segment
from sim1.motion.poses import ToolPath


@pytest.fixture
def pool() -> list[Segment]:
    """Four synthetic demonstrations of three segments each."""
    rng = np.random.default_rng(5)
    return [part for index in range(4) for part in a_demo(f"{index:04d}", rng, 3 * index)]


@pytest.fixture(scope="session")
def arms() -> Arms:
    return two_arms()


@pytest.fixture(scope="session")
def home() -> Home:
    """A sheet that lies between the arms, and the arms above it."""
    sheet = np.stack([*np.meshgrid(np.linspace(-0.1, 0.1, 5), np.linspace(-0.1, 0.1, 5)), np.zeros((5, 5))], axis=-1)
    return Home(start_m=sheet.reshape(-1, 3), joints_rad=HOME, openness=np.ones(2), first_openness=np.ones(2))


@pytest.fixture(scope="session")
def demonstrated(arms, home):
    """Demonstrations that the arms can really reach: each interaction slides 8 cm from below the home pose and back."""
    rng = np.random.default_rng(2)
    tools = arms.tool_path(HOME[None], np.ones((1, 2)))
    segments = []
    for index in range(2):
        for part in a_demo(f"{index:04d}", rng, 3 * index):
            count = len(part.path)
            slide = np.zeros((count, 2, 3))
            slide[..., 0] = 0.08 * np.sin(np.pi * np.arange(count) / count)[:, None] ** 2 + 0.01 * index
            path = ToolPath(
                position_m=tools.position_m + slide,
                rotation=np.repeat(tools.rotation, count, axis=0),
                openness=part.path.openness,
            )
            segments.append(part.__class__(**{**part.__dict__, "path": path}))
    lying = {(part.demo, part.start_frame): home.start_m for part in segments}
    return segments, Source(home=home, garment_m=lying)


@pytest.fixture(scope="session")
def reached(arms) -> list[Segment]:
    """Ten demonstrations within the arms' reach."""
    return reaching_demos(arms, 10)
