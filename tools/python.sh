#!/bin/sh
# The Python module: its wheel, its tests, the blocks of its page.
#   tools/python.sh wheel               a wheel into target/wheels
#   tools/python.sh test [ARGUMENT]...  tests, with the arguments of pytest; e.g. tools/python.sh test -k orders
#   tools/python.sh build               the module for the tests, in target/python
#
# PYTHON names the interpreter, else python3. Packages come from PyPI into target/python-venv. The tests' module stands on the library as all other tests have it.
set -eu
cd "$(dirname "$0")/.."
root=$PWD
PATH=$PATH:${CARGO_HOME:-${HOME:-/root}/.cargo}/bin
target=${CARGO_TARGET_DIR:-$root/target}
venv=$target/python-venv

# environment EXTRA: a virtual environment with the packages of this kind in python/pyproject.toml, made anew where those have changed.
environment() {
    asked=$(cksum <python/pyproject.toml)-$1-$("${PYTHON:-python3}" -V)
    [ -f "$venv/$1" ] && [ "$(cat "$venv/$1")" = "$asked" ] && return
    echo "python: packages from PyPI into $venv" >&2
    if ! "${PYTHON:-python3}" -m venv "$venv"; then
        echo 'python: no virtual environment; apt-get install python3-venv' >&2
        exit 1
    fi
    "$venv/bin/python" - "$1" >"$venv/wanted" <<'END'
import re, sys
text = open("python/pyproject.toml", encoding="utf-8").read()
def listed(name):
    return re.findall(r'"([^"]+)"', re.search(rf"^{name} = \[(.*?)\]", text, re.MULTILINE | re.DOTALL).group(1))
print(*listed("requires"), *listed("dependencies"), *listed(sys.argv[1]), sep="\n")
END
    "$venv/bin/pip" install --quiet --disable-pip-version-check --requirement "$venv/wanted"
    echo "$asked" >"$venv/$1"
}

# build: the module for the tests: links to the Python files and to the built library.
build() {
    PYO3_BUILD_EXTENSION_MODULE=1 PYO3_NO_PYTHON=1 CARGO_TARGET_DIR=$target \
        cargo build --package diffract-python --locked
    mkdir -p "$target/python/diffract"
    for file in "$root"/python/diffract/*; do
        case $file in */__pycache__) ;; *) ln -sf "$file" "$target/python/diffract/" ;; esac
    done
    ln -sf "$target/debug/lib_diffract.so" "$target/python/diffract/_diffract.abi3.so"
}

# wheel: linked by zig against the symbols of an old glibc, so that it installs on most Linux systems of the last ten years. MATURIN_ARGUMENTS replaces that, as
# in MATURIN_ARGUMENTS='--compatibility linux' for this system alone.
wheel() {
    environment wheel
    python3 tools/licences.py x86_64-unknown-linux-gnu python/Cargo.toml >python/LICENCES-OF-CRATES.txt
    # shellcheck disable=SC2086 # words of the user
    PATH=$venv/bin:$PATH "$venv/bin/maturin" build --release --locked --manifest-path python/Cargo.toml --target-dir "$target" \
        --out "$target/wheels" ${MATURIN_ARGUMENTS:---zig --compatibility manylinux2014}
    ls -l "$target/wheels"
}

run_tests() {
    build
    environment test
    driver=$(tools/setup.sh lavapipe)
    cache=$(mktemp -d "${TMPDIR:-/tmp}/diffract-python.XXXXXX")
    trap 'rm -rf "$cache"' EXIT
    trap 'exit 130' INT
    trap 'exit 143' TERM HUP
    # Files of Python are not copied: what is tested is what stands here.
    PYTHONPATH=$target/python PYTHONDONTWRITEBYTECODE=1 XDG_CACHE_HOME=$cache \
        VK_DRIVER_FILES=$driver VK_ICD_FILENAMES=$driver MPLBACKEND=agg \
        "$venv/bin/python" -m pytest --rootdir python -p no:cacheprovider --durations=5 python/tests "$@"
}

case ${1:-} in
wheel) wheel ;;
build) build ;;
test)
    shift
    run_tests "$@"
    ;;
*)
    sed -n '2,5s/^# *//p' "$0" >&2
    exit 2
    ;;
esac
