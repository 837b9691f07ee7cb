"""End of the set-up: do the packages that want system libraries import? Prints what to install, and exits with 1, if not."""

import sys
from concurrent.futures import ThreadPoolExecutor

from sim1.system_libraries import NEEDING, import_error, missing_for, remedy


def main() -> int:
    """Import each package in its own process (two of them clash in one) and explain failures on standard output."""
    with ThreadPoolExecutor(2) as pool:
        errors = dict(zip(NEEDING, pool.map(lambda name: import_error(f"import {name}")[0], NEEDING), strict=True))
    failed = {name: error for name, error in errors.items() if error}
    missing = sorted({library for name, error in failed.items() for library in missing_for(name, error)})
    for name, error in failed.items():
        print(f"setup: {name} cannot be imported: {error}")
    if missing:
        print(f"setup: missing system libraries: {', '.join(missing)}. As administrator: {remedy(missing)}")
    elif failed:
        print("setup: no system library is missing; remove .venv and run the set-up again")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
