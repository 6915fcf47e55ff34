#!/bin/sh
# Builds an archive for x86-64 Linux: the program with completions, pages for man, and the licences of what it links.
#   tools/release.sh [FOLDER]     into target/archive unless a folder is named
#
# DIFFRACT names a program that is built already. The same program and commit give the same archive, byte by byte. The program
# asks for a C library as new as that of the machine that builds it, and finds Vulkan when it runs.
set -eu
cd "$(dirname "$0")/.."
PATH=$PATH:${CARGO_HOME:-${HOME:-/root}/.cargo}/bin
target=x86_64-unknown-linux-gnu
folder=${1:-target/archive}

case $(uname -sm) in
'Linux x86_64') ;;
*)
    echo "release: this is $(uname -sm), and the archive is for x86-64 Linux" >&2
    exit 1
    ;;
esac
if [ -z "${DIFFRACT:-}" ]; then
    tools/setup.sh build
    cargo build --release --locked
    DIFFRACT=${CARGO_TARGET_DIR:-target}/release/diffract
fi

version=$("$DIFFRACT" --version | cut -d' ' -f2)
name=diffract-$version-$target
scratch=$(mktemp -d "${TMPDIR:-/tmp}/diffract-release.XXXXXX")
trap 'rm -rf "$scratch"' EXIT
trap 'exit 130' INT
trap 'exit 143' TERM HUP
content=$scratch/$name
mkdir -p "$content/bin" "$content/share/man/man1" "$content/share/bash-completion/completions" \
    "$content/share/zsh/site-functions" "$content/share/fish/vendor_completions.d" "$folder"

cp "$DIFFRACT" "$content/bin/diffract"
strip --strip-debug "$content/bin/diffract"
chmod 755 "$content/bin/diffract"
"$DIFFRACT" manual "$content/share/man/man1"
"$DIFFRACT" completions bash >"$content/share/bash-completion/completions/diffract"
"$DIFFRACT" completions zsh >"$content/share/zsh/site-functions/_diffract"
"$DIFFRACT" completions fish >"$content/share/fish/vendor_completions.d/diffract.fish"
cp README.md CHANGELOG.md CITATION.cff LICENSE-APACHE LICENSE-MIT "$content"
python3 tools/licences.py "$target" >"$content/THIRD-PARTY-LICENCES.txt"

# Times, owners and order do not depend on who packs.
tar --sort=name --owner=0 --group=0 --numeric-owner --mode=u=rwX,go=rX --mtime="@$(git log -1 --format=%ct)" \
    -C "$scratch" -cf - "$name" | gzip -9n >"$scratch/$name.tar.gz"
(cd "$scratch" && sha256sum "$name.tar.gz" >"$name.tar.gz.sha256")
mv "$scratch/$name.tar.gz" "$scratch/$name.tar.gz.sha256" "$folder"
echo "$folder/$name.tar.gz"
