# shellcheck shell=bash disable=SC2034,SC2154 # names shared with the script that sources this and with setup.sh
# Sourced by tools/test after setup.sh: a local copy of the test framework Unity, without a visit to its own site.
# Debian carries it inside the source of ntpsec. apt checks the archive's signature and SHA-256; the unpacked files are
# checked against their recorded SHA-256 at every later use.

unity_packages=(ca-certificates tar xz-utils)

# The deb-src twin of the Debian main archive in this machine's own sources (the security archive may lag), in $1.
write_source_list() {
    apt-get indextargets --format "\$(REPO_URI) \$(RELEASE) \$(COMPONENT)" "Created-By: Packages" "Origin: Debian" "Label: Debian" |
        sort -u | sed 's/^/deb-src /' >"$1"
}

# unity_source: downloads ntpsec's source into the current folder.
unity_source() {
    local state=$PWD/apt keyring
    mkdir -p "$state/lists/partial" "$state/cache/archives/partial"
    write_source_list "$state/sources.list"
    [[ -s $state/sources.list ]] || { apt-get update -q && write_source_list "$state/sources.list"; }
    for keyring in /usr/share/keyrings/debian-archive-keyring.{gpg,pgp}; do
        [[ -e $keyring ]] && sed -i "s|^deb-src|deb-src [signed-by=$keyring]|" "$state/sources.list" && break
    done
    local options=(-q -o "Dir::Etc::sourcelist=$state/sources.list" -o Dir::Etc::sourceparts=-
        -o "Dir::State::lists=$state/lists" -o "Dir::Cache=$state/cache" -o APT::Sandbox::User=root)
    apt-get "${options[@]}" update && apt-get "${options[@]}" source --download-only ntpsec
}

# unity_unpack FOLDER: takes Unity's files out of the archive in the current folder into FOLDER/<version of ntpsec>.
unity_unpack() {
    local archive version folder
    archive=$(echo ntpsec_*.orig.tar.*z)
    version=${archive#ntpsec_} version=${version%%.orig*}
    folder=$1/ntpsec-$version
    mkdir -p "$folder"
    tar --no-same-owner -xf "$archive" -C "$folder" --wildcards --strip-components=3 \
        '*/tests/unity/unity.c' '*/tests/unity/unity.h' '*/tests/unity/unity_internals.h'
    (cd "$folder" && sha256sum unity*.[ch] >SHA256SUMS)
}

unity_download() {
    local work status=0
    work=$(mktemp -d "$root/build/cache/download.XXXXXX")
    (cd "$work" && unity_source && unity_unpack "$1") || status=1
    rm -rf "$work"
    return $status
}

# unity_folder: prints the folder of an intact copy; nothing (and CMake will fetch it) on a machine without apt-get.
unity_folder() {
    local cache=$root/build/cache/unity sums
    if [[ -n ${DAVAR_UNITY_DIR:-} ]]; then
        echo "$DAVAR_UNITY_DIR"
        return
    fi
    command -v apt-get >/dev/null || return 0
    mkdir -p "$cache"
    if ! compgen -G "$cache/*/SHA256SUMS" >/dev/null; then
        note "fetching Unity (once, into build/cache)"
        quietly unity.log unity_download "$cache" || die "could not fetch Unity; set DAVAR_UNITY_DIR to a copy of it"
    fi
    sums=$(compgen -G "$cache/*/SHA256SUMS" | head -1)
    (cd "${sums%/*}" && sha256sum --quiet -c SHA256SUMS) >&2 || die "damaged: ${sums%/*}; remove it and run again"
    echo "${sums%/*}"
}
