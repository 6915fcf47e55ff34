#!/bin/sh
# Tests the BSDF, or runs one of the scripts, in a virtual environment of its own.
#   integrations/mitsuba/run.sh                              the tests: about 6 minutes on one slow core; needs Chromium
#   integrations/mitsuba/run.sh render.py snake FOLDER -o snake.png
# DIFFRACT names the program, else target/release/diffract. DRJIT_LIBLLVM_PATH names LLVM's library, version 16 or newer.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
venv=${MITSUBA_VENV:-$here/../../target/mitsuba}
[ -x "$venv/bin/python" ] || python3 -m venv "$venv"
"$venv/bin/pip" install --quiet --requirement "$here/requirements.txt"
# Dr.Jit takes the first library that it finds; LLVM 15 and older refuse its code for some processors.
if [ -z "${DRJIT_LIBLLVM_PATH:-}" ]; then
    DRJIT_LIBLLVM_PATH=$(ls /usr/lib/*/libLLVM.so.* /usr/lib/*/libLLVM-1[6-9].so* 2>/dev/null | sort -V | tail -n 1)
    if [ -z "$DRJIT_LIBLLVM_PATH" ]; then
        echo 'mitsuba: LLVM 16 or newer is missing; apt-get install libllvm19' >&2
        exit 1
    fi
    export DRJIT_LIBLLVM_PATH
fi
if [ $# -gt 0 ]; then
    script=$1
    shift
    exec "$venv/bin/python" "$here/$script" "$@"
fi
if [ -z "${VK_DRIVER_FILES:-}" ]; then
    VK_DRIVER_FILES=$("$here/../../tools/setup.sh" lavapipe)
    export VK_DRIVER_FILES VK_ICD_FILENAMES="$VK_DRIVER_FILES"
fi
cd "$here"
exec "$venv/bin/python" -m unittest test_mitsuba
