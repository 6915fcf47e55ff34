#!/bin/sh
# Makes the extension, or uses it in Blender as a Python module and compares its pictures with those of diffract.
#   integrations/blender/run.sh zip [FILE]     the extension as a zip, target/blender/diffract.zip
#   integrations/blender/run.sh                the tests: some minutes on slow cores; needs python3.11 and 1 GB
# DIFFRACT names the program, else target/release/diffract.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
place=${BLENDER_PLACE:-$here/../../target/blender}
mkdir -p "$place"
place=$(cd "$place" && pwd)
zip=$place/diffract.zip
case ${1:-} in
zip)
    zip=${2:-$zip}
    ;;
'') ;;
*)
    sed -n '2,5s/^# *//p' "$0" >&2
    exit 2
    ;;
esac
python3 - "$here/diffract" "$zip" <<'PYTHON'
import pathlib, sys, zipfile
folder, out = map(pathlib.Path, sys.argv[1:])
with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
    for file in sorted(folder.iterdir()):
        if file.suffix in (".py", ".osl", ".toml"):
            archive.write(file, file.name)
PYTHON
if [ -n "${1:-}" ]; then
    echo "$zip"
    exit
fi
[ -x "$place/venv/bin/python" ] || python3.11 -m venv "$place/venv"
"$place/venv/bin/pip" install --quiet --requirement "$here/requirements.txt"
cd "$here"
DIFFRACT_ZIP=$zip exec "$place/venv/bin/python" -m unittest "${TESTS:-test_blender}"
