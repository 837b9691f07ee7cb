import numpy as np
import pytest
from motion_synthetic import a_demo

from sim1.motion.pool import Segment


@pytest.fixture
def pool() -> list[Segment]:
    """Four synthetic demonstrations of three segments each."""
    rng = np.random.default_rng(5)
    return [part for index in range(4) for part in a_demo(f"{index:04d}", rng, 3 * index)]
