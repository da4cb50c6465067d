# SPDX-License-Identifier: Apache-2.0
"""Builds the tests of a module with its faults as switches, and runs the cases that reach a fault with the fault switched on."""
import collections
import concurrent.futures
import json
import os
import pathlib
import re
import resource
import shlex
import shutil
import subprocess
import sys
import time
import xml.etree.ElementTree as xml

from mutation.faults import switched

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
BUILD = ROOT / "build" / "release"
WORK = ROOT / "build" / "mutate"
SWITCHES = pathlib.Path(__file__).resolve().parent / "switches.cpp"
QUICK_S = 1        # longest time of a case that is run
FIRST = 12         # so many of the cases that reach a fault, the quickest, are run before the others
MEMORY = 6 << 30   # address space of a test, bytes
JOBS = os.cpu_count() or 1


def words_of_command(command):
    """Words of the last compile or link command of a line of Ninja, without launchers and errors for warnings."""
    words = [w for w in shlex.split(command) if w not in (":", "&&")]
    first = next(n for n, w in enumerate(words) if re.search(r"(^|/)(c\+\+|g\+\+|clang\+\+)[\d.-]*$", w))
    return [w for w in words[first:] if w != "-Werror"] + ["-w"]


def run(words, cwd, limit_s, limits=False, variables=None):
    """Exit status and output of a command; status None for more than `limit_s`."""
    set_limits = (lambda: resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))) if limits else None
    process = subprocess.Popen(words, cwd=cwd, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace", start_new_session=True,
                               preexec_fn=set_limits, env=os.environ | (variables or {}))
    try:
        output, _ = process.communicate(timeout=limit_s)
        return process.returncode, output
    except subprocess.TimeoutExpired:
        subprocess.run(["kill", "-KILL", "--", f"-{process.pid}"], stderr=subprocess.DEVNULL)
        process.communicate()
        return None, ""


def sandbox():
    """Command under which tests run: a fault can delete or replace any file, so all but /tmp and build/mutate is read-only, and /dev is private."""
    words = ["bwrap", "--die-with-parent", "--ro-bind", "/", "/", "--dev", "/dev", "--tmpfs", "/tmp", "--ro-bind", str(ROOT), str(ROOT), "--bind", str(WORK), str(WORK)]
    if not shutil.which("bwrap") or subprocess.run([*words, "true"], capture_output=True).returncode != 0:
        print("mutate: faults are only tried in a sandbox, and bwrap does not work here; install bubblewrap, or permit namespaces", file=sys.stderr)
        sys.exit(77)
    return words


def in_parallel(function, items):
    with concurrent.futures.ThreadPoolExecutor(JOBS) as pool:
        return list(pool.map(function, items))


class Batch:
    """Sources that are compiled as one, some of them with switches."""

    def __init__(self, words, members, object_file, folder, faults):
        self.words, self.members, self.object, self.folder, self.faults = words, members, object_file, folder, faults
        self.dropped = []   # faults that do not compile

    def compile(self):
        stages = collections.Counter()   # line of a source: how often it did not compile
        while True:
            self.write()
            words = list(self.words)
            words[words.index("-o") + 1] = str(self.object)
            words[words.index("-c") + 1] = str(self.folder / "batch.cpp")
            for member in self.members:
                words += ["-I", str(pathlib.Path(member).parent)]
            launcher = ["ccache"] if shutil.which("ccache") else []
            status, output = run([*launcher, *words, "-O1", "-fmax-errors=0"], BUILD, 900, variables={"CCACHE_BASEDIR": str(ROOT)})
            if status == 0:
                return
            if not self.drop(output, stages):
                sys.exit(f"mutate: {self.members[0]} does not compile: {output[-1000:]}")

    def write(self):
        self.folder.mkdir(parents=True, exist_ok=True)
        lines = ["bool simplexseg_fault(int);", "bool simplexseg_condition(int, int, bool);"]
        for member in self.members:
            path = str(pathlib.Path(member).relative_to(ROOT)) if member.startswith(str(ROOT)) else member
            faults = [one for one in self.faults if one.path == path]
            if faults:
                copy = self.folder / path.replace("/", "-")
                copy.write_text(switched(pathlib.Path(member).read_text(encoding="utf-8"), faults), encoding="utf-8")
                member = copy
            lines.append(f'#include "{member}"')
        (self.folder / "batch.cpp").write_text("\n".join(lines) + "\n", encoding="utf-8")

    def drop(self, output, stages):
        """Drops the faults in lines that do not compile: operators and numbers first, then the others, conditions last."""
        ranks = {"arithmetic": 0, "constant": 0, "comparison": 0, "logic": 1, "early return": 0, "statement removed": 1}
        places = set(re.findall(r"([\w.-]+\.cpp):(\d+):\d+: error:", output)) or set(re.findall(r"([\w.-]+\.cpp):(\d+):\d+:", output))
        before = len(self.faults)
        for name, row in places:
            stages[name, row] += 1
            kept = []
            for one in self.faults:
                text = (ROOT / one.path).read_text(encoding="utf-8") if one.path.replace("/", "-") == name else None
                lies_there = text is not None and text.count("\n", 0, one.span[0]) < int(row) <= text.count("\n", 0, max(one.span[1] - 1, 0)) + 1
                drops = lies_there and ranks.get(one.kind, 2) < stages[name, row]
                (self.dropped if drops else kept).append(one)
            self.faults = kept
        return len(self.faults) < before or (places and max(stages.values()) < 4)


class Module:
    """Tests of a module with its faults as switches."""

    def __init__(self, name, faults):
        self.name, self.test = name, f"{name}_test"
        self.folder = WORK / name
        shutil.rmtree(self.folder, ignore_errors=True)
        (self.folder / "bin").mkdir(parents=True)
        self.sandbox = sandbox()
        self.cases = self.quick_cases()
        self.batches = self.make_batches(faults)
        in_parallel(Batch.compile, self.batches)
        self.dropped = [one for batch in self.batches for one in batch.dropped]
        self.link()
        self.reached = self.find_reached([one for batch in self.batches for one in batch.faults])

    def quick_cases(self):
        """Quick cases that pass: name and time in s."""
        cases, results = {}, sorted((BUILD / "results").glob(f"{self.test}_*shard_*.xml"))
        if not results:
            results = [WORK / f"{self.test}.xml"]
            if not results[0].exists() or results[0].stat().st_mtime < (BUILD / "bin" / self.test).stat().st_mtime:
                print(f"mutate: measures the cases of {self.test}", file=sys.stderr)
                subprocess.run([BUILD / "bin" / self.test, "--gtest_brief=1", f"--gtest_output=xml:{results[0]}"], cwd=BUILD, stdout=subprocess.DEVNULL)
        for file in results:
            for case in xml.parse(file).getroot().iter("testcase"):
                if case.get("status") == "run" and case.get("result") == "completed" and case.find("failure") is None and float(case.get("time")) <= QUICK_S:
                    cases[f"{case.get('classname')}.{case.get('name')}"] = float(case.get("time"))
        return cases

    def make_batches(self, faults):
        paths, batches, found = {one.path for one in faults}, [], set()
        for entry in json.loads((BUILD / "compile_commands.json").read_text(encoding="utf-8")):
            if f"/simplexseg_{self.name}.dir/" not in entry["command"]:
                continue
            words, source = words_of_command(entry["command"]), pathlib.Path(entry["file"])
            members = re.findall(r'#include "(.*)"', source.read_text(encoding="utf-8")) if "/Unity/" in entry["file"] else [entry["file"]]
            own = {str(pathlib.Path(one).relative_to(ROOT)) for one in members if one.startswith(str(ROOT))} & paths
            if own:
                found |= own
                number = len(batches)
                batches.append(Batch(words, members, self.folder / f"{number}.o", self.folder / str(number), [one for one in faults if one.path in own]))
        if missing := paths - found:
            print(f"mutate: not part of the library of {self.name}, not tried: {' '.join(sorted(missing))}", file=sys.stderr)
        return batches

    def link(self):
        """The library with the switched objects in place of the own ones, and the programs of the tests with it."""
        built = {str(BUILD / one.words[one.words.index("-o") + 1]) for one in self.batches}
        objects = sorted(str(one) for one in (BUILD / f"src/{self.name}/CMakeFiles/simplexseg_{self.name}.dir").rglob("*.o"))
        compiler = self.batches[0].words[0] if self.batches else "c++"
        subprocess.run([compiler, "-std=c++20", "-O2", "-c", SWITCHES, "-o", self.folder / "switches.o"], check=True)
        library = self.folder / "library.a"
        subprocess.run(["ar", "rcs", library, self.folder / "switches.o", *(one.object for one in self.batches), *(one for one in objects if one not in built)], check=True)
        for program in [self.test] + (["simplexseg-reader"] if self.name == "io" else []):
            lines = subprocess.run(["ninja", "-C", BUILD, "-t", "commands", program], capture_output=True, text=True, check=True).stdout
            words = words_of_command([row for row in lines.splitlines() if " -o bin/" in row][-1])
            words = [str(library) if w == f"src/{self.name}/libsimplexseg_{self.name}.a" else w for w in words]
            words[words.index("-o") + 1] = str(self.folder / "bin" / program)
            status, output = run(words, BUILD, 600)
            if status != 0:
                sys.exit(f"mutate: {program} cannot be linked: {output[-1000:]}")

    def run_cases(self, names, limit_s, variables):
        command = [*self.sandbox, str(self.folder / "bin" / self.test), "--gtest_brief=1", "--gtest_fail_fast", "--gtest_filter=" + ":".join(names)]
        return run(command, BUILD, limit_s, limits=True, variables=variables)

    def find_reached(self, faults):
        """Number of a fault to the cases in which it could have an effect, the quickest first."""
        known = {one.id for one in faults}
        if len(known) < len(faults):
            sys.exit("mutate: two faults have the same number")   # a checksum of 31 bits
        reached = collections.defaultdict(list)

        def record(name):
            file = self.folder / ("reached-" + re.sub(r"\W", "-", name))
            status, output = self.run_cases([name], 60, {"SIMPLEXSEG_REACHED": str(file)})
            if status != 0:
                print(f"mutate: without a fault, {name} fails alone; not used: {output[-300:]}", file=sys.stderr)
                return name, set()
            data = file.read_bytes() if file.exists() else b""
            file.unlink(missing_ok=True)
            return name, {int.from_bytes(data[n:n + 4], sys.byteorder) for n in range(0, len(data), 4)}

        for name, numbers in in_parallel(record, sorted(self.cases, key=self.cases.get)):
            for number in numbers:
                reached[number].append(name)
        return reached

    def attempt(self, fault):
        """Sets the result of a fault."""
        cases = self.reached.get(fault.id, [])
        fault.result = ""
        for stage in (cases[:FIRST], cases[FIRST:]):
            if not stage:
                break
            status, output = self.run_cases(stage, 5 + 10 * sum(self.cases[one] + 0.02 for one in stage), {"SIMPLEXSEG_FAULT": str(fault.id)})
            if status is None:
                fault.result = "time limit"
            elif status != 0:
                failed = re.search(r"\[  FAILED  \] ([\w./]+)", output)
                fault.result = failed.group(1).rstrip(",") if failed else "crash"
            if fault.result:
                break

    def is_reached(self, fault):
        return fault.id in self.reached


def attempt_all(module, faults, end):
    """Tries faults in their order until a point in time of time.monotonic(), or all. Prints one line each."""
    def attempt(fault):
        if time.monotonic() < end:
            module.attempt(fault)
            survived = "SURVIVED" if module.is_reached(fault) else "SURVIVED, not reached"
            print(f"{fault.path}:{fault.line}: {fault.describe()}: {fault.result or survived}", flush=True)
    in_parallel(attempt, faults)
