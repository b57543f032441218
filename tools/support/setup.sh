# shellcheck shell=bash
# Sourced by the tools: installs the packages that a build needs, and builds quietly.
# On a complete machine it prints and downloads nothing.

unset CDPATH
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
logs=$root/build/log
mkdir -p "$logs"

die() {
    printf '%s: %s\n' "${0##*/}" "$*" >&2
    exit 2
}

note() { printf '%s: %s\n' "${0##*/}" "$*" >&2; }

# quietly LOG COMMAND...: writes all output to build/log/LOG and shows it only if the command fails.
quietly() {
    local log=$logs/$1
    shift
    "$@" >"$log" 2>&1 && return 0
    cat "$log" >&2
    return 1
}

compiles() { echo 'int main(void) { return 0; }' | gcc "$@" -x c -o /dev/null - >/dev/null 2>&1; }
includes() { gcc -fsyntax-only -include "$1" -x c /dev/null >/dev/null 2>&1; }

# have PACKAGE: true if the machine has the contents of this Debian package, from any source.
have() {
    case $1 in
    libc6-dev) compiles -include stdio.h ;;
    zlib1g-dev) includes zlib.h ;;
    gcc-12-multilib) compiles -m32 -include stdio.h ;;
    python3-venv) python3 -c 'import ensurepip, venv' >/dev/null 2>&1 ;;
    libgpiod-dev) includes gpiod.h ;;
    linux-source-6.1) [[ -e /usr/src/linux-source-6.1.tar.xz ]] && dpkg-query --show "$1" >/dev/null 2>&1 ;;
    can-utils) command -v candump >/dev/null ;;
    nodejs) command -v node >/dev/null ;;
    gpiod) command -v gpiomon >/dev/null ;;
    iproute2) command -v ip >/dev/null ;;
    xz-utils) command -v xz >/dev/null ;;
    gcc-arm-none-eabi) command -v arm-none-eabi-gcc >/dev/null ;;
    libnewlib-arm-none-eabi) arm-none-eabi-gcc --specs=nano.specs -E -include string.h -x c /dev/null >/dev/null 2>&1 ;;
    gcc-riscv64-unknown-elf) command -v riscv64-unknown-elf-gcc >/dev/null ;;
    picolibc-riscv64-unknown-elf) riscv64-unknown-elf-gcc --specs=picolibc.specs -E -x c /dev/null >/dev/null 2>&1 ;;
    qemu-system-misc) command -v qemu-system-riscv32 >/dev/null ;;
    gcc-aarch64-linux-gnu) command -v aarch64-linux-gnu-gcc >/dev/null ;;
    gcc-riscv64-linux-gnu) command -v riscv64-linux-gnu-gcc >/dev/null ;;
    libc6-dev-arm64-cross) [[ -e /usr/aarch64-linux-gnu/lib/libc.a ]] ;;
    libc6-dev-riscv64-cross) [[ -e /usr/riscv64-linux-gnu/lib/libc.a ]] ;;
    qemu-user) command -v qemu-aarch64 >/dev/null ;;
    dpkg-dev) command -v dpkg-shlibdeps >/dev/null ;;
    libclang-rt-14-dev) compgen -G "/usr/lib/llvm-14/lib/clang/14*/lib/linux/libclang_rt.fuzzer-*.a" >/dev/null ;;
    libclang-rt-19-dev) compgen -G "/usr/lib/llvm-19/lib/clang/19*/lib/linux/libclang_rt.profile-*.a" >/dev/null ;;
    llvm-19) command -v llvm-cov-19 >/dev/null ;;
    frama-c-base) command -v frama-c >/dev/null ;;
    ca-certificates) [[ -e /etc/ssl/certs/ca-certificates.crt ]] ;;
    *) command -v "$1" >/dev/null ;;
    esac
}

# Packages for the emulated boards, bare ones and those with Linux.
export target_packages=(gcc-arm-none-eabi libnewlib-arm-none-eabi qemu-system-arm gcc-riscv64-unknown-elf
    picolibc-riscv64-unknown-elf qemu-system-misc gcc-aarch64-linux-gnu libc6-dev-arm64-cross gcc-riscv64-linux-gnu
    libc6-dev-riscv64-cross qemu-user)

# need PACKAGE...: installs missing packages, or lists them and exits. DAVAR_SEEN: packages that
# tools/test has already checked, so that the thousand commands of a test run do not check them
# again.
need() {
    local package missing=()
    for package; do
        [[ " ${DAVAR_SEEN:-} ${missing[*]} " == *" $package "* ]] || have "$package" || missing+=("$package")
    done
    ((${#missing[@]})) || return 0
    if ((EUID != 0)) || ! command -v apt-get >/dev/null; then
        die "missing Debian packages: ${missing[*]} (install them, or run this as root on Debian)"
    fi
    note "installing ${missing[*]}"
    quietly apt-update.log apt-get update -q || die "apt-get update failed"
    DEBIAN_FRONTEND=noninteractive quietly apt-install.log \
        apt-get install -qy --no-install-recommends "${missing[@]}" || die "could not install ${missing[*]}"
}

# current PRESET TARGET: true if no source or build file has changed since `build` made this target.
# Under tools/test, which builds everything first (DAVAR_BUILT), every target that exists is current.
current() {
    local stamp=$root/build/$1/built-${2:-all}
    [[ -e $stamp ]] || return 1
    [[ -z ${DAVAR_BUILT:-} ]] || return 0
    [[ -z $(cd "$root" && find CMakeLists.txt CMakePresets.json cmake lib addons port host_sim gateway python tools/plan \
        tests/CMakeLists.txt bench tests/bench packaging/debian \
        \( -type d -o -name '*.[ch]' -o -name '*.inc' -o -name 'CMake*' -o -name '*.cmake' \) \
        -not -name __pycache__ -newer "$stamp" -print -quit) ]]
}

# build PRESET [TARGET]: builds a target that is not current, and prints output only on failure. It
# configures once, and again if the top CMakeLists.txt or the presets are newer, because they may add
# a target. Concurrent calls run one after the other.
build() {
    current "$@" && return
    need gcc libc6-dev make cmake zlib1g-dev
    (
        cd "$root" || exit
        ! command -v flock >/dev/null || flock 9
        current "$@" && exit # another call built it
        [[ -e build/$1/configured && ! CMakeLists.txt -nt build/$1/configured &&
            ! CMakePresets.json -nt build/$1/configured ]] || {
            quietly "configure-$1.log" cmake --preset "$1" ${DAVAR_UNITY_DIR:+"-DDAVAR_UNITY_DIR=$DAVAR_UNITY_DIR"} && touch "build/$1/configured"
        } || exit
        touch "build/$1/building" # before the build: a source that changes meanwhile is newer
        quietly "build-$1.log" cmake --build --preset "$1" --parallel "$(nproc)" ${2:+--target "$2"} &&
            touch -r "build/$1/building" "build/$1/built-${2:-all}"
    ) 9>"$logs/lock"
}

make_python_environment() {
    rm -rf "$1"
    python3 -m venv "$1" && "$1/bin/pip" install --disable-pip-version-check --no-compile --no-deps -r "$2" &&
        cp "$2" "$1/requirements.txt"
}

# python_environment NAME REQUIREMENTS: prints the Python of build/NAME. Makes the environment if it
# is missing or the pins have changed. Concurrent calls run one after the other.
python_environment() {
    local folder=$root/build/$1
    if ! cmp -s "$2" "$folder/requirements.txt"; then
        need python3-venv
        (
            ! command -v flock >/dev/null || flock 9
            cmp -s "$2" "$folder/requirements.txt" && exit # another call made it
            note "making build/$1 (once)"
            quietly "$1.log" make_python_environment "$folder" "$2" 9>&-
        ) 9>"$logs/$1.lock" || return 1
    fi
    echo "$folder/bin/python"
}

# npm has certificates of its own; a proxy has one of the system's.
make_node_packages() {
    local system=/etc/ssl/certs/ca-certificates.crt
    if [[ -z ${NODE_EXTRA_CA_CERTS:-} && -e $system ]]; then
        export NODE_EXTRA_CA_CERTS=$system
    fi
    rm -rf "$2" && mkdir "$2" && cp "$1"/package*.json "$2" &&
        npm ci --prefix "$2" --ignore-scripts --no-audit --no-fund && touch "$2/complete"
}

# node_packages: prints build/npm, which has the programs of tools/support/npm. Makes it if it is
# missing or the pins have changed. Concurrent calls run one after the other.
node_packages() {
    local pins=$root/tools/support/npm folder=$root/build/npm
    made() { [[ -e $folder/complete ]] && cmp -s "$pins/package-lock.json" "$folder/package-lock.json"; }
    if ! made; then
        need nodejs npm
        (
            ! command -v flock >/dev/null || flock 9
            made && exit # another call made it
            note "making build/npm (once)"
            quietly npm.log make_node_packages "$pins" "$folder" 9>&-
        ) 9>"$logs/npm.lock" || return 1
    fi
    echo "$folder"
}
