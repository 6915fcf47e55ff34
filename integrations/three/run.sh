#!/bin/sh
# Draws by the module in headless Chromium and compares with diffract, or serves the example.
#   integrations/three/run.sh                   the tests: some minutes on slow cores
#   integrations/three/run.sh serve FOLDER      http://localhost:8000/?export=skin with the export FOLDER
# DIFFRACT names the program, else target/release/diffract. Node's npm brings three.js into target/three.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
place=${THREE_PLACE:-$here/../../target/three}
mkdir -p "$place"
place=$(cd "$place" && pwd)
three=0.187.0
if ! grep -qs "\"version\": \"$three\"" "$place/node_modules/three/package.json"; then
    npm install --silent --no-save --prefix "$place" "three@$three"
fi
case ${1:-} in
serve)
    export=$(cd "$2" && pwd)
    served=$(mktemp -d)
    trap 'rm -rf "$served"' EXIT INT TERM
    ln -s "$here/index.html" "$here/diffract.js" "$place/node_modules" "$served/"
    ln -s "$export" "$served/skin"
    cd "$served"
    python3 -m http.server
    ;;
'')
    [ -x "$place/venv/bin/python" ] || python3 -m venv "$place/venv"
    "$place/venv/bin/pip" install --quiet --requirement "$here/requirements.txt"
    cd "$here"
    THREE_MODULES=$place/node_modules exec "$place/venv/bin/python" -m unittest test_three
    ;;
*)
    sed -n '2,5s/^# *//p' "$0" >&2
    exit 2
    ;;
esac
