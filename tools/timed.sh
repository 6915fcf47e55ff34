#!/bin/sh
# Runs a test executable with its arguments, and prints its ten slowest tests behind its output.
#   tools/timed.sh EXECUTABLE [ARGUMENT]...
#
# tools/test.sh names this to cargo as the runner of what it builds. Times are an unstable option of libtest, which stable Rust takes where RUSTC_BOOTSTRAP
# is set. It is set for the executable alone: for a build it would be another compiler, and everything would be built anew.
set -u
case $1 in
    */deps/*) ;;
    *) exec "$@" ;; # examples and tests of documentation
esac
case " $* " in
    *" --list "* | *" --help "*) exec "$@" ;;
esac
output=$(mktemp "${TMPDIR:-/tmp}/diffract-times.XXXXXX") || exit 1
trap 'rm -f "$output" "$output.code"' EXIT
{
    RUSTC_BOOTSTRAP=1 "$@" -Zunstable-options --report-time
    echo $? >"$output.code"
} | tee "$output"
code=$(cat "$output.code")
# test NAME ... ok <1.234s>
sed -n 's/^test \(.*\) \.\.\. .* <\([0-9.]*\)s>$/\2 \1/p' "$output" | sort -rn | head -n 10 |
    awk 'NR == 1 { print "slowest tests, in seconds, beside all others that ran at the same time:" } { printf "%9.1f  %s\n", $1, $2 }'
exit "${code:-1}"
