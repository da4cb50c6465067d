# SPDX-License-Identifier: Apache-2.0
"""Build backend of the Python module (PEP 517): CMake builds it, and this packs it as a wheel. Uses the standard library alone.

Settings, as pip passes them (--config-settings NAME=VALUE):
    build   build folder that has been built already; its module is packed, and nothing is compiled
    cmake   further arguments of CMake, between spaces, for example -DSIMPLEXSEG_CUDA=OFF
Without build, the module is built in build/wheel, for any x86-64 (SIMPLEXSEG_ARCH). Equal builds give equal wheels.
"""
from __future__ import annotations

import base64
import hashlib
import os
import pathlib
import re
import shlex
import subprocess
import sys
import sysconfig
import tarfile
import tempfile
import time
import zipfile

ROOT = pathlib.Path(__file__).resolve().parent.parent


def project() -> dict[str, str]:
    """Fields of pyproject.toml that are texts, and the version, which CMakeLists.txt declares."""
    fields = dict(re.findall(r'^([\w-]+) = "(.*)"$', (ROOT / "pyproject.toml").read_text().partition("[project]")[2], re.M))
    fields["version"] = re.search(r"project\(simplexseg VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text())[1]
    fields["stem"] = f"{fields['name']}-{fields['version']}"
    return fields


def metadata() -> str:
    fields = project()
    return (
        f"Metadata-Version: 2.1\nName: {fields['name']}\nVersion: {fields['version']}\nSummary: {fields['description']}\n"
        f"License: Apache-2.0\nRequires-Python: {fields['requires-python']}\nRequires-Dist: numpy\n"
        f"Description-Content-Type: text/markdown\n\n{(ROOT / fields['readme']).read_text()}"
    )


def source_date() -> int:
    return int(subprocess.run([ROOT / "packaging/source_date"], check=True, capture_output=True, text=True).stdout)


def run(*command: object) -> None:
    """Runs a program, whose output pip shows."""
    words = [str(word) for word in command]
    try:
        done = subprocess.run(words, check=False)
    except OSError as error:
        sys.exit(f"simplexseg: cannot start {words[0]}: {error.strerror}; install the packages of scripts/setup")
    if done.returncode:
        sys.exit(f"simplexseg: {shlex.join(words)} failed; the reason is above")


def build_module(settings: dict) -> pathlib.Path:
    if "build" in settings:
        return pathlib.Path(settings["build"]).resolve()
    build = ROOT / "build/wheel"
    run("cmake", "-G", "Ninja", "-S", ROOT, "-B", build, "-DCMAKE_BUILD_TYPE=Release", "-DSIMPLEXSEG_ARCH=", "-DSIMPLEXSEG_GUI=OFF",
        "-DSIMPLEXSEG_REPRODUCIBLE=ON", "-DSIMPLEXSEG_BATCHES=ON", "-DSIMPLEXSEG_TESTS=OFF", "-DSIMPLEXSEG_BENCHMARKS=OFF",
        f"-DPython3_EXECUTABLE={sys.executable}", *shlex.split(settings.get("cmake", "")))
    cache = (build / "CMakeCache.txt").read_text()
    if "SIMPLEXSEG_PYTHON_PROGRAM:INTERNAL=" not in cache:
        sys.exit(f"simplexseg: the module was not configured; {sys.executable} needs python3-dev, numpy and pybind11-dev")
    run("cmake", "--build", build, "--target", "simplexseg_python")
    return build


def build_wheel(wheel_directory: str, config_settings: dict | None = None, metadata_directory: str | None = None) -> str:
    fields = project()
    tag = f"cp{sys.version_info.major}{sys.version_info.minor}"
    tag = f"{tag}-{tag}-{sysconfig.get_platform().replace('-', '_').replace('.', '_')}"
    build = build_module(config_settings or {})
    wheel = pathlib.Path(wheel_directory) / f"{fields['stem']}-{tag}.whl"
    with tempfile.TemporaryDirectory(prefix="simplexseg-wheel-") as stage:
        run("cmake", "--install", build, "--component", "python", "--prefix", stage, "--strip")
        packages = [path.parent for path in pathlib.Path(stage).rglob("simplexseg/__init__.py")]
        if not packages:
            sys.exit(f"simplexseg: {build} has no Python module; build its target simplexseg_python")
        if not list(packages[0].glob(f"_core*{sysconfig.get_config_var('EXT_SUFFIX')}")):
            sys.exit(f"simplexseg: the module in {build} is for another Python than {sys.executable}")
        files = {f"simplexseg/{path.name}": (path.read_bytes(), os.access(path, os.X_OK)) for path in packages[0].iterdir()}
    info = f"{fields['stem']}.dist-info"
    files[f"{info}/METADATA"] = (metadata().encode(), False)
    files[f"{info}/WHEEL"] = (f"Wheel-Version: 1.0\nGenerator: simplexseg\nRoot-Is-Purelib: false\nTag: {tag}\n".encode(), False)
    files[f"{info}/LICENSE"] = ((ROOT / "LICENSE").read_bytes(), False)
    record = ""
    for name in sorted(files):
        digest = base64.urlsafe_b64encode(hashlib.sha256(files[name][0]).digest()).rstrip(b"=").decode()
        record += f"{name},sha256={digest},{len(files[name][0])}\n"
    files[f"{info}/RECORD"] = (f"{record}{info}/RECORD,,\n".encode(), False)
    when = time.gmtime(source_date())[:6]
    with zipfile.ZipFile(wheel, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in sorted(files, key=lambda name: (name.startswith(info), name)):  # PEP 427: the record is at the end
            entry = zipfile.ZipInfo(name, when)
            entry.external_attr = (0o100755 if files[name][1] else 0o100644) << 16
            entry.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(entry, files[name][0])
    return wheel.name


def build_sdist(sdist_directory: str, config_settings: dict | None = None) -> str:
    """Archive of the files that git tracks, as they are in the folder, and PKG-INFO."""
    stem = project()["stem"]
    tracked = subprocess.run(["git", "-C", ROOT, "ls-files", "-z"], capture_output=True, text=True)
    if tracked.returncode:
        sys.exit("simplexseg: a source archive is made from a git checkout; this is none")
    epoch = source_date()
    with tempfile.TemporaryDirectory() as temporary:
        info = pathlib.Path(temporary) / "PKG-INFO"
        info.write_text(metadata())

        def normal(entry: tarfile.TarInfo) -> tarfile.TarInfo:
            entry.mtime, entry.uid, entry.gid, entry.uname, entry.gname = epoch, 0, 0, "", ""
            entry.mode = 0o755 if entry.mode & 0o100 else 0o644
            return entry

        plain = pathlib.Path(temporary) / "source.tar"
        with tarfile.open(plain, "w", format=tarfile.PAX_FORMAT) as archive:
            archive.add(info, f"{stem}/PKG-INFO", filter=normal)
            for name in sorted(filter(None, tracked.stdout.split("\0"))):
                archive.add(ROOT / name, f"{stem}/{name}", recursive=False, filter=normal)
        to = pathlib.Path(sdist_directory) / f"{stem}.tar.gz"
        with to.open("wb") as file:
            subprocess.run(["gzip", "-9nc", plain], check=True, stdout=file)
    return to.name
