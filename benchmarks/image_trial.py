"""Where the time of an image policy's trial goes: `python -m benchmarks.image_trial HOME`, with the artifacts of a home.

One trial in-domain, alone, one thread each for policy, simulation and Blender. CPU seconds, which other work on the machine changes
less than those of the clock.
"""

import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import yaml

from sim1.policy.counting import read_figures
from sim1.policy.image.measures import SCHEMA
from sim1.policy.image_trials.crew import Driver
from sim1.policy.image_trials.experiment import plan_trials
from sim1.policy.image_trials.stage import ImageTrialsConfig
from sim1.policy.trials import open_bench
from sim1.render.film_set import FilmSet
from sim1.render.live_camera import LiveCamera
from sim1.stage import Inputs

TICKS = 100  # of a CPU second in /proc


class Clock:
    """CPU seconds of this process, and of Blender's, by what they were spent on."""

    def __init__(self) -> None:
        self.spent: Counter[str] = Counter()

    @contextmanager
    def on(self, what: str):
        begin = time.process_time()
        yield
        self.spent[what] += time.process_time() - begin

    def of[T](self, what: str, work: Callable[..., T]) -> Callable[..., T]:
        """The same work, its time noted."""

        def timed(*args, **named):
            with self.on(what):
                return work(*args, **named)

        return timed


def main(home: Path) -> None:
    """Drive one trial and print what it took."""
    inputs = _inputs(home)
    learnt = read_figures(inputs["image_policy"][""] / "image_policy.json", SCHEMA, "image_policy")
    clock = Clock()
    with tempfile.TemporaryDirectory() as folder:
        config = ImageTrialsConfig(shifts=("in-domain",), trial_count=1, processes=1, device="cpu")
        plan = plan_trials(inputs, learnt, Path(folder), config)
        driver, trial = Driver.of(plan), plan.trials[0]
        wardrobe = plan.wardrobes[trial.garment]
        with clock.on("opening the cell"):
            bench = open_bench(inputs, trial.garment, config.trials_in)
        film_set = FilmSet.of(
            inputs["garment_mesh"][trial.garment], inputs["scene"][trial.garment], wardrobe.config.cameras
        )
        camera = LiveCamera(film_set, replace(wardrobe.config, threads=1), Path(folder))
        blender = Path(f"/proc/{camera._process._process.pid}/stat")
        bench.cell.step = clock.of("simulation", bench.cell.step)
        policy = driver.network(trial.model).policy
        policy.predict_action_chunk = clock.of("policy", policy.predict_action_chunk)
        camera.pictures = clock.of("rendering, outside Blender", camera.pictures)
        row, film = driver.run(trial, bench, camera)
        user, system = blender.read_text().rpartition(")")[2].split()[11:13]
        clock.spent["Blender, with its start"] = (int(user) + int(system)) / TICKS
    size = f"{wardrobe.config.width} x {wardrobe.config.height}"
    print(f"{row['garment']}: {row['simulated_s']:.1f} s simulated, {len(film)} pictures of {size}, CPU seconds:")
    for what, seconds in clock.spent.items():
        print(f"  {what}: {seconds:.1f}")


def _inputs(home: Path) -> Inputs:
    rows = yaml.safe_load((home / "pipeline" / "stages.yaml").read_text())["stages"]
    wanted = next(row["needs"] for row in rows if row["name"] == "image_trials")
    store = home / "data" / "store"
    made = {
        stage: {path.name.strip("_"): path for path in (store / stage).iterdir() if path.is_dir()} for stage in wanted
    }
    return {**made, "appearance": {"": home / "data" / "appearance"}}


if __name__ == "__main__":
    main(Path(sys.argv[1]))
