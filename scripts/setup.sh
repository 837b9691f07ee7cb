#!/usr/bin/env bash
# Make .venv from the pinned, hashed requirements. Needs a Python with pip; installs uv when it is missing.
set -euo pipefail
cd "$(dirname "$0")/.."
want=$(cat .python-version)

if ! uv --version >/dev/null 2>&1; then  # a shim may be there without the program
  python=$(command -v python3 || command -v python) || { echo "setup: no python3 found; install Python $want" >&2; exit 1; }
  echo "setup: installing uv with pip"
  "$python" -m pip install --quiet --user uv 2>/dev/null || "$python" -m pip install --quiet --break-system-packages uv
  PATH="$("$python" -m site --user-base)/bin:$PATH"
  uv --version >/dev/null 2>&1 || uv() { "$python" -m uv "$@"; }
fi

echo "setup: Python $want in .venv"
[ -x .venv/bin/python ] || uv venv --quiet --python "$want" .venv
echo "setup: packages (a few GB the first time)"
# Where Python may not keep compiled files, each start would compile two thousand modules anew (7 s instead of 2 s).
uv pip sync --quiet ${PYTHONDONTWRITEBYTECODE:+--compile-bytecode} --python .venv/bin/python --require-hashes requirements.txt
uv pip install --quiet --python .venv/bin/python --no-deps --no-build-isolation --editable .
missing=$(.venv/bin/python scripts/system_libraries.py) || { echo "$missing" >&2; exit 1; }
