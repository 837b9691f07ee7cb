"""`sim1 replay`: an episode simulated again from what is recorded of it."""

from pathlib import Path
from typing import Annotated

import typer

from assets_defs._open import open_home, stop

CELL = ("garment_mesh", "scene")  # what commands need to be driven again, beside the episode's own record


def replay(
    episode: Annotated[Path, typer.Argument(help="Folder with episode.npz: of the store, or of `sim1 generate`.")],
    from_seed: Annotated[
        bool, typer.Option("--from-seed", help="Draw and plan a generated episode anew too, not its commands alone.")
    ] = False,
) -> None:
    """Simulate an episode again and compare every number with the recorded one: the same bytes on the CPU."""
    from assets_defs._origin import inputs_then, origin_of
    from assets_defs._store import StoreError
    from sim1.stage import BadInput

    folder = episode.resolve()
    home, graph = open_home(None)
    try:
        origin = origin_of(folder)
        inputs, config = inputs_then(home, graph, folder, origin, None if from_seed else CELL)
        from sim1.motion.replay import replay_commands, replay_seed

        if from_seed:
            found = replay_seed(inputs, origin.garment, config, folder)
        else:
            found = replay_commands(inputs, folder)
    except (BadInput, StoreError) as error:
        stop(home.relative(str(error)))
    print(found.said())
    if not found.same:
        raise typer.Exit(1)
