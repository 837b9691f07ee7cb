"""`sim1 looks`: a picture of everything that appearances are drawn from."""

from pathlib import Path
from typing import Annotated, Literal

import typer

from assets_defs._open import open_home, stop
from assets_defs._progress import bar


def looks(
    out: Annotated[Path, typer.Option(help="Folder for fabrics.png, tables.png and rooms.png.")],
    folder: Annotated[
        Path | None, typer.Option(help="Folder with the files of looks. Default: data/appearance.")
    ] = None,
    width: Annotated[
        int, typer.Option(min=32, help="Of a small picture, px; three quarters as high; rooms 0.7 of it.")
    ] = 128,
    samples: Annotated[int, typer.Option(min=1, help="Light paths per pixel.")] = 24,
    engine: Annotated[
        Literal["cycles", "workbench"], typer.Option(help="workbench: at once, without light.")
    ] = "cycles",
) -> None:
    """Render every fabric, table and room small, with its name: what the files of looks give."""
    asked, given = out.resolve(), folder and folder.resolve()
    home, _ = open_home(None)
    from sim1.progress import listening
    from sim1.render.blender import BlenderFailed
    from sim1.render.catalogue import preview, shelves, write_sheet
    from sim1.render.looks.draw import read_looks
    from sim1.stage import BadInput

    config = preview(width, samples=samples, engine=engine)
    try:
        sheets = shelves(read_looks(given or home.root / "data" / "appearance"), config.seed)
        with bar(len(sheets)) as show:
            for number, (name, shelf) in enumerate(sheets.items()):
                path = asked / f"{name}.png"
                with listening(lambda done, total, _, name=name, before=number: show(before + done / total, name)):
                    write_sheet(shelf, path, config)
                print(f"{len(shelf.appearances)} {name}: {home.relative(str(path))}")
    except (BadInput, BlenderFailed) as error:
        stop(home.relative(str(error)))
