"""The bill of materials of a release, as SPDX 2.3: every package, the files in it, and what it
needs. Standard library only.
"""

import hashlib
import io
import subprocess
import tarfile
import time
import zipfile
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

Json = dict[str, Any]


def contents(package: Path) -> Iterator[tuple[str, bytes]]:
    """(name, bytes) of the files in a package, in the order of their names."""
    if package.suffix in (".zip", ".pack"):
        with zipfile.ZipFile(package) as archive:
            yield from ((name, archive.read(name)) for name in sorted(archive.namelist()))
        return
    packed = (
        io.BytesIO(subprocess.check_output(["dpkg-deb", "--fsys-tarfile", str(package)]))
        if package.suffix == ".deb"
        else package.open("rb")
    )
    with packed, tarfile.open(fileobj=packed) as archive:
        for entry in sorted(archive.getmembers(), key=lambda entry: entry.name):
            file = archive.extractfile(entry) if entry.isfile() else None
            if file:
                yield entry.name.removeprefix("./"), file.read()


def needed(package: Path) -> list[str]:
    """What a package needs from its system. The library itself needs nothing."""
    if package.suffix != ".deb":
        return []
    said = subprocess.check_output(["dpkg-deb", "-f", str(package), "Depends"], text=True)
    return [one.strip() for one in said.split(",") if one.strip()]


def checksums(content: bytes, *names: str) -> list[Json]:
    return [
        {"algorithm": name, "checksumValue": hashlib.new(name, content).hexdigest()}
        for name in names
    ]


def document(
    packages: Sequence[Path], number: str, project: Mapping[str, str], seconds: int
) -> Json:
    """The document for these packages. project: release.project(); seconds: the time in it, since
    1970. SPDX 2.3 wants SHA1 of every file.
    """
    found: Json = {"packages": [], "files": [], "relationships": []}

    def relate(one: str, how: str, other: str) -> None:
        found["relationships"].append(
            {"spdxElementId": one, "relationshipType": how, "relatedSpdxElement": other}
        )

    license_of = {"licenseConcluded": project["LICENSE"], "copyrightText": project["COPYRIGHT"]}
    systems: dict[str, str] = {}
    for place, package in enumerate(packages):
        ident, sums = f"SPDXRef-package-{place}", []
        for at, (name, content) in enumerate(contents(package)):
            file = f"SPDXRef-file-{place}-{at}"
            sums += checksums(content, "SHA1", "SHA256")
            found["files"].append(
                {
                    "SPDXID": file,
                    "fileName": f"./{name}",
                    "checksums": sums[-2:],
                    "licenseInfoInFiles": ["NOASSERTION"],
                    **license_of,
                }
            )
            relate(ident, "CONTAINS", file)
        shas = sorted(one["checksumValue"] for one in sums if one["algorithm"] == "SHA1")
        found["packages"].append(
            {
                "SPDXID": ident,
                "name": package.name.split(number)[0].rstrip(".-_"),
                "versionInfo": number,
                "packageFileName": package.name,
                "homepage": project["HOMEPAGE"],
                "downloadLocation": "NOASSERTION",
                "filesAnalyzed": True,
                "packageVerificationCode": {
                    "packageVerificationCodeValue": hashlib.sha1("".join(shas).encode()).hexdigest()
                },
                "checksums": checksums(package.read_bytes(), "SHA256"),
                "licenseDeclared": project["LICENSE"],
                "licenseInfoFromFiles": ["NOASSERTION"],
                **license_of,
            }
        )
        relate("SPDXRef-DOCUMENT", "DESCRIBES", ident)
        for need in needed(package):
            if need not in systems:
                systems[need] = f"SPDXRef-system-{len(systems)}"
            relate(ident, "DEPENDS_ON", systems[need])
    for need, ident in systems.items():
        found["packages"].append(
            {
                "SPDXID": ident,
                "name": need,
                "downloadLocation": "NOASSERTION",
                "filesAnalyzed": False,
                "comment": "A package of Debian that must be installed; not part of the release.",
            }
        )
    whole = "".join(one["checksums"][0]["checksumValue"] for one in found["files"])
    return {
        "spdxVersion": "SPDX-2.3",
        "dataLicense": "CC0-1.0",
        "SPDXID": "SPDXRef-DOCUMENT",
        "name": f"davar-{number}",
        "documentNamespace": f"{project['HOMEPAGE']}/spdx/davar-{number}-"
        + hashlib.sha256(whole.encode()).hexdigest(),
        "creationInfo": {
            "created": time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime(seconds)),
            "creators": ["Tool: davar-release", f"Organization: {project['AUTHOR']}"],
        },
        **found,
    }
