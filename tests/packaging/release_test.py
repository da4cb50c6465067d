#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""scripts/release sign and verify, with a temporary key: changed, additional and missing files and other keys are found."""

import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]


class Release(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory(prefix="simplexseg-release-")
        cls.keys = pathlib.Path(cls.temporary.name) / "keys"  # of the maintainer and of somebody else
        cls.keys.mkdir(mode=0o700)
        cls.environment = os.environ | {"GNUPGHOME": str(cls.keys)}
        cls.key, cls.other = (cls.make_key(name) for name in ("maintainer", "somebody"))

    @classmethod
    def tearDownClass(cls):
        subprocess.run(["gpgconf", "--kill", "all"], env=cls.environment, check=False)
        cls.temporary.cleanup()

    @classmethod
    def make_key(cls, name: str) -> str:
        subprocess.run(["gpg", "--batch", "--quiet", "--passphrase", "", "--quick-generate-key", f"{name}@simplexseg.invalid", "ed25519", "sign"],
                       env=cls.environment, check=True, capture_output=True)
        listed = subprocess.run(["gpg", "--batch", "--with-colons", "--list-keys", name], env=cls.environment, check=True,
                                capture_output=True, text=True).stdout
        return next(line.split(":")[9] for line in listed.splitlines() if line.startswith("fpr:"))

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(dir=self.temporary.name))
        (self.folder / "simplexseg-0.1.0.tar.xz").write_bytes(b"source")
        (self.folder / "simplexseg.deb").write_bytes(b"package")
        self.assertEqual(self.release("sign", self.key).returncode, 0)

    def release(self, verb: str, key: str) -> subprocess.CompletedProcess:
        return subprocess.run([ROOT / "scripts/release", verb, self.folder, key], env=self.environment, capture_output=True, text=True)

    def refused(self, part: str, key: str = ""):
        result = self.release("verify", key or self.key)
        self.assertEqual(result.returncode, 1, result.stdout)
        self.assertIn(part, result.stderr)

    def test_signed_files_are_verified(self):
        result = self.release("verify", self.key)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("2 files", result.stdout)

    def test_a_changed_file_is_found(self):
        (self.folder / "simplexseg.deb").write_bytes(b"Package")
        self.refused("not those of the release")

    def test_changed_checksums_are_found(self):
        (self.folder / "simplexseg.deb").write_bytes(b"Package")
        sums = subprocess.run(["sha256sum", "simplexseg-0.1.0.tar.xz", "simplexseg.deb"], cwd=self.folder, capture_output=True, check=True)
        (self.folder / "SHA256SUMS").write_bytes(sums.stdout)
        self.refused("signature of SHA256SUMS is wrong")

    def test_additional_and_missing_files_are_found(self):
        (self.folder / "another.whl").touch()
        self.refused("not listed")
        (self.folder / "another.whl").unlink()
        (self.folder / "SHA256SUMS.asc").unlink()
        self.refused("is missing")

    def test_the_signature_of_another_key_is_refused(self):
        self.assertEqual(self.release("sign", self.other).returncode, 0)
        self.refused("another key")
        self.refused("40 hexadecimal digits", "maintainer")


if __name__ == "__main__":
    if not shutil.which("gpg"):
        print("release tests: the Debian package gnupg is missing", file=sys.stderr)
        sys.exit(77)
    unittest.main()
