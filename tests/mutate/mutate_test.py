#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""scripts/mutate: which faults it makes in a source, and in which lines."""
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.dont_write_bytecode = True
sys.path.insert(0, str(ROOT / "scripts"))
from mutation import faults as made

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
    return [(one.line, one.kind, one.old, " ".join(one.new.split())) for one in made.faults_of(ROOT, "x.cpp", SOURCE, lines)]


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
        for one in made.faults_of(ROOT, "x.cpp", SOURCE):
            changed = SOURCE[:one.start] + one.new + SOURCE[one.end:]
            before, after = SOURCE.split("\n"), changed.split("\n")
            self.assertEqual(len(before), len(after))
            self.assertEqual(sum(a != b for a, b in zip(before, after)), 1, one.describe())

    def test_removed_refusals_are_tried_first(self):
        order = made.spread(made.faults_of(ROOT, "x.cpp", SOURCE))
        self.assertEqual([one.refusal for one in order], sorted((one.refusal for one in order), reverse=True))
        self.assertEqual(sum(one.refusal for one in order), 2)

    def test_sources_of_this_program_have_refusals(self):
        path = ROOT / "src/io/volume/nrrd_header.cpp"
        refusals = [one for one in made.faults_of(ROOT, str(path), path.read_text(encoding="utf-8")) if one.refusal]
        self.assertGreater(len(refusals), 5)


PROGRAM = """#include <cstdio>
#include <cstdlib>
#include <stdexcept>
bool simplexseg_fault(int);
bool simplexseg_condition(int, int, bool);
int half(int value) {
  if (value < 0) throw std::runtime_error("negative");  // a reason
  int result = value / 2;
  result += 10;
  std::printf("h ");
  return result;
}
int main(int, char** words) {
  try {
    std::printf("%d", half(std::atoi(words[1])));
  } catch (const std::exception&) {
    std::printf("refused");
  }
}
"""


class Switches(unittest.TestCase):
    """A program with all faults as switches prints what each fault changes."""

    def test_each_fault_is_switched_on_alone_and_reached_where_it_matters(self):
        lines = set(range(6, 13))
        faults = made.faults_of(ROOT, "x.cpp", PROGRAM, lines)
        with tempfile.TemporaryDirectory() as folder:
            text = made.switched(PROGRAM, faults)
            self.assertEqual(text.count("\n"), PROGRAM.count("\n"))
            source, program, reached = (pathlib.Path(folder) / name for name in ("x.cpp", "x", "reached"))
            source.write_text(text)
            switches = ROOT / "scripts" / "mutation" / "switches.cpp"
            subprocess.run([os.environ.get("CXX", "c++"), "-std=c++20", "-O0", source, switches, "-o", program], check=True)

            def output(value, **variables):
                return subprocess.run([program, str(value)], capture_output=True, text=True, env=os.environ | variables).stdout

            def of(kind, line):
                return str(next(one.id for one in faults if (one.kind, one.line) == (kind, line)))

            self.assertEqual((output(8), output(-8)), ("h 14", "refused"))
            self.assertEqual(output(-8, SIMPLEXSEG_FAULT=of("refusal removed", 7)), "h 6")
            self.assertEqual(output(8, SIMPLEXSEG_FAULT=of("condition negated", 7)), "refused")
            self.assertEqual(output(0, SIMPLEXSEG_FAULT=of("comparison", 7)), "refused")
            self.assertEqual(output(8, SIMPLEXSEG_FAULT=of("early return", 6)), "0")
            self.assertEqual(output(8, SIMPLEXSEG_FAULT=of("statement removed", 10)), "14")
            arithmetic = {output(8, SIMPLEXSEG_FAULT=str(one.id)) for one in faults if one.kind == "arithmetic"}
            self.assertEqual(arithmetic, {"h 26", "h -6"})
            constants = {output(8, SIMPLEXSEG_FAULT=str(one.id)) for one in faults if one.kind == "constant"}
            self.assertEqual(constants, {"h 14", "h 12", "h 15"})   # 1 instead of 0: not noticed with 8

            def numbers(value):
                reached.unlink(missing_ok=True)
                output(value, SIMPLEXSEG_REACHED=str(reached))
                data = reached.read_bytes()
                return {str(int.from_bytes(data[n:n + 4], sys.byteorder)) for n in range(0, len(data), 4)}

            self.assertIn(of("refusal removed", 7), numbers(-8))
            self.assertNotIn(of("refusal removed", 7), numbers(8))
            self.assertNotIn(of("statement removed", 10), numbers(-8))
            self.assertIn(of("statement removed", 10), numbers(8))


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
            self.assertEqual(made.changed_lines(root, "HEAD"), {})
            for path in ("src/io/a.cpp", "src/io/a.h", "src/gui/b.cpp"):
                (root / path).write_text("1\nx\n3\n4\n5\n")
            (root / "src/field/gone.cpp").unlink()
            (root / "src/io/new.cpp").write_text("1\n")
            self.assertEqual(made.changed_lines(root, "HEAD"), {"src/io/a.cpp": {2, 5}, "src/io/new.cpp": None})

    def test_an_unknown_source_is_refused_in_one_line(self):
        refused = subprocess.run([ROOT / "scripts" / "mutate", "no/such.cpp"], capture_output=True, text=True)
        self.assertEqual((refused.returncode, len(refused.stderr.splitlines())), (1, 1))


if __name__ == "__main__":
    unittest.main()
