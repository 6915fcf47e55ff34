#!/bin/sh
# Gets what diffract needs besides Cargo's crates. A second call only looks, needs no network and changes nothing.
set -u
LC_ALL=C
export LC_ALL

usage() {
    cat <<'END'
usage: tools/setup.sh [build] [run] [test] [python]
       tools/setup.sh lavapipe

  build     what compiling needs: Rust, a C++ compiler, the shaderc library
  run       and what the program needs: the Vulkan loader, a driver, the libraries of a window where there is a display
  test      and what the tests need: Mesa's lavapipe, the Khronos validation layer, Xvfb, sway, wtype, Chromium and the libraries of a window
  python    and what the Python module needs: Python 3.10 or newer, with virtual environments
  lavapipe  install nothing, print the path of lavapipe's driver manifest

What is missing is installed with apt-get where that takes no password; elsewhere the packages are named.
END
}

say() { printf 'setup: %s\n' "$*" >&2; }
have() { command -v "$1" >/dev/null 2>&1; }

root=$(cd "$(dirname "$0")/.." && pwd) || exit 1
cd "$root" || exit 1
PATH=$PATH:${CARGO_HOME:-${HOME:-/root}/.cargo}/bin # where rustup puts cargo, also before the shell knows it

# ---------------------------------------------------------------------------------------------------- Rust

# check_rust: whether there is a Rust that is new enough; says what to do where not.
check_rust() {
    want=$(sed -n 's/^rust-version *= *"\([0-9.]*\)".*/\1/p' Cargo.toml)
    if ! have cargo || ! have rustc; then
        say "no Rust found (cargo, rustc); install Rust $want or newer from https://rustup.rs, then call this again"
        return 1
    fi
    version=$(rustc --version 2>/dev/null)
    version=${version#rustc }
    version=${version%%[ -]*}
    if [ -z "$version" ]; then
        say "rustc is installed but does not start; 'rustup default stable' gives it a toolchain"
        return 1
    fi
    if ! printf '%s\n%s\n' "$want" "$version" | awk -F. '
        { major[NR] = $1 + 0; minor[NR] = $2 + 0 }
        END { exit !(major[2] > major[1] || (major[2] == major[1] && minor[2] >= minor[1])) }'
    then
        say "rustc $version is too old, diffract needs $want or newer; 'rustup update stable' brings it," \
            "or install it from https://rustup.rs"
        return 1
    fi
}

# ---------------------------------------------------------------------------------------------------- shaderc
#
# Debian's shaderc does not link by itself: its libraries leave out glslang and SPIRV-Tools. All of them merged into one
# archive do. .cargo/config.toml points the shaderc crate to that archive; without it the crate builds its own copy.

static_shaderc='libshaderc-dev glslang-dev spirv-tools' # Debian's packages
archive_dir=.deps/shaderc
archive=$archive_dir/libshaderc_combined.a
stamp=$archive_dir/libshaderc_combined.stamp # check sums: of the archive (first line), then of what it was made of
unlinkable=no                                # whether the system's archives turned out not to link

# system_archives: the paths of the archives to merge, one a line; fails where an essential one is missing. The others
# come and go with the version of glslang.
system_archives() {
    have cc || return 1
    for name in +shaderc_combined +glslang +SPIRV-Tools-opt +SPIRV-Tools \
        SPIRV MachineIndependent GenericCodeGen OSDependent OGLCompiler HLSL glslang-default-resource-limits
    do
        path=$(cc -print-file-name="lib${name#+}.a") # the bare name where there is no such file
        if [ -f "$path" ]; then
            printf '%s\n' "$path"
        elif [ "$name" != "${name#+}" ]; then
            return 1
        fi
    done
}

# stamp_of ARCHIVE SOURCES: what the stamp says of an archive made of SOURCES (one path a line).
stamp_of() {
    cksum <"$1" || return 1
    printf '%s\n' "$2" | while IFS= read -r path; do cksum "$path" || return 1; done
}

# intact: whether the merged archive is the one that its stamp describes.
intact() {
    [ -f "$archive" ] && [ -f "$stamp" ] && [ "$(cksum <"$archive")" = "$(sed -n 1p "$stamp")" ]
}

# merge SOURCES: makes the archive and its stamp, in one step each; fails and leaves nothing where it would not link.
merge() {
    if ! mkdir -p "$archive_dir" || ! work=$(mktemp -d "$archive_dir/.merge.XXXXXX"); then
        say "cannot write to $root/$archive_dir; make it writable"
        exit 1
    fi
    trap 'rm -rf "$work"' EXIT
    trap 'exit 130' INT
    trap 'exit 143' TERM HUP
    # ar's scripts know no quoting, so it works on plain names in a folder of its own.
    script='CREATE merged.a'
    count=0
    while IFS= read -r path; do
        count=$((count + 1))
        ln -s "$path" "$work/$count.a" || return 1
        script="$script
ADDLIB $count.a"
    done <<END
$1
END
    merged=no
    if printf '%s\nSAVE\nEND\n' "$script" | (cd "$work" && ar -M) >"$work/log" 2>&1 \
        && links "$work" >>"$work/log" 2>&1 \
        && stamp_of "$work/merged.a" "$1" >"$work/stamp"
    then
        mv "$work/merged.a" "$archive" && mv "$work/stamp" "$stamp" && merged=yes
    else
        say "this system's static shaderc does not link: $(sed -n '$p' "$work/log")"
    fi
    rm -rf "$work"
    trap - EXIT INT TERM HUP
    [ "$merged" = yes ]
}

# links FOLDER: whether a program with the merged archive in FOLDER links and compiles a shader, optimiser included.
links() {
    cat >"$1/probe.cpp" <<'END'
#include <cstddef>
extern "C" {
void *shaderc_compiler_initialize();
void *shaderc_compile_options_initialize();
void shaderc_compile_options_set_optimization_level(void *, int);
void *shaderc_compile_into_spv(void *, const char *, size_t, int, const char *, const char *, void *);
int shaderc_result_get_compilation_status(void *);
}
int main() {
    const char source[] = "#version 450\nlayout(local_size_x = 1) in;\nvoid main() {}\n";
    void *options = shaderc_compile_options_initialize();
    shaderc_compile_options_set_optimization_level(options, 2);
    void *result = shaderc_compile_into_spv(shaderc_compiler_initialize(), source, sizeof source - 1, 2, "probe",
                                            "main", options);
    return shaderc_result_get_compilation_status(result);
}
END
    c++ -o "$1/probe" "$1/probe.cpp" "$1/merged.a" -pthread && "$1/probe"
}

# provide_shaderc: whether the crate will find a shaderc; makes the merged archive where it can.
provide_shaderc() {
    [ -n "${SHADERC_LIB_DIR:-}" ] && return 0 # the caller's own, which Cargo prefers to the project's
    [ "$unlinkable" = yes ] && return 1
    if sources=$(system_archives); then
        if intact && [ "$(stamp_of "$archive" "$sources")" = "$(cat "$stamp")" ]; then return 0; fi
        have ar && have c++ || return 0 # they are noted as missing, and this comes again once they are there
        merge "$sources" && return 0
        unlinkable=yes
    else
        intact && return 0
    fi
    rm -f "$archive" "$stamp" # a damaged archive would stop the crate from building its own
    return 1
}

# ---------------------------------------------------------------------------------------------------- Vulkan

# manifest KIND PATTERN...: the first Vulkan manifest of KIND (icd.d, explicit_layer.d) that fits, in the order of
# PATTERNs, in the folders that the loader searches.
manifest() (
    kind=$1
    shift
    folders=${XDG_CONFIG_DIRS:-/etc/xdg}:/etc:${XDG_DATA_DIRS:-/usr/local/share:/usr/share}
    folders=$folders:${XDG_DATA_HOME:-${HOME:-/root}/.local/share}
    for pattern; do
        set -f
        IFS=:
        for folder in $folders; do
            set +f
            IFS=
            # shellcheck disable=SC2231 # the pattern is one
            for file in "$folder"/vulkan/"$kind"/$pattern; do
                [ -f "$file" ] && printf '%s\n' "$file" && exit 0
            done
        done
    done
    exit 1
)

lavapipe() { manifest icd.d "lvp_icd.$(uname -m).json" lvp_icd.json 'lvp_icd*.json'; }

has_driver() {
    [ -n "${VK_DRIVER_FILES:-}${VK_ICD_FILENAMES:-}${VK_ADD_DRIVER_FILES:-}" ] || manifest icd.d '*.json' >/dev/null
}

has_validation() {
    [ -n "${VK_LAYER_PATH:-}${VK_ADD_LAYER_PATH:-}" ] \
        || manifest explicit_layer.d 'VkLayer_khronos_validation.json' >/dev/null
}

# has_library NAME: whether the dynamic linker knows the library.
has_library() {
    case $libraries in *"$1 "*) return 0 ;; esac
    (
        set -f
        IFS=:
        for folder in ${LD_LIBRARY_PATH:-}; do [ -f "$folder/$1" ] && exit 0; done
        exit 1
    )
}

# ---------------------------------------------------------------------------------------------------- packages

# need WHAT DEBIAN FEDORA ARCH: notes something that is missing and the packages that bring it.
need() {
    missing="${missing:+$missing, }$1"
    debian="$debian $2"
    fedora="$fedora $3"
    arch="$arch $4"
}

# need_x11: notes the libraries that a window on X11 loads.
need_x11() {
    has_library libX11.so.6 || need 'libX11' libx11-6 libX11 libx11
    has_library libX11-xcb.so.1 || need 'libX11-xcb' libx11-xcb1 libX11-xcb libx11
    has_library libXcursor.so.1 || need 'libXcursor' libxcursor1 libXcursor libxcursor
    has_library libXi.so.6 || need 'libXi' libxi6 libXi libxi
    has_library libXrandr.so.2 || need 'libXrandr' libxrandr2 libXrandr libxrandr
    has_library libxkbcommon-x11.so.0 \
        || need 'libxkbcommon-x11' libxkbcommon-x11-0 libxkbcommon-x11 libxkbcommon-x11
}

# collect: fills the lists with what is missing for the purposes that were asked for.
collect() {
    missing='' debian='' fedora='' arch=''
    libraries=$({ ldconfig -p || /sbin/ldconfig -p || /usr/sbin/ldconfig -p; } 2>/dev/null)

    have cc || need 'a C compiler' gcc gcc gcc
    have c++ || need 'a C++ compiler' g++ gcc-c++ gcc
    have ar || need 'ar' binutils binutils binutils
    have make || need 'make' make make make
    shaderc=merged
    if ! provide_shaderc; then
        if [ "$from_source" = no ]; then
            need 'the static libraries of shaderc, glslang and SPIRV-Tools' "$static_shaderc" '' ''
        else
            shaderc=source
            have cmake || need 'cmake' cmake cmake cmake
            have git || need 'git' git git git
            have python3 || have python || need 'python3' python3 python3 python
            have ninja || need 'ninja' ninja-build ninja-build ninja
        fi
    fi

    if [ "$purpose_python" = yes ]; then
        "${PYTHON:-python3}" -c 'import sys, venv, ensurepip; sys.exit(sys.version_info < (3, 10))' 2>/dev/null \
            || need 'Python 3.10 or newer with venv' python3-venv python3 python
    fi
    if [ "$purpose_run" = yes ]; then
        has_library libvulkan.so.1 || need 'the Vulkan loader' libvulkan1 vulkan-loader vulkan-icd-loader
        has_driver || need 'a Vulkan driver' mesa-vulkan-drivers mesa-vulkan-drivers vulkan-swrast
    fi
    if [ "$purpose_window" = yes ]; then
        if [ -n "${WAYLAND_DISPLAY:-}" ]; then
            has_library libwayland-client.so.0 \
                || need 'libwayland-client' libwayland-client0 libwayland-client wayland
            has_library libxkbcommon.so.0 || need 'libxkbcommon' libxkbcommon0 libxkbcommon libxkbcommon
        fi
        [ -n "${DISPLAY:-}" ] && need_x11
    fi
    if [ "$purpose_test" = yes ]; then
        lavapipe >/dev/null \
            || need "lavapipe (Mesa's Vulkan on the CPU)" mesa-vulkan-drivers mesa-vulkan-drivers vulkan-swrast
        has_validation || need 'the Khronos validation layer' \
            vulkan-validationlayers vulkan-validation-layers vulkan-validation-layers
        have Xvfb || need 'Xvfb' xvfb xorg-x11-server-Xvfb xorg-server-xvfb
        have sway || need 'sway, a Wayland compositor' sway sway sway
        have wtype || need 'wtype' wtype wtype wtype
        have chromium || need 'Chromium' chromium chromium chromium
        has_library libwayland-client.so.0 || need 'libwayland-client' libwayland-client0 libwayland-client wayland
        has_library libxkbcommon.so.0 || need 'libxkbcommon' libxkbcommon0 libxkbcommon libxkbcommon
        need_x11
    fi
}

# unique WORD...: the words, each once, in order.
unique() { printf '%s\n' "$@" | awk '!seen[$0]++ { printf "%s%s", sep, $0; sep = " " }'; }

apt_failed=no

# may_install: whether apt-get is here, takes no password and has not failed.
may_install() {
    [ "$apt_failed" = no ] && have apt-get || return 1
    [ "$(id -u)" = 0 ] || { have sudo && sudo -n true 2>/dev/null; }
}

# install PACKAGE...: installs, or says that it failed.
install() {
    say "installing $*"
    as_root=''
    [ "$(id -u)" = 0 ] || as_root='sudo -n'
    # A stale list of packages is worth a try, so a failing update is only told. $as_root is nothing or two words.
    # shellcheck disable=SC2086
    $as_root env DEBIAN_FRONTEND=noninteractive apt-get -qq -o DPkg::Lock::Timeout=120 update </dev/null >&2 \
        || say 'apt-get update failed; going on with the lists that are there'
    # shellcheck disable=SC2086
    $as_root env DEBIAN_FRONTEND=noninteractive apt-get -qq -o DPkg::Lock::Timeout=120 \
        install -y --no-install-recommends "$@" </dev/null >&2 \
        || { say "apt-get could not install $*"; apt_failed=yes; }
}

# try_install: installs what collect noted, where that is allowed, and looks again.
try_install() {
    [ -n "$missing" ] && may_install || return 0
    # shellcheck disable=SC2086,SC2046 # package names, one a word
    install $(unique $debian)
    collect
}

# report: which packages to get, in the words of the system at hand.
report() {
    sudo='sudo '
    [ "$(id -u)" = 0 ] && sudo=''
    say "missing: $missing"
    # shellcheck disable=SC2086 # package names, one a word
    {
        if have apt-get; then
            say "get it with: ${sudo}apt-get install $(unique $debian)"
        else
            say "get it with"
            say "  Debian, Ubuntu: ${sudo}apt-get install $(unique $debian)"
            say "  Fedora:         ${sudo}dnf install $(unique $fedora)"
            say "  Arch:           ${sudo}pacman -S --needed $(unique $arch)"
        fi
    }
    say 'then call this again'
}

# ---------------------------------------------------------------------------------------------------- main

purpose_run=no purpose_window=no purpose_test=no purpose_python=no
[ $# -gt 0 ] || { usage >&2; exit 2; }
for purpose; do
    case $purpose in
        build) ;;
        run)
            purpose_run=yes
            purpose_window=yes
            ;;
        test)
            purpose_run=yes
            purpose_test=yes
            ;;
        python) purpose_python=yes ;;
        lavapipe)
            lavapipe && exit 0
            say "no manifest of lavapipe (vulkan/icd.d/lvp_icd*.json); 'tools/setup.sh test' installs it"
            exit 1
            ;;
        -h | --help | help)
            usage
            exit 0
            ;;
        *)
            say "'$purpose' is none of build, run, test, python, lavapipe"
            usage >&2
            exit 2
            ;;
    esac
done

# Where the system has no static shaderc, the crate's own copy is built: on what is not Debian or its kin, and on
# versions of them whose packages leave the archives out.
from_source=no
# shellcheck disable=SC2086 # package names, one a word
if ! have apt-get || { have cc && dpkg -s $static_shaderc && ! system_archives; } >/dev/null 2>&1; then
    from_source=yes
fi
collect
if ! check_rust; then
    if [ -n "$missing" ] && ! may_install; then report; fi
    exit 1
fi
try_install
if [ -n "$missing" ] && [ "$from_source" = no ] && ! provide_shaderc; then
    from_source=yes
    collect
    try_install
    # The packages are the better advice where the tools for the long way are missing as well.
    if [ -n "$missing" ] && [ "$unlinkable" = no ]; then
        from_source=no
        collect
    fi
fi
if [ -n "$missing" ]; then
    report
    exit 1
fi
if [ "$shaderc" = source ]; then
    say "no static shaderc here that links (Debian 12 has one in $static_shaderc), so the first build compiles" \
        "its own: about 17 minutes on two cores, with cmake, git, python3 and ninja"
fi
exit 0
