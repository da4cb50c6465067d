# SPDX-License-Identifier: Apache-2.0
"""Agreement of the type stubs with the module."""

import ast
import importlib.util
import inspect
import pathlib
import re
import subprocess
import sys

import pytest

import simplexseg
from simplexseg import _core

PACKAGE = pathlib.Path(simplexseg.__file__).parent
STUB = ast.parse((PACKAGE / "_core.pyi").read_text())
CLASSES = {node.name: node for node in STUB.body if isinstance(node, ast.ClassDef)}
BOUND = [name for name in CLASSES if not name.startswith("_") and "Error" not in name and "Warning" not in name]
OBJECT = {*dir(object), "__module__", "__dict__", "__weakref__"}


def public(names):
    return {name for name in names if not name.startswith("_") or name == "__version__"}


def members(node):
    """Returns the functions, properties and attributes of a class in the stub."""
    found = {}
    for entry in node.body:
        if isinstance(entry, ast.FunctionDef):
            found[entry.name] = entry
        elif isinstance(entry, ast.AnnAssign):
            found[entry.target.id] = entry
    return found


def stub_signature(node):
    """Returns (name, default as text or None, keyword only) of each parameter."""
    arguments = node.args
    positional = [*arguments.posonlyargs, *arguments.args]
    defaults = [None] * (len(positional) - len(arguments.defaults)) + list(arguments.defaults)
    pairs = list(zip(positional, defaults, [False] * len(positional)))
    pairs += zip(arguments.kwonlyargs, arguments.kw_defaults, [True] * len(arguments.kwonlyargs))
    return [(a.arg, None if d is None else ast.literal_eval(d), k) for a, d, k in pairs if a.arg != "self"]


def bound_signature(function, name):
    """Parses the signature that pybind11 writes to the first line of a docstring, like stub_signature()."""
    line = function.__doc__.splitlines()[0]
    text = re.sub(r"\[[^\[\]]*\]", "", re.sub(r"\[[^\[\]]*\]", "", re.sub(r"\[[^\[\]]*\]", "", line)))
    text = re.sub(r": [A-Za-z_.:0-9]+(?=[ ,)])", "", text.split(" -> ")[0] + " ")
    call = ast.parse(f"def {text.strip()}: pass").body[0]
    assert call.name == name
    return stub_signature(call)


def test_the_package_exports_the_whole_module():
    assert public(simplexseg.__all__) == public(dir(_core))
    assert sorted(simplexseg.__all__) == simplexseg.__all__
    assert all(getattr(simplexseg, name) is getattr(_core, name) for name in simplexseg.__all__)
    assert (PACKAGE / "py.typed").exists()


def test_the_stub_has_exactly_the_names_of_the_module():
    names = set(CLASSES) | {node.name for node in STUB.body if isinstance(node, ast.FunctionDef)}
    names |= {node.target.id for node in STUB.body if isinstance(node, ast.AnnAssign)}
    assert public(names) == public(dir(_core))


@pytest.mark.parametrize("name", BOUND)
def test_classes_have_the_members_of_the_stub(name):
    bound = {member for member in vars(getattr(_core, name)) if member not in OBJECT}
    bound -= {"__doc__", "__repr__", "__init__"}
    stub = set(members(CLASSES[name])) - {"__init__", "__hash__", "__eq__"}
    assert bound == stub
    for member in stub:
        assert inspect.getdoc(getattr(getattr(_core, name), member)), f"{name}.{member} has no docstring"


def signatures():
    for node in STUB.body:
        if isinstance(node, ast.FunctionDef):
            yield node.name, node, getattr(_core, node.name)
    for name in BOUND:
        for member, node in members(CLASSES[name]).items():
            if not isinstance(node, ast.FunctionDef) or member in ("__exit__", "__hash__", "__eq__"):
                continue
            if "property" not in [decorator.id for decorator in node.decorator_list]:
                yield f"{name}.{member}", node, getattr(getattr(_core, name), member)


@pytest.mark.parametrize("name, node, bound", [pytest.param(*entry, id=entry[0]) for entry in signatures()])
def test_functions_have_the_signatures_of_the_stub(name, node, bound):
    expected = stub_signature(node)
    taken = [entry for entry in bound_signature(bound, node.name) if entry[0] not in ("self", "arg0")]
    assert taken == expected, name


def test_types_are_checked(tmp_path):
    if importlib.util.find_spec("mypy") is None:
        pytest.skip("the Debian package mypy is missing")
    source = pathlib.Path(__file__).resolve().parents[2]
    example = re.search(r"```python\n(.*?)```", (source / "README.md").read_text(), re.S).group(1)
    (tmp_path / "readme.py").write_text(example)
    (tmp_path / "wrong.py").write_text("import simplexseg\nsimplexseg.read_volume(3)\nsimplexseg.Mesh().vertices.x\n")
    command = [sys.executable, "-m", "mypy", "--strict", "--cache-dir", str(tmp_path / "cache")]
    files = [str(PACKAGE), str(tmp_path / "readme.py"), str(source / "docs" / "examples" / "segment_and_plot.py")]
    checked = subprocess.run([*command, *files], capture_output=True, text=True, check=False, cwd=tmp_path)
    assert checked.returncode == 0, checked.stdout + checked.stderr
    wrong = subprocess.run([*command, str(tmp_path / "wrong.py")], capture_output=True, text=True, check=False, cwd=tmp_path)
    assert wrong.returncode == 1 and "wrong.py:2" in wrong.stdout and "wrong.py:3" in wrong.stdout
