#!/bin/sh
# Tests the WGSL function through wgpu, or runs the script, in a virtual environment of its own.
#   integrations/wgpu/run.sh                                 the tests: half a minute on one slow core
#   integrations/wgpu/run.sh evaluate.py FOLDER              the directions of FOLDER/conformance.csv
# DIFFRACT names the program, else target/release/diffract. Without VK_DRIVER_FILES wgpu draws on lavapipe.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
venv=${WGPU_VENV:-$here/../../target/wgpu}
[ -x "$venv/bin/python" ] || python3 -m venv "$venv"
"$venv/bin/pip" install --quiet --requirement "$here/requirements.txt"
if [ -z "${VK_DRIVER_FILES:-}" ]; then
    VK_DRIVER_FILES=$("$here/../../tools/setup.sh" lavapipe)
    export VK_DRIVER_FILES VK_ICD_FILENAMES="$VK_DRIVER_FILES"
fi
if [ $# -gt 0 ]; then
    script=$1
    shift
    exec "$venv/bin/python" "$here/$script" "$@"
fi
cd "$here"
exec "$venv/bin/python" -m unittest test_wgpu
