#!/bin/sh
# Runs the commands of the book (docs/) and draws its pictures.
#   tools/book.sh [--quick] [PAGE]...     e.g. tools/book.sh docs/START.md README.md
#
# Pages are those of docs/SUMMARY.md and README.md, unless some are named. The blocks of a page run one after the other in a
# scratch folder of their own, which has links to assets/, integrations/ and tools/, with a cache that starts empty:
#
#   ```sh          commands; each block must succeed
#   ```sh,slow     the same, left out by --quick
#   ```sh,fetch    the same; its first command, a download, may fail: then the block is left out, and its picture stays as it is
#   ```text        the output of the commands of the block before; a line that is … stands for any lines
#   ```console     commands that are shown alone: they need a window or other files
#   ```python      of docs/PYTHON.md: run as one program where the module `diffract` is installed, but not by --quick
#
# A picture `images/NAME` of a page is the file NAME that its commands draw, copied to docs/images and made small.
# --quick copies nothing, compares docs/COMMANDS.md with the help of the program, and is what a test runs.
#
# DIFFRACT names the program, else target/release/diffract. Without VK_DRIVER_FILES pictures are drawn on lavapipe.
set -eu
cd "$(dirname "$0")/.."
root=$PWD
quick=no
[ "${1:-}" = --quick ] && { quick=yes; shift; }

# require COMMAND PACKAGE: ends where a command is missing, and names Debian's package.
require() {
    command -v "$1" >/dev/null 2>&1 && return
    echo "book: $1 is missing; apt-get install $2" >&2
    exit 1
}

require python3 python3
if [ "$quick" = no ]; then
    require Xvfb xvfb
    require xdotool xdotool
    require img2webp webp
    if ! python3 -c 'import PIL' 2>/dev/null; then
        echo 'book: Pillow is missing; apt-get install python3-pil' >&2
        exit 1
    fi
fi

program=${DIFFRACT:-$root/target/release/diffract}
if [ ! -x "$program" ]; then
    echo "book: no program at $program; make build makes it" >&2
    exit 1
fi
scratch=$(mktemp -d "${TMPDIR:-/tmp}/diffract-book.XXXXXX")
trap 'rm -rf "$scratch"' EXIT
trap 'exit 130' INT
trap 'exit 143' TERM HUP
mkdir "$scratch/bin" "$scratch/cache" "$scratch/state"
ln -s "$program" "$scratch/bin/diffract"
export PATH="$scratch/bin:$PATH" XDG_CACHE_HOME="$scratch/cache" XDG_STATE_HOME="$scratch/state"
if [ -z "${VK_DRIVER_FILES:-}" ]; then
    VK_DRIVER_FILES=$(tools/setup.sh lavapipe)
    export VK_DRIVER_FILES VK_ICD_FILENAMES="$VK_DRIVER_FILES"
fi

# Pictures that no command of a page draws: src/cli/surface/worked_example.rs (DIFFRACT_BLESS=1), tools/validity/figure.py, tests/gpu/long_run.rs,
# integrations/mitsuba (render.py, compare.py).
elsewhere='preparing.png validity.png long-run.svg mitsuba.webp export-plates.png elsewhere.webp'

# pages: README.md and the pages that docs/SUMMARY.md links to, once each.
pages() {
    echo README.md
    sed -n 's/.*](\([A-Za-z0-9_/.-]*\.md\)).*/docs\/\1/p' docs/SUMMARY.md | awk '!seen[$0]++'
}

# blocks PAGE FOLDER: writes each fenced block of the kinds above to FOLDER/NNN.KIND; its first line is its line in the page.
blocks() {
    awk -v folder="$2" '
        /^```/ && inside { close(file); inside = 0; next }
        inside { print > file; next }
        /^```(sh|sh,slow|sh,fetch|text|console)$/ {
            kind = substr($0, 4)
            sub(",", "-", kind)
            file = sprintf("%s/%03d.%s", folder, ++count, kind)
            print NR > file
            inside = 1
            next
        }
        /^```/ { file = "/dev/null"; inside = 1 }
    ' "$1"
}

# matches PATTERN OUTPUT: succeeds if the lines are the same, where a line of PATTERN that is … stands for any lines.
matches() {
    awk '
        NR == FNR { pattern[++n] = $0; next }
        { output[++m] = $0 }
        END {
            at = 1
            skipping = 0
            for (i = 1; i <= n; i++) {
                if (pattern[i] == "…") { skipping = 1; continue }
                while (skipping && at <= m && output[at] != pattern[i]) at++
                if (at > m || output[at] != pattern[i]) exit 1
                at++
                skipping = 0
            }
            exit !(skipping || at > m)
        }
    ' "$1" "$2"
}

# fail BLOCK MESSAGE: names the page and the line of a block, and ends.
fail() {
    echo "book: $page, line $(sed -n 1p "$1"): $2" >&2
    exit 1
}

# fetch BLOCK FOLDER: runs the first line of a block, a download; where it fails, says so and keeps the pictures that the block draws.
fetch() {
    (cd "$2/work" && sed -n 1p ../body | sh -eu) >"$2/printed" 2>"$2/told" && return
    echo "book: $page, line $(sed -n 1p "$1"): left out, the download fails: $(tail -n 1 "$2/told")" >&2
    sed -n 's/.* -o \([A-Za-z0-9_.-]*\.png\).*/\1/p' "$2/body" >>"$scratch/drawn"
    return 1
}

# run_python PAGE FOLDER: runs the blocks of Python of a page as one program. Where the module is not installed, says so and keeps the pictures that they draw.
run_python() {
    awk '/^```python$/ { inside = 1; next } /^```/ { inside = 0 } inside' "$1" >"$2/page.py"
    if ! python3 -c 'import diffract, matplotlib, joblib, dask.distributed, SurfaceTopography' 2>/dev/null; then
        echo "book: $1: Python is left out, the wheel or a package is missing: pip install target/wheels/*.whl" >&2
        grep -o '[A-Za-z0-9_-]*\.png' "$2/page.py" >>"$scratch/drawn"
        return
    fi
    # Not from a file, which processes that it starts would run again.
    if ! (cd "$2/work" && MPLBACKEND=agg python3 -c "$(cat ../page.py)") >"$2/printed" 2>"$2/told"; then
        cat "$2/told" >&2
        echo "book: $1: its blocks of Python fail" >&2
        exit 1
    fi
}

# run_page PAGE: runs the blocks of a page in order, and compares what they print.
run_page() {
    page=$1
    place=$scratch/$(echo "$page" | tr / -)
    mkdir -p "$place/blocks" "$place/work"
    blocks "$page" "$place/blocks"
    ln -s "$root/assets" "$root/integrations" "$root/tools" "$place/work/"
    printed=
    begin=$(date +%s)
    for block in "$place"/blocks/*; do
        [ -e "$block" ] || continue
        sed 1d "$block" >"$place/body"
        case $block in
        *.sh-slow | *.sh-fetch | *.sh)
            printed=
            case $block,$quick in *.sh-slow,yes | *.sh-fetch,yes) continue ;; esac
            case $block in *.sh-fetch)
                fetch "$block" "$place" || continue
                sed 2d "$block" | sed 1d >"$place/body"
                ;;
            esac
            if ! (cd "$place/work" && sh -eu "$place/body") >"$place/printed" 2>"$place/told"; then
                cat "$place/told" >&2
                fail "$block" 'a command of this block fails'
            fi
            printed=$place/printed
            ;;
        *.text)
            [ -n "$printed" ] || continue
            cat "$place/told" >>"$printed"
            if ! matches "$place/body" "$printed"; then
                diff "$place/body" "$printed" >&2 || true
                fail "$block" 'the commands before print something else'
            fi
            printed=
            ;;
        esac
    done
    case $page,$quick in docs/PYTHON.md,no) run_python "$page" "$place" ;; esac
    [ "$quick" = yes ] || pictures "$page" "$place/work"
    rm -rf "$place"
    echo "$page: $(($(date +%s) - begin)) s"
}

# pictures PAGE FOLDER: copies what the page shows and its commands drew; names what a page shows and nothing drew.
pictures() {
    for picture in $(grep -o '](\(docs/\)\{0,1\}images/[A-Za-z0-9_.-]*' "$1" | sed 's/.*images\///' | sort -u); do
        if [ -f "$2/$picture" ]; then
            case $picture in
            *.png) python3 tools/shrink.py "$2/$picture" "docs/images/$picture" ;;
            *) cp "$2/$picture" docs/images/ ;;
            esac
            echo "$picture" >>"$scratch/drawn"
        else
            echo "$1: images/$picture" >>"$scratch/shown"
        fi
    done
}

# commands: the page of the commands, from the program's help.
commands() {
    cat <<'END'
# Commands

This page is the help of the program, `diffract help COMMAND`. `diffract completions SHELL` prints completions for a shell,
`diffract manual FOLDER` writes pages for `man`.
END
    for command in view render eval brdf orders export peaks profile trade 'surface info' 'surface synth' 'surface convert' lights cache devices; do
        printf '\n## diffract %s\n\n```help\n' "$command"
        # shellcheck disable=SC2086 # two words
        diffract help $command | sed 's/[[:space:]]*$//'
        printf '```\n'
    done
}

commands >"$scratch/COMMANDS.md"
if [ "$quick" = no ]; then
    cp "$scratch/COMMANDS.md" docs/COMMANDS.md
elif ! diff docs/COMMANDS.md "$scratch/COMMANDS.md" >&2; then
    echo 'book: docs/COMMANDS.md is not the help of the program; tools/book.sh docs/COMMANDS.md writes it' >&2
    exit 1
fi

start=$(date +%s)
if [ $# -gt 0 ]; then
    for page; do run_page "$page"; done
else
    for page in $(pages); do run_page "$page"; done
fi
if [ "$quick" = no ] && [ $# = 0 ]; then
    # A picture may stand in several pages; one of them has its command.
    if [ -f "$scratch/shown" ]; then
        # shellcheck disable=SC2086 # one a line
        printf '%s\n' $elsewhere >>"$scratch/drawn"
        missing=$(grep -vFf "$scratch/drawn" "$scratch/shown" || true)
        if [ -n "$missing" ]; then
            printf 'book: no command of these pages draws what they show:\n%s\n' "$missing" >&2
            exit 1
        fi
    fi
fi
echo "book: all commands ran in $(($(date +%s) - start)) s; CPU time of the shell and of the commands:"
times
