"""Makes the virtual scans of `data/scans/`: python -m sim1.scan.virtual [--out data/scans] [--garment towel ...]."""

import argparse
from pathlib import Path

from sim1.scan.virtual.garments import GARMENTS
from sim1.scan.virtual.session import scan_garment


def main() -> None:
    """Write one folder per garment; the same bytes every time."""
    parser = argparse.ArgumentParser(
        description="Make virtual scans (a model of a depth-camera scanner; nothing is measured)."
    )
    parser.add_argument("--out", type=Path, default=Path("data/scans"), help="folder that gets one folder per garment")
    parser.add_argument("--garment", nargs="+", choices=sorted(GARMENTS), default=sorted(GARMENTS))
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    for name in arguments.garment:
        scan_garment(arguments.out / name, GARMENTS[name](), seed=arguments.seed, name=name)


if __name__ == "__main__":
    main()
