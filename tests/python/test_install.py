# SPDX-License-Identifier: Apache-2.0
import os
import pathlib
import shutil
import subprocess
import sys

import pytest

import simplexseg


def test_the_installed_module_is_imported(tmp_path):
    build = os.environ.get("SIMPLEXSEG_BUILD")
    if not build or not shutil.which("cmake"):
        pytest.skip("SIMPLEXSEG_BUILD names no build folder, or cmake is missing")
    prefix = tmp_path / "usr"
    subprocess.run(
        ["cmake", "--install", build, "--component", "python", "--prefix", prefix], check=True, stdout=subprocess.DEVNULL
    )
    packages = list(prefix.rglob("simplexseg"))
    assert len(packages) == 1
    folder = packages[0].parent
    assert folder.name in ("dist-packages", "site-packages") and folder.relative_to(prefix).parts[0] == "lib"
    assert {"__init__.py", "_core.pyi", "py.typed", "simplexseg-reader"} < {path.name for path in packages[0].iterdir()}
    dicom = pathlib.Path(__file__).parent.parent / "fuzz/seeds/dicom/j2k.dcm"  # read by simplexseg-reader
    code = f"""
import simplexseg
print(simplexseg.__file__)
print(simplexseg.make_phantom('cube', size=8)[0].array.max())
print(simplexseg.read_volume({str(dicom)!r}).array.shape)"""
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=False, cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(folder)},
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines() == [str(packages[0] / "__init__.py"), "150", "(8, 8, 1)"]


def test_the_module_exports_only_its_entry_point():
    if not shutil.which("nm"):
        pytest.skip("the Debian package binutils is missing")
    library = next(pathlib.Path(simplexseg.__file__).parent.glob("_core*.so"))
    symbols = subprocess.run(["nm", "-D", "--defined-only", library], capture_output=True, text=True, check=True).stdout
    assert {line.split()[-1] for line in symbols.splitlines()} == {"PyInit__core"}
