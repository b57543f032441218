# shellcheck shell=bash disable=SC2034,SC2154 # names shared with setup.sh and the sourcing script
# Sourced by tools/test after setup.sh: makes a local copy of the test framework Unity. The copy comes
# from Debian's source of ntpsec, not from Unity's site. apt checks the archive's signature and
# SHA-256. Every later use checks the unpacked files against their recorded SHA-256.

unity_packages=(ca-certificates tar xz-utils)

# Writes to $1 the deb-src line of this machine's Debian main archive (the security archive may
# lag).
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

# unity_unpack FOLDER: unpacks Unity's files from the archive in the current folder to
# FOLDER/<version of ntpsec>.
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

# unity_folder: prints the folder of an intact copy. Without apt-get it prints nothing, and CMake
# fetches Unity.
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
