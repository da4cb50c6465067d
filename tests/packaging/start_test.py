#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Start script of the archive (packaging/bundle/start.in): check of glibc, libraries that are missing, software renderer, links.

The program that it starts is replaced by one that prints its environment.
"""

import os
import pathlib
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]


class Start(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory(prefix="simplexseg-start-")
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name) / "an archive"
        text = (ROOT / "packaging/bundle/start.in").read_text()
        for key, value in (("FLOOR", "35"), ("GLIBCXX", "3.4.30"), ("GCC", "3.5")):
            text = text.replace(f"@{key}@", value)
        self.start = self.write("bin/simplexseg-cli", text)
        self.write("lib/simplexseg-cli", '#!/bin/sh\nenv\necho "arguments:$*"\n')
        self.write("lib/fallback/list", "libc.so.6 2\n")  # every system has it
        self.tools = self.folder / "tools"

    def write(self, name: str, text: str) -> pathlib.Path:
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
        path.chmod(0o755)
        return path

    def glibc(self, version: str):
        """Replaces the version of glibc that the system states."""
        self.write("tools/getconf", f"#!/bin/sh\necho {version}\n")

    def run_it(self, *arguments: str, program: pathlib.Path | None = None, **variables: str) -> subprocess.CompletedProcess:
        return subprocess.run([program or self.start, *arguments], capture_output=True, text=True,
                              env={"PATH": f"{self.tools}:/usr/bin:/bin", "HOME": "/", **variables})

    def refused(self, part: str):
        done = self.run_it()
        self.assertEqual(done.returncode, 2)
        self.assertEqual(done.stdout, "")
        self.assertEqual(len(done.stderr.splitlines()), 1, done.stderr)
        self.assertIn(part, done.stderr)

    def test_a_system_with_all_libraries_gets_no_search_path(self):
        self.glibc("glibc 2.36")
        done = self.run_it("info", "a file")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("arguments:info a file", done.stdout)
        self.assertNotIn("LD_LIBRARY_PATH", done.stdout)

    def test_an_old_system_is_refused_in_one_line(self):
        self.glibc("glibc 2.31")
        self.refused("glibc 2.31, and 2.35 or newer is required")
        self.glibc("glibc 2.35")
        self.assertEqual(self.run_it().returncode, 0)

    def test_a_system_without_glibc_is_refused_in_one_line(self):
        self.write("tools/getconf", "#!/bin/sh\nexit 1\n")
        self.refused("no GNU C library")

    def test_a_missing_library_is_that_of_the_archive(self):
        self.glibc("glibc 2.36")
        self.write("lib/fallback/list", "libc.so.6 2\nlibmissing-in-every-system.so.1 36\n")
        done = self.run_it(LD_LIBRARY_PATH="/of/the/user")
        self.assertIn(f"LD_LIBRARY_PATH={self.folder}/lib/fallback/libmissing-in-every-system.so.1:/of/the/user\n", done.stdout)

    def test_a_library_of_the_archive_that_needs_a_newer_system_is_named(self):
        self.glibc("glibc 2.35")
        self.write("lib/fallback/list", "libmissing-in-every-system.so.1 36\n")
        self.refused("the library libmissing-in-every-system.so.1 is missing or too old")

    def test_the_software_renderer_can_be_chosen(self):
        self.glibc("glibc 2.36")
        (self.folder / "lib/mesa/dri").mkdir(parents=True)
        done = self.run_it(SIMPLEXSEG_SOFTWARE_GL="1")
        self.assertIn(f"LD_LIBRARY_PATH={self.folder}/lib/mesa\n", done.stdout)
        self.assertIn(f"LIBGL_DRIVERS_PATH={self.folder}/lib/mesa/dri\n", done.stdout)

    def test_a_link_in_another_folder_starts_it(self):
        self.glibc("glibc 2.36")
        links = self.folder / "links"
        links.mkdir()
        os.symlink(self.start, links / "simplexseg-cli")
        self.assertEqual(self.run_it(program=links / "simplexseg-cli").returncode, 0)

    def test_settings_of_the_user_are_kept(self):
        self.glibc("glibc 2.36")
        done = self.run_it(DISPLAY=":1", QT_QPA_PLATFORM="offscreen", DCMDICTPATH="/mine")
        self.assertIn("QT_QPA_PLATFORM=offscreen\n", done.stdout)
        self.assertIn("DCMDICTPATH=/mine\n", done.stdout)
        self.assertIn("QT_QPA_PLATFORM=xcb\n", self.run_it(DISPLAY=":1").stdout)


if __name__ == "__main__":
    unittest.main()
