#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""scripts/sbom: every library that the loader finds for the programs is listed, with the version that dpkg has installed.

SIMPLEXSEG_BUILD names the build folder.
"""

import copy
import json
import os
import pathlib
import re
import subprocess
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = pathlib.Path(os.environ.get("SIMPLEXSEG_BUILD", ROOT / "build/release"))
PROGRAMS = [path for pattern in ("bin/simplexseg", "bin/simplexseg-cli", "bin/simplexseg-reader", "bin/simplexseg-register",
                                 "python/simplexseg/_core*.so") for path in BUILD.glob(pattern)]


def loaded() -> dict[str, str]:
    """Path of each library, by name, from the loader itself."""
    result = {}
    for program in PROGRAMS:
        trace = subprocess.run([program] if program.suffix != ".so" else ["ldd", program], capture_output=True, text=True, check=True,
                               env=os.environ | {"LD_TRACE_LOADED_OBJECTS": "1"} if program.suffix != ".so" else None).stdout
        result |= dict(re.findall(r"^\s*(\S+) => (/\S+)", trace, re.M))
    return result


def without_row(sbom: dict) -> set[str]:
    """Names of loaded libraries that have no row with a version."""
    rows = {row["name"] for package in sbom["components"] for row in package.get("components", []) if row.get("version")}
    return set(loaded()) - rows


class Sbom(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.sbom = json.loads(subprocess.run([ROOT / "scripts/sbom", BUILD], check=True, capture_output=True, text=True).stdout)

    def test_every_loaded_library_has_a_row(self):
        self.assertGreater(len(loaded()), 50)
        self.assertEqual(without_row(self.sbom), set())

    def test_a_row_that_is_missing_is_found(self):
        for name in ("libgdcmMSFF.so.3.0", "libc.so.6"):
            less = copy.deepcopy(self.sbom)
            for package in less["components"]:
                package["components"] = [row for row in package.get("components", []) if row["name"] != name]
            self.assertEqual(without_row(less), {name})

    def test_versions_are_those_of_dpkg(self):
        names = [package["name"] + (":amd64" if package["purl"].find("arch=amd64") > 0 else "") for package in self.sbom["components"]]
        shown = subprocess.run(["dpkg-query", "-W", "-f", "${Package} ${Version}\n", *names], check=True, capture_output=True, text=True).stdout
        self.assertEqual({f"{package['name']} {package['version']}" for package in self.sbom["components"]}, set(shown.splitlines()))

    def test_libraries_of_headers_alone_are_listed(self):
        compiled_in = {package["name"] for package in self.sbom["components"] if "simplexseg:headers" in json.dumps(package)}
        self.assertLessEqual({"libeigen3-dev", "nlohmann-json3-dev", "libcli11-dev"}, compiled_in)

    def test_form(self):
        self.assertEqual((self.sbom["bomFormat"], self.sbom["specVersion"]), ("CycloneDX", "1.5"))
        self.assertRegex(self.sbom["serialNumber"], r"^urn:uuid:[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12}$")
        self.assertRegex(self.sbom["metadata"]["timestamp"], r"^\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ$")
        references = [package["bom-ref"] for package in self.sbom["components"]]
        self.assertEqual(len(references), len(set(references)))
        for package in self.sbom["components"]:
            self.assertRegex(package["purl"], r"^pkg:deb/debian/[a-z0-9.%+-]+@[^+:]+\?arch=\w+&distro=debian-\d+$")
            for choice in package["licenses"]:
                self.assertEqual(set(choice["license"]) & {"id", "name"}, set(choice["license"]))
        named = [package for package in self.sbom["components"] if package["licenses"]]
        self.assertGreater(len(named), 0.9 * len(self.sbom["components"]))

    def test_equal_builds_have_equal_lists(self):
        again = subprocess.run([ROOT / "scripts/sbom", BUILD], check=True, capture_output=True, text=True).stdout
        self.assertEqual(json.loads(again), self.sbom)


if __name__ == "__main__":
    if not PROGRAMS:
        print(f"sbom tests: {BUILD} has no programs", file=sys.stderr)
        sys.exit(77)
    unittest.main()
