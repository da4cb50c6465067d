# SPDX-License-Identifier: Apache-2.0
"""Libraries that programs load or contain, the Debian packages they are from, and their licences. For scripts/sbom and scripts/bundle."""
from __future__ import annotations

import dataclasses
import functools
import os
import pathlib
import re
import subprocess

INFO = pathlib.Path("/var/lib/dpkg/info")
# Debian's names of licences as SPDX identifiers. Another name is stated as it is.
SPDX = {
    "Apache-2": "Apache-2.0", "Apache-2.0": "Apache-2.0", "APACHE-2-LLVM-EXCEPTIONS": "Apache-2.0", "BSD-2-clause": "BSD-2-Clause",
    "BSD-3-clause": "BSD-3-Clause", "BSD-3-Clause": "BSD-3-Clause", "BSL-1.0": "BSL-1.0", "CC0": "CC0-1.0", "CC0-1.0": "CC0-1.0",
    "Expat": "MIT", "GPL-2": "GPL-2.0-only", "GPL-2+": "GPL-2.0-or-later", "GPL-3": "GPL-3.0-only", "GPL-3+": "GPL-3.0-or-later",
    "ISC": "ISC", "LGPL-2": "LGPL-2.0-only", "LGPL-2+": "LGPL-2.0-or-later", "LGPL-2.1": "LGPL-2.1-only",
    "LGPL-2.1+": "LGPL-2.1-or-later", "LGPL-3": "LGPL-3.0-only", "LGPL-3+": "LGPL-3.0-or-later", "MIT": "MIT", "MPL-2.0": "MPL-2.0",
    "OFL-1.1": "OFL-1.1", "Zlib": "Zlib", "zlib": "Zlib", "Zlib/Libpng": "Zlib", "curl": "curl",
}


class Missing(Exception):
    """A library or its package was not found; the text is one line for the user."""


@dataclasses.dataclass(frozen=True)
class Package:
    name: str
    version: str
    architecture: str
    source: str  # name of the source package
    source_version: str


def is_elf(path: pathlib.Path) -> bool:
    with path.open("rb") as file:
        return file.read(4) == b"\x7fELF"


def linked_libraries(files: list[pathlib.Path]) -> dict[str, pathlib.Path]:
    """Path of each shared library that the loader finds for these programs and libraries, by its name. Throws Missing."""
    found: dict[str, pathlib.Path] = {}
    for file in files:
        listed = subprocess.run(["ldd", file], capture_output=True, text=True)
        if listed.returncode:
            raise Missing(f"ldd cannot read {file}: {listed.stderr.strip()}")
        for line in listed.stdout.splitlines():
            if match := re.match(r"\s*(\S+) => (/\S+)", line):
                found[match[1]] = pathlib.Path(match[2])
            elif match := re.match(r"\s*(/\S+) \(0x", line):  # the loader itself
                found[os.path.basename(match[1])] = pathlib.Path(match[1])
            elif match := re.match(r"\s*(\S+) => not found", line):
                raise Missing(f"{file} needs {match[1]}, which is not installed")
    return found


def spelling(path: str) -> str:
    """Path without the prefix /usr: since /lib is a link to /usr/lib, lists and loader write either."""
    return re.sub(r"^/usr(?=/s?bin/|/lib)", "", path)


@functools.cache
def owners() -> dict[str, str]:
    """Name of the Debian package, with its architecture if dpkg has it in the name, of each installed file and folder."""
    result = {}
    for names in INFO.glob("*.list"):
        for line in names.read_text(errors="replace").splitlines():
            result[spelling(line)] = names.name.removesuffix(".list")
    return result


@functools.cache
def package(name: str) -> Package:
    shown = subprocess.run(
        ["dpkg-query", "-W", "-f", "${Package}\t${Version}\t${Architecture}\t${source:Package}\t${source:Version}", name],
        capture_output=True, text=True)
    if shown.returncode:
        raise Missing(f"dpkg does not know the package {name}")
    return Package(*shown.stdout.split("\t"))


def package_of(path: pathlib.Path) -> Package:
    """The Debian package of a file. Throws Missing where the file is of none."""
    for candidate in (str(path), str(path.resolve())):
        if (name := owners().get(spelling(candidate))) is not None:
            return package(name)
    raise Missing(f"{path} is of no Debian package, so its version is unknown")


def copyright_file(of: Package) -> pathlib.Path:
    return pathlib.Path("/usr/share/doc") / of.name / "copyright"


@functools.cache
def licences(of: Package) -> tuple[str, ...]:
    """SPDX identifiers or Debian's names of the licences of a package: those that its copyright file states for most of its files, else all.

    A copyright file without fields is named itself: its text names licences of parts and of the packaging too.
    """
    try:
        text = copyright_file(of).read_text(errors="replace")
    except OSError:
        return ()
    if not text.startswith("Format:"):
        return (f"see {copyright_file(of)}",)
    main = [part for part in re.split(r"\n\s*\n", text) if re.search(r"^Files:\s*\*", part, re.M)]
    stated = re.findall(r"^License:[ \t]*(\S.*)$", "\n".join(main), re.M) or re.findall(r"^License:[ \t]*(\S.*)$", text, re.M)
    names = [name for line in stated for name in re.split(r"\s+(?:and|or|and/or)\s+|,\s*", line.strip())]
    return tuple(dict.fromkeys(SPDX.get(name, name) for name in names if name))


def header_packages(build: pathlib.Path) -> set[Package]:
    """Packages whose headers the sources of a build folder include: among them those of libraries without a binary."""
    listed = subprocess.run(["ninja", "-n", "-C", build, "-t", "deps"], capture_output=True, text=True)
    if listed.returncode:
        raise Missing(f"ninja cannot list the headers of {build}: {listed.stderr.strip()}")
    headers = {line.strip() for line in set(listed.stdout.splitlines()) if line.startswith("    /usr/")}
    # A path may contain "..", for example those of GCC's headers.
    found = {owners().get(spelling(os.path.normpath(path))) for path in headers}
    return {package(name) for name in found if name is not None}
