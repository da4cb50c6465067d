#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The Flatpak manifest: accepted by flatpak-builder where that is installed; options, names and checksums that exist.

The Flatpak itself is not built: the runtime is needed for it.
"""

import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
MANIFEST = ROOT / "packaging/flatpak/io.simplexseg.simplexseg.yaml"


class Flatpak(unittest.TestCase):
    def test_sources_have_checksums(self):
        text = MANIFEST.read_text()
        listed = subprocess.run([ROOT / "packaging/flatpak/fetch_sources", "--list"], check=True, capture_output=True, text=True).stdout.splitlines()
        self.assertEqual(len(listed), text.count("type: archive"))
        for line in listed:
            self.assertRegex(line, r"^[0-9a-f]{64}  [a-z0-9-]+_\S+\.orig\.tar\.\w+$")
        self.assertNotIn("url:", text, "the build needs no network")

    def test_options_and_names_exist(self):
        text = MANIFEST.read_text()
        lists = (ROOT / "CMakeLists.txt").read_text()
        options = re.findall(r"-D(SIMPLEXSEG_\w+)=", text)
        self.assertGreater(len(options), 5)
        for option in options:
            self.assertRegex(lists, rf"(option|set)\({option} ")
        identifier = re.search(r"^app-id: (\S+)", text, re.M)[1]
        self.assertTrue((ROOT / f"packaging/{identifier}.metainfo.xml").is_file())
        for name in re.findall(r"^rename-\S+: (\S+?)(?:\.desktop)?$", text, re.M):
            self.assertTrue((ROOT / f"packaging/{name}.desktop").is_file() and (ROOT / f"packaging/{name}.svg").is_file(), name)

    @unittest.skipUnless(shutil.which("flatpak-builder"), "flatpak-builder is missing")
    def test_flatpak_builder_accepts_it(self):
        with tempfile.TemporaryDirectory() as folder:
            done = subprocess.run(["flatpak-builder", "--show-manifest", MANIFEST], capture_output=True, text=True, cwd=folder)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn('"name" : "simplexseg"', done.stdout)


if __name__ == "__main__":
    unittest.main()
