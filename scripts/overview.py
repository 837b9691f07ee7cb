"""Make `docs/pictures/overview.png` from the artifacts of the last run: scan, mesh, fold, frames of one garment."""

import sys
from pathlib import Path

from PIL import Image

PANELS = (
    "scan/{}/scan.png",
    "garment_mesh/{}/mesh.png",
    "seed_demos/{}/1_film_strip.png",
    "rendered_episodes/{}/contact_sheet.png",
)
WIDTH_PX = 1100


def main(garment: str) -> None:
    """Scan and mesh side by side, film strip and frames below them."""
    store = Path("data/store")
    scan, mesh, strip, frames = (Image.open(store / panel.format(garment)).convert("RGB") for panel in PANELS)
    height = 330
    top = [image.resize((round(image.width * height / image.height), height)) for image in (scan, mesh)]
    share = min(1.0, WIDTH_PX / sum(image.width for image in top))
    top = [image.resize((int(image.width * share), int(image.height * share))) for image in top]
    below = [image.resize((WIDTH_PX, round(image.height * WIDTH_PX / image.width))) for image in (strip, frames)]
    page = Image.new("RGB", (WIDTH_PX, top[0].height + sum(image.height for image in below)), "white")
    page.paste(top[0], (0, 0))
    page.paste(top[1], (top[0].width, 0))
    page.paste(below[0], (0, top[0].height))
    page.paste(below[1], (0, top[0].height + below[0].height))
    out = Path("docs/pictures/overview.png")
    out.parent.mkdir(parents=True, exist_ok=True)
    page.quantize(192).save(out, optimize=True)


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "tshirt")
