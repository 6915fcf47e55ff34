#!/bin/sh
# Builds diffract and shows it: a window where there is a display, a picture in a file elsewhere.
#   tools/run.sh [ARGUMENT OF diffract view OR render]...
set -eu
cd "$(dirname "$0")/.."
PATH=$PATH:${CARGO_HOME:-${HOME:-/root}/.cargo}/bin

# The profile of the tests, so that nothing is built twice; it is as fast as release.
cargo build --locked
diffract=${CARGO_TARGET_DIR:-target}/debug/diffract
if [ -n "${DISPLAY:-}${WAYLAND_DISPLAY:-}" ] && "$diffract" --help | grep -Eq '^ +view( |$)'; then
    exec "$diffract" view "$@"
fi
"$diffract" render -o diffract.png "$@"
echo "The picture is in $(pwd)/diffract.png"
