#!/bin/sh
# Computes assets/validity/table.csv anew: C method against scalar theory. Two hours and more on one slow core.
#   tools/validity/run.sh [ARGUMENT OF table.py]...
set -eu
cd "$(dirname "$0")"
venv=${VALIDITY_VENV:-../../target/validity}
[ -x "$venv/bin/python" ] || python3 -m venv "$venv"
"$venv/bin/pip" install --quiet --requirement requirements.txt
# One thread a process: the matrices are small.
export OPENBLAS_NUM_THREADS=1 OMP_NUM_THREADS=1
"$venv/bin/python" -m unittest test_cmethod test_scalar
exec "$venv/bin/python" table.py "$@"
