#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""packaging/wheel_backend.py: the wheel of the built module installs with pip in a clean environment, without network, and is reproducible.

SIMPLEXSEG_BUILD names the build folder.
"""

import base64
import hashlib
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest
import zipfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = pathlib.Path(os.environ.get("SIMPLEXSEG_BUILD", ROOT / "build/release"))
ENVIRONMENT = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}


def python_of_the_build() -> str:
    found = re.search(r"^Python3_EXECUTABLE:FILEPATH=(.+)$", (BUILD / "CMakeCache.txt").read_text(), re.M)
    return found[1] if found else "/usr/bin/python3"


def make(folder: pathlib.Path, zone: str) -> pathlib.Path:
    folder.mkdir()
    code = "import sys, wheel_backend; wheel_backend.build_wheel(sys.argv[1], {'build': sys.argv[2]})"
    subprocess.run([python_of_the_build(), "-c", code, folder, BUILD], check=True, capture_output=True,
                   env=ENVIRONMENT | {"PYTHONPATH": str(ROOT / "packaging"), "PYTHONDONTWRITEBYTECODE": "1", "TZ": zone})
    return next(folder.glob("*.whl"))


class Wheel(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory(prefix="simplexseg-wheel-test-")
        cls.folder = pathlib.Path(cls.temporary.name)
        cls.wheel = make(cls.folder / "first", "UTC")

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    def test_the_record_lists_every_file_with_its_hash(self):
        with zipfile.ZipFile(self.wheel) as archive:
            names = archive.namelist()
            record = next(name for name in names if name.endswith(".dist-info/RECORD"))
            lines = [line.split(",") for line in archive.read(record).decode().splitlines()]
            self.assertEqual(sorted(line[0] for line in lines), sorted(names))
            for name, digest, size in lines:
                if name != record:
                    content = archive.read(name)
                    expected = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
                    self.assertEqual((digest, size), (f"sha256={expected}", str(len(content))), name)

    def test_equal_builds_make_equal_wheels(self):
        self.assertEqual(make(self.folder / "second", "Asia/Kathmandu").read_bytes(), self.wheel.read_bytes())

    def test_pip_installs_it_in_a_clean_environment(self):
        environment = self.folder / "environment"
        subprocess.run([python_of_the_build(), "-m", "venv", "--system-site-packages", environment], check=True, env=ENVIRONMENT)
        python = environment / "bin/python"
        subprocess.run([python, "-m", "pip", "install", "-q", "--no-index", "--no-deps", self.wheel], check=True, env=ENVIRONMENT)
        dicom = ROOT / "tests/fuzz/seeds/dicom/j2k.dcm"  # read by simplexseg-reader, which must be executable
        code = f"""
import simplexseg
print(simplexseg.__file__)
print(simplexseg.__version__)
print(simplexseg.read_volume({str(dicom)!r}).array.shape)"""
        done = subprocess.run([python, "-c", code], capture_output=True, text=True, cwd=self.folder, env=ENVIRONMENT)
        self.assertEqual(done.returncode, 0, done.stderr)
        file, version, shape = done.stdout.splitlines()
        self.assertTrue(file.startswith(str(environment)), file)
        self.assertIn(f"-{version}-", self.wheel.name)
        self.assertEqual(shape, "(8, 8, 1)")

    def test_another_python_is_refused(self):
        code = "import sysconfig, wheel_backend; sysconfig.get_config_vars()['EXT_SUFFIX'] = '.cpython-301.so'; " \
               "wheel_backend.build_wheel('.', {'build': %r})" % str(BUILD)
        done = subprocess.run([python_of_the_build(), "-c", code], capture_output=True, text=True, cwd=self.folder,
                              env=ENVIRONMENT | {"PYTHONPATH": str(ROOT / "packaging"), "PYTHONDONTWRITEBYTECODE": "1"})
        self.assertEqual(done.returncode, 1)
        self.assertIn("another Python", done.stderr)


if __name__ == "__main__":
    if not list(BUILD.glob("python/simplexseg/_core*.so")):
        print(f"wheel tests: {BUILD} has no Python module", file=sys.stderr)
        sys.exit(77)
    if subprocess.run([python_of_the_build(), "-c", "import ensurepip"], capture_output=True).returncode:
        print("wheel tests: the Debian package python3-venv is missing", file=sys.stderr)
        sys.exit(77)
    unittest.main()
