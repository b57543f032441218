#!/usr/bin/env bash
# Builds, once, the User-Mode Linux kernel of the kernel tests: CAN, gpio-sim and virtual time, which Debian's own
# user-mode-linux lacks. usage: kernel.sh CACHE_FOLDER. Prints the path of the kernel. 4 to 13 minutes on two cores; later
# runs find it in CACHE_FOLDER, keyed by the package version, the configuration, the patch and this script.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
config=$here/kernel.config
patch=$here/kernel.patch
source_archive=/usr/src/linux-source-6.1.tar.xz

die() {
    printf 'kernel.sh: %s\n' "$*" >&2
    exit 2
}

cache_key() {
    local version
    version=$(dpkg-query --showformat '${Version}' --show linux-source-6.1 2>/dev/null) || die "missing: linux-source-6.1"
    printf '%s-%s\n' "$version" "$(cat "$config" "$patch" "$here/kernel.sh" | sha256sum | cut -c1-12)"
}

configure() {
    local line
    make ARCH=um "O=$1" tinyconfig
    cat "$config" >>"$1/.config"
    make ARCH=um "O=$1" olddefconfig
    while read -r line; do
        grep -qxF "$line" "$1/.config" || die "not set: $line"
    done < <(grep '^CONFIG' "$config")
}

# In the current folder, which is thrown away afterwards.
build() {
    tar -xf "$source_archive"
    cd linux-source-6.1
    patch --strip=1 --fuzz=0 <"$patch" || die "kernel.patch does not fit this source"
    configure ../out
    make ARCH=um O=../out "-j$(nproc)" linux
    strip -o ../linux ../out/linux
}

[[ $# -eq 1 ]] || die "usage: kernel.sh CACHE_FOLDER"
mkdir -p "$1"
cache=$(cd "$1" && pwd)
kernel=$cache/linux-$(cache_key)
if [[ ! -x $kernel ]]; then
    work=$(mktemp -d "$cache/build.XXXXXX")
    trap 'rm -rf "$work"' EXIT
    (cd "$work" && build) >"$cache/build.log" 2>&1 || { tail -30 "$cache/build.log" >&2 && die "the kernel does not build; see $cache/build.log"; }
    mv "$work/linux" "$kernel"
fi
printf '%s\n' "$kernel"
