#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""scripts/mutate: which faults it makes in a source, and in which lines."""
import importlib.machinery
import importlib.util
import pathlib
import subprocess
import sys
import tempfile
import unittest
import unittest.mock

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.dont_write_bytecode = True
loader = importlib.machinery.SourceFileLoader("mutate", str(ROOT / "scripts" / "mutate"))
mutate = importlib.util.module_from_spec(importlib.util.spec_from_loader("mutate", loader))
loader.exec_module(mutate)

SOURCE = """// a < b && c
#include "x < y.h"
[[noreturn]] void refuse(const char* why);

std::vector<int> values(const std::string& text, int* const size) {
  // if (text.empty()) throw Error("1 + 2");
  if (text.empty()) throw Error("1 + 2 < 3");
  if (text.size() >= 8)
    refuse("too long");
  if (const int n = count(text); n == '0') return {};
  text.clear();
  int sum = 0;  // mutate: equivalent, for the test
  return more(sum, true);
}
"""


def faults(lines=None):
    return [(one.line, one.kind, one.old, " ".join(one.new.split())) for one in mutate.mutants_of("x.cpp", SOURCE, lines)]


class Faults(unittest.TestCase):
    def test_all_kinds_are_made(self):
        self.assertEqual(faults(), [
            (5, "early return", "", "return {};"),
            (7, "condition negated", "text.empty()", "!(text.empty())"),
            (7, "refusal removed", "text.empty()", "false"),
            (8, "condition negated", "text.size() >= 8", "!(text.size() >= 8)"),
            (8, "refusal removed", "text.size() >= 8", "false"),
            (8, "comparison", ">=", ">"),
            (8, "constant", "8", "9"),
            (10, "condition negated", "n == '0'", "!(n == '0')"),
            (10, "condition never", "n == '0'", "false"),
            (10, "comparison", "==", "!="),
            (11, "statement removed", "text.clear();", "static_cast<void>(0);"),
            (13, "constant", "true", "false"),
        ])

    def test_only_permitted_lines_change(self):
        self.assertEqual({line for line, *_ in faults({8, 13})}, {8, 13})

    def test_a_fault_replaces_only_its_place(self):
        for one in mutate.mutants_of("x.cpp", SOURCE):
            changed = SOURCE[:one.start] + one.new + SOURCE[one.end:]
            before, after = SOURCE.split("\n"), changed.split("\n")
            self.assertEqual(len(before), len(after))
            self.assertEqual(sum(a != b for a, b in zip(before, after)), 1, one.describe())

    def test_removed_refusals_are_tried_first(self):
        order = mutate.spread(mutate.mutants_of("x.cpp", SOURCE))
        self.assertEqual([one.refusal for one in order], sorted((one.refusal for one in order), reverse=True))
        self.assertEqual(sum(one.refusal for one in order), 2)

    def test_sources_of_this_program_have_refusals(self):
        path = ROOT / "src/io/volume/nrrd_header.cpp"
        refusals = [one for one in mutate.mutants_of(str(path), path.read_text(encoding="utf-8")) if one.refusal]
        self.assertGreater(len(refusals), 5)


class Changes(unittest.TestCase):
    def test_only_changed_lines_of_readers_are_found(self):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)

            def git(*words):
                subprocess.run(["git", "-c", "user.name=a", "-c", "user.email=a@b", *words], cwd=root, check=True, capture_output=True)

            for path in ("src/io/a.cpp", "src/io/a.h", "src/gui/b.cpp", "src/field/gone.cpp"):
                (root / path).parent.mkdir(parents=True, exist_ok=True)
                (root / path).write_text("1\n2\n3\n4\n")
            git("init", "-q")
            git("add", ".")
            git("commit", "-q", "-m", "first")
            mutate.ROOT, before = root, mutate.ROOT
            try:
                self.assertEqual(mutate.changed_lines("HEAD"), {})
                with unittest.mock.patch("sys.argv", ["mutate", "--changed", "HEAD"]), self.assertRaises(SystemExit) as end:
                    mutate.main()
                self.assertEqual(end.exception.code, 77)
                for path in ("src/io/a.cpp", "src/io/a.h", "src/gui/b.cpp"):
                    (root / path).write_text("1\nx\n3\n4\n5\n")
                (root / "src/field/gone.cpp").unlink()
                (root / "src/io/new.cpp").write_text("1\n")
                self.assertEqual(mutate.changed_lines("HEAD"), {"src/io/a.cpp": {2, 5}, "src/io/new.cpp": None})
            finally:
                mutate.ROOT = before

    def test_an_unknown_source_is_refused_in_one_line(self):
        refused = subprocess.run([ROOT / "scripts" / "mutate", "no/such.cpp"], capture_output=True, text=True)
        self.assertEqual((refused.returncode, len(refused.stderr.splitlines())), (1, 1))


if __name__ == "__main__":
    unittest.main()
