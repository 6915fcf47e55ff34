#!/bin/sh
# Draws a sphere and a torus knot by diffract, three.js, wgpu, Cycles, EEVEE and Mitsuba, and prints how far each is from diffract.
#   integrations/side_by_side/run.sh FOLDER     pictures in FOLDER, side by side in FOLDER/elsewhere.png: some minutes on slow cores
# DIFFRACT names the program, else target/release/diffract. Run the tests of three, wgpu, blender and mitsuba first: they bring what each needs.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
target=$here/../../target
if [ $# != 1 ]; then
    sed -n '2,4s/^# *//p' "$0" >&2
    exit 2
fi
mkdir -p "$1"
folder=$(cd "$1" && pwd)
VK_DRIVER_FILES=${VK_DRIVER_FILES:-$("$here/../../tools/setup.sh" lavapipe)}
DRJIT_LIBLLVM_PATH=${DRJIT_LIBLLVM_PATH:-$(ls /usr/lib/*/libLLVM.so.* /usr/lib/*/libLLVM-1[6-9].so* 2>/dev/null | sort -V | tail -n 1)}
THREE_MODULES=$target/three/node_modules
export VK_DRIVER_FILES DRJIT_LIBLLVM_PATH THREE_MODULES
"$target/three/venv/bin/python" "$here/in_three.py" "$folder"
xvfb-run -a "$target/blender/venv/bin/python" "$here/in_blender.py" "$folder" "$("$here/../blender/run.sh" zip)" >"$folder/blender.log" 2>&1
"$target/mitsuba/bin/python" "$here/in_mitsuba.py" "$folder"
"$target/wgpu/bin/python" "$here/in_wgpu.py" "$folder"
"$target/three/venv/bin/python" "$here/compose.py" "$folder"
