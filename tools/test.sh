#!/bin/sh
# All tests on Mesa's lavapipe, with the validation layer on and a cache that starts empty.
#   tools/test.sh [ARGUMENT OF cargo test]...     e.g. tools/test.sh --test gpu
#
# One profile serves here, for `make run`, clippy and rustdoc: dev, which optimises the crates fully, diffract itself enough for
# its sums, and keeps the checks of overflow and of debug_assert that release drops.
set -eu
cd "$(dirname "$0")/.."
PATH=$PATH:${CARGO_HOME:-${HOME:-/root}/.cargo}/bin

driver=$(tools/setup.sh lavapipe)
cache=$(mktemp -d "${TMPDIR:-/tmp}/diffract-test.XXXXXX")
trap 'rm -rf "$cache"' EXIT
trap 'exit 130' INT
trap 'exit 143' TERM HUP

export VK_DRIVER_FILES="$driver" # what loaders since 1.3.207 read
export VK_ICD_FILENAMES="$driver" # what older ones read
export DIFFRACT_VALIDATION=1
export XDG_CACHE_HOME="$cache"
# Tests of the program wait for its processes, windows and displays. More tests at once than cores keep the cores busy meanwhile.
cores=$(getconf _NPROCESSORS_ONLN)
export RUST_TEST_THREADS="${RUST_TEST_THREADS:-$((2 * cores))}"
# Prints the slowest tests of each executable.
host=$(rustc -vV | sed -n 's/^host: //p' | tr 'a-z-' 'A-Z_')
export "CARGO_TARGET_${host}_RUNNER=$PWD/tools/timed.sh"
cargo test --locked "$@"
