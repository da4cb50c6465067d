# SPDX-License-Identifier: Apache-2.0
"""Runs clang-tidy over the translation units of a build folder that contain the sources named on standard input.

tidy_batches.py BUILD PASSED: BUILD has compile_commands.json; PASSED is a folder of empty files named by the checksums of units
that passed. Exit status 1 when a unit has a finding.
"""

import concurrent.futures
import hashlib
import json
import os
import pathlib
import re
import shlex
import subprocess
import sys

# A kernel is compiled for every set of forces: with three forces the engine takes seconds, not minutes.
# In kernels & and | combine masks of eight vertices; for one vertex they are intended.
OPTIONS = ["--quiet", "--extra-arg=-DSIMPLEXSEG_BUILT_FORCES=37u", "--extra-arg=-Wno-unknown-pragmas",
           "--extra-arg=-Wno-bitwise-instead-of-logical"]


def sources_of(unit: pathlib.Path, root: pathlib.Path) -> set[str]:
    """Sources that a translation unit consists of, relative to root: itself, or those that a batch includes."""
    if not unit.exists():  # generated when the program is built
        return set()
    included = re.findall(r'^#include "(/[^"]+\.cpp)"', unit.read_text(), re.M)
    return {os.path.relpath(path, root) for path in included or [unit]}


def checksum(entry: dict, version: bytes) -> str:
    """SHA-256 of clang-tidy's version, its configuration, its options and the preprocessed unit."""
    command = [word for word in shlex.split(entry["command"])]
    at = command.index("-o")
    command = command[:at] + command[at + 2:]
    command[command.index("-c")] = "-E"
    text = subprocess.run(command, cwd=entry["directory"], check=True, capture_output=True).stdout
    parts = [version, pathlib.Path(".clang-tidy").read_bytes(), " ".join(OPTIONS).encode(), text]
    return hashlib.sha256(b"\0".join(parts)).hexdigest()


def check(entry: dict, build: str, passed: pathlib.Path, version: bytes) -> bool:
    """True when a unit has no finding. Prints findings."""
    stamp = passed / checksum(entry, version)
    if stamp.exists():
        return True
    result = subprocess.run(["clang-tidy-14", "-p", build, *OPTIONS, entry["file"]], capture_output=True, text=True)
    if result.returncode:
        errors = [line for line in result.stderr.splitlines() if "warnings generated" not in line]
        print(result.stdout, *errors, sep="\n", file=sys.stderr, flush=True)
        return False
    stamp.touch()
    return True


def main() -> int:
    build, passed = sys.argv[1], pathlib.Path(sys.argv[2])
    wanted = set(sys.stdin.read().split())
    root = pathlib.Path.cwd()
    version = subprocess.run(["clang-tidy-14", "--version"], check=True, capture_output=True).stdout
    entries = json.loads(pathlib.Path(build, "compile_commands.json").read_text())
    units = [entry for entry in entries if wanted & sources_of(pathlib.Path(entry["file"]), root)]
    print(f"tidy: {len(wanted)} sources in {len(units)} units", file=sys.stderr, flush=True)
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        return 0 if all(list(pool.map(lambda entry: check(entry, build, passed, version), units))) else 1


if __name__ == "__main__":
    sys.exit(main())
