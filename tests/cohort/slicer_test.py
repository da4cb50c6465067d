#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""slicer_test.py PROGRAM: tests of simplexseg-cli as a module of 3D Slicer. The description follows the published schemas
(ctkCmdLineModule.xsd of CTK; ModuleDescription.xsd of the Slicer Execution Model, which requires more elements), every flag
is an option, and a call by Slicer produces the labels of the plain command."""
from __future__ import annotations

import re
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree as xml
from pathlib import Path

PROGRAM = ""
HEAD = ["category", "title", "description", "version", "documentation-url", "license", "contributor"]
NAME = re.compile(r"[_a-zA-Z][_a-zA-Z0-9]*")
# Optional elements (beyond name, flag or index, description, label, default, channel) and attributes of each kind.
KINDS: dict[str, tuple[set[str], set[str]]] = {
    "boolean": (set(), set()),
    "integer": ({"constraints"}, {"multiple"}),
    "double": ({"constraints"}, {"multiple"}),
    "string": (set(), {"multiple"}),
    "directory": (set(), {"multiple"}),
    "string-enumeration": ({"element"}, set()),
    "point": (set(), {"multiple", "coordinateSystem"}),
    "file": (set(), {"multiple", "fileExtensions"}),
    "image": (set(), {"multiple", "fileExtensions", "type"}),
}
VALUES = {"multiple": {"true", "false"}, "coordinateSystem": {"ras", "lps", "ijk"},
          "type": {"scalar", "label", "tensor", "diffusion-weighted", "vector", "model"}, "hidden": {"true", "false"}}


def call(*arguments: str) -> str:
    """Runs the program, expects success and returns its output."""
    done = subprocess.run([PROGRAM, *arguments], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def faults(text: str) -> list[str]:
    """Returns the violations of the rules in a description."""
    found: list[str] = []

    def expect(condition: bool, what: str) -> None:
        if not condition:
            found.append(what)

    root = xml.fromstring(text)
    expect(root.tag == "executable", "the root is 'executable'")
    tags = [element.tag for element in root]
    expect(tags[:len(HEAD)] == HEAD, f"first {HEAD}")
    groups = root.findall("parameters")
    expect(tags[len(HEAD):] == ["parameters"] * len(groups) and bool(groups), "then groups of parameters")
    names: list[str] = []
    indices: list[int] = []
    for group in groups:
        expect([element.tag for element in group][:2] == ["label", "description"] and len(group) > 2, "a group has label and description")
        expect(set(group.attrib) <= {"advanced"}, "attributes of a group")
        for parameter in list(group)[2:]:
            check_parameter(parameter, names, indices, expect)
    expect(len(names) == len(set(names)), "names are unique")
    expect(sorted(indices) == list(range(len(indices))), "indices count from 0")
    return found


def check_parameter(parameter: xml.Element, names: list[str], indices: list[int], expect) -> None:  # type: ignore[no-untyped-def]
    """Checks one parameter of a group."""
    where = f"{parameter.tag} '{parameter.findtext('name')}': "
    expect(parameter.tag in KINDS, where + "kind")
    more, attributes = KINDS.get(parameter.tag, (set(), set()))
    tags = [element.tag for element in parameter]
    order = ["name", "flag", "longflag", "index", "description", "label", "default", "channel", "element", "constraints"]
    expect(tags == sorted(tags, key=order.index), where + "order of elements")
    expect({"name", "description", "label"} <= set(tags), where + "name, description and label")
    expect(set(tags) <= {*order[:8], *more}, where + "no other elements")
    expect(all(tags.count(tag) == 1 for tag in tags if tag != "element"), where + "each element once")
    expect(("index" in tags) != bool({"flag", "longflag"} & set(tags)), where + "a flag or an index")
    expect(set(parameter.attrib) <= {*attributes, "hidden"}, where + "attributes")
    for key, value in parameter.attrib.items():
        expect(value in VALUES.get(key, {value}), where + key)
    expect(bool(NAME.fullmatch(parameter.findtext("name") or "")), where + "name")
    expect(bool(NAME.fullmatch(parameter.findtext("longflag") or "x")), where + "longflag")
    names.append(parameter.findtext("name") or "")
    if "index" in tags:
        indices.append(int(parameter.findtext("index") or "-1"))
    if "channel" in tags:
        expect(parameter.findtext("channel") in ("input", "output"), where + "channel")
    if parameter.tag in ("image", "file", "directory"):
        expect("channel" in tags, where + "a file has a channel")
    if parameter.tag in ("integer", "double", "string-enumeration"):  # Slicer always passes these kinds
        expect(bool(parameter.findtext("default")), where + "default")
    constraints = parameter.find("constraints")
    if constraints is not None:
        expect({c.tag for c in constraints} <= {"minimum", "maximum", "step"} and constraints.find("step") is not None,
               where + "constraints")
        for constraint in constraints:
            float(constraint.text or "")
    if parameter.tag.endswith("-enumeration"):
        expect(parameter.findtext("default") in [element.text for element in parameter.findall("element")], where + "default")


def slicer_call(text: str, values: dict[str, list[str]]) -> list[str]:
    """Returns the arguments that Slicer builds from a description: flags in order (numbers and choices always, one flag per
    point, files if given), then parameters with an index."""
    flags: list[str] = []
    indexed: dict[int, str] = {}
    for parameter in (p for group in xml.fromstring(text).findall("parameters") for p in list(group)[2:]):
        name = parameter.findtext("name") or ""
        given = values.get(name, [])
        if parameter.findtext("index") is not None:
            indexed |= {int(parameter.findtext("index") or ""): given[0]} if given else {}
            continue
        if not given and parameter.tag in ("integer", "double", "string-enumeration"):
            given = [parameter.findtext("default") or ""]
        for value in given:
            flags += ["--" + (parameter.findtext("longflag") or ""), value]
    return flags + [indexed[index] for index in sorted(indexed)]


class SlicerTest(unittest.TestCase):
    def test_description_keeps_the_schemas(self) -> None:
        text = call("--xml")
        self.assertEqual(text, call("segment", "--xml"))
        self.assertEqual(faults(text), [])

    def test_the_rules_notice_faults(self) -> None:
        text = call("--xml")
        for before, after in (("<title>SimplexSeg</title>", ""), ('coordinateSystem="lps"', 'coordinateSystem="LPS"'),
                              ("<longflag>seed</longflag>", ""), ("<longflag>seed</longflag>", "<longflag>a-b</longflag>"),
                              ("<index>1</index>", "<index>2</index>"), ("<name>radius</name>", "<name>seed</name>"),
                              ("<default>10</default>", ""), ("<channel>input</channel>", "<channel>in</channel>"),
                              ("<step>0.5</step>", ""), ("<default>auto</default>", "<default>none</default>")):
            self.assertIn(before, text)
            self.assertNotEqual(faults(text.replace(before, after, 1)), [], after or before)

    def test_every_flag_is_an_option(self) -> None:
        help_text = call("segment", "--help")
        flags = [flag.text for flag in xml.fromstring(call("--xml")).iter("longflag")]
        self.assertIn("seed", flags)
        for flag in flags:
            self.assertRegex(help_text, rf"--{flag}\b")

    def test_a_call_as_slicer_makes_it(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            image, plain, slicer = (str(Path(folder) / name) for name in ("image.nrrd", "plain.nrrd", "slicer.nrrd"))
            call("phantom", "two-spheres", str(Path(folder) / "x.nii"), "--labels", str(Path(folder) / "two.nii"), "--size", "32")
            call("phantom", "label-image", str(Path(folder) / "two.nii"), image)
            seeds = ["-7.5,0,0", "7.5,0,0"]
            arguments = slicer_call(call("--xml"), {"image": [image], "labels": [slicer], "seed": seeds,
                                                    "report": [str(Path(folder) / "report.json")]})
            self.assertEqual(arguments[:2], ["--seed", "-7.5,0,0"])
            self.assertIn("--backend", arguments)
            call(*arguments)
            call("segment", image, plain, "--seed", seeds[0], "--seed", seeds[1], "--radius", "10")
            self.assertEqual(Path(slicer).read_bytes(), Path(plain).read_bytes())
            self.assertTrue((Path(folder) / "report.json").exists())


if __name__ == "__main__":
    PROGRAM = sys.argv.pop(1)
    unittest.main()
