# SPDX-License-Identifier: Apache-2.0
"""Program of scripts/cohort: checks a table, runs its cases with Snakemake and writes the page."""
from __future__ import annotations

import argparse
import fcntl
import json
import math
import os
import re
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import yaml

from cohort.bids import PIPELINE, derivatives_of, write_dataset
from cohort.learn import Learner, NotLearned, model_checksum
from cohort.page import write_page
from cohort.results import find_outliers, is_done, read_result, write_summary
from cohort.table import BadInput, Case, Table

WORKFLOWS = Path(__file__).resolve().parent.parent
MEGABYTE = 1e6
# Memory of Snakemake in a job on a cluster, in addition to the program.
SNAKEMAKE_MB = 250
# Upper bound of the memory of a case, as a multiple of its file size; decides whether a plan is computed for each case.
MAX_MEMORY_PER_FILE_SIZE = 400
# Fraction of the free memory of one machine that is available to cases.
MEMORY_FRACTION = 0.9


def read_settings(path: Path | None) -> dict[str, Any]:
    """Returns the settings of workflows/config.yaml, overridden by those of a config file."""
    defaults: dict[str, Any] = yaml.safe_load((WORKFLOWS / "config.yaml").read_text())
    if path is None:
        return defaults
    try:
        overrides = yaml.safe_load(path.read_text()) or {}
    except (OSError, yaml.YAMLError) as error:
        reason = error.strerror if isinstance(error, OSError) else "it is not valid YAML: " + " ".join(str(error).split())
        raise BadInput(f"config '{path}': {reason}; see workflows/config.yaml") from None
    if not isinstance(overrides, dict):
        raise BadInput(f"config '{path}': it is not a list of keys and values; see workflows/config.yaml")
    for key, value in overrides.items():
        if key not in defaults:
            raise BadInput(f"config '{path}': there is no key '{key}'; the keys are {', '.join(defaults)}")
        kind: Any = (int, float) if isinstance(defaults[key], float) else type(defaults[key])
        if not isinstance(value, kind) or (isinstance(value, bool) and kind is not bool):
            raise BadInput(f"config '{path}': '{key}' is not of type {type(defaults[key]).__name__}; see workflows/config.yaml")
    if overrides.get("scene"):
        overrides["scene"] = os.path.normpath(path.parent.absolute() / overrides["scene"])
        if not os.path.exists(overrides["scene"]):
            raise BadInput(f"config '{path}': there is no scene '{overrides['scene']}'; correct 'scene'")
    return defaults | overrides


def outputs_of(case: Case, settings: dict[str, Any]) -> list[str]:
    """Returns the arguments for the outputs of a case and the settings of the cohort."""
    folder = f"cases/{case.name}"
    arguments = ["--labels", f"{folder}/{settings['labels']}", "--meshes", f"{folder}/meshes"]
    arguments += ["--mesh-format", settings["mesh_format"], "--report", f"{folder}/report.json"]
    arguments += ["--picture", f"{folder}/picture.png", "--picture-size", str(settings["picture_size"])]
    if settings["scenes"]:
        arguments += ["--save", f"{folder}/scene.json"]
    if settings["steps"] > 0:
        arguments += ["--steps", str(settings["steps"])]
    for setting in settings["settings"]:
        arguments += ["--set", setting]
    return arguments


def read_plan(program: str, case: Case) -> tuple[float, float]:
    """Returns the estimated memory (MB) and time (s) of a case; 0 if its volume cannot be read, which the run reports."""
    done = subprocess.run([program, *case.arguments, "--plan"], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        return 0, 0
    plan = json.loads(done.stdout)
    return plan["process_bytes"] / MEGABYTE, plan["run_seconds"]


def machine_mb() -> float:
    """Returns the free memory of this machine, MB."""
    with open("/proc/meminfo", encoding="ascii") as file:
        found = re.search(r"MemAvailable:\s+(\d+) kB", file.read())
    return int(found[1]) * 1024 / MEGABYTE if found else math.inf


def needs_plans(cases: list[Case], at_once: int) -> bool:
    """Returns whether parallel runs of the largest volumes could exceed the memory of this machine."""
    sizes = sorted((size_of(Path(case.inputs[0])) for case in cases), reverse=True)
    return sum(sizes[:at_once]) * MAX_MEMORY_PER_FILE_SIZE / MEGABYTE > machine_mb()


def size_of(path: Path) -> int:
    """Returns the size of a file, or of all files in a folder, bytes."""
    return sum(file.stat().st_size for file in path.rglob("*")) if path.is_dir() else path.stat().st_size


def make_cohort(options: argparse.Namespace, cases: list[Case], settings: dict[str, Any]) -> dict[str, Any]:
    """Returns the content of cohort.json for the Snakefile."""
    slurm = options.profile == "slurm"
    plans: list[tuple[float, float]] = [(0, 0)] * len(cases)
    if slurm or needs_plans(cases, options.jobs):
        with ThreadPoolExecutor(options.cores) as pool:
            plans = list(pool.map(lambda case: read_plan(options.program, case), cases))
    entries = []
    for case, (megabytes, seconds) in zip(cases, plans):
        # Local: the estimate. Cluster: an upper bound, because Slurm kills jobs that exceed their limit.
        memory = megabytes * settings["memory_margin"] + SNAKEMAKE_MB if slurm else megabytes
        entries.append({"name": case.name, "arguments": case.arguments + outputs_of(case, settings), "inputs": case.inputs,
                       "mem_mb": math.ceil(memory),
                       "minutes": math.ceil(seconds * settings["time_margin"] / 60) + 1})
    max_mb = settings["most_memory_gb"] * 1000 if slurm else int(machine_mb() * MEMORY_FRACTION)
    return {"cases": entries, "threads": settings["threads"], "gpu": int(options.profile == "gpu"), "most_mb": max_mb}


def snakemake_command(options: argparse.Namespace, settings: dict[str, Any], case: str = "") -> list[str]:
    """Returns the command line of Snakemake. `case`: name of the only case to run; "": all."""
    engine = {"local": f"--backend cpu --threads {settings['threads']}", "gpu": "--backend cuda",
              "slurm": f"--backend {options.backend}" + (f" --threads {settings['threads']}" * (options.backend == "cpu"))}
    command = ["snakemake", *([f"cases/{case}/status"] if case else []), "--snakefile", str(WORKFLOWS / "Snakefile"), "--directory", str(options.out),
               "--profile", str(WORKFLOWS / "profiles" / options.profile), "--retries", str(settings["retries"]),
               "--config", f"cli={options.program}", f"engine={engine[options.profile]}"]
    extra: list[str] = options.snakemake
    if options.profile == "slurm":
        return command + extra
    cores = options.cores * (settings["threads"] if options.profile == "gpu" else 1)
    return command + ["--cores", str(cores), "--resources", f"mem_mb={int(machine_mb() * MEMORY_FRACTION)}",
                      f"gpu={options.jobs}"] + extra


def run_snakemake(command: list[str], log: Path, total: int) -> str:
    """Runs Snakemake, writes its output to the log and the number of finished cases to the terminal. Ctrl+C also reaches
    Snakemake. Returns the last line of the output."""
    line = ""
    with open(log, "a", encoding="utf-8") as file:
        print("$", *command, file=file, flush=True)
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as process:
            assert process.stdout
            try:
                for line in process.stdout:
                    file.write(line)
                    found = re.match(r"(\d+) of (\d+) steps", line)
                    if found and sys.stderr.isatty():
                        done = total - int(found[2]) + 1 + int(found[1])
                        print(f"\r{min(done, total)} of {total} cases", end="", file=sys.stderr, flush=True)
            except KeyboardInterrupt:
                process.wait()
                raise
    if sys.stderr.isatty():
        print("\r\033[K", end="", file=sys.stderr)
    return line.strip()


def write_cohort(options: argparse.Namespace, cohort: dict[str, Any]) -> None:
    """Writes the input of the Snakefile."""
    (options.out / "cohort.json").write_text(json.dumps(cohort, indent=1) + "\n")


def run_learning(options: argparse.Namespace, cases: list[Case], cohort: dict[str, Any],
                 settings: dict[str, Any]) -> tuple[str, dict[str, str]]:
    """Runs the cases in the order of the table, each with the model of the accepted cases before it. Returns the last line of
    Snakemake, and the reasons why accepted cases were not learned."""
    learner = Learner(options.program, options.out, options.learn, options.model, settings["mesh"])
    last = ""
    not_learned: dict[str, str] = {}
    for case, entry in zip(cases, cohort["cases"]):
        model = learner.model_for(case.name)
        if model:
            entry["arguments"] = entry["arguments"] + ["--model", str(model)]
            entry["inputs"] = entry["inputs"] + [str(model)]
        write_cohort(options, cohort)
        last = run_snakemake(snakemake_command(options, settings, case.name), options.out / "logs" / "snakemake.log", len(cases))
        folder = options.out / "cases" / case.name
        if not is_done(folder, settings["labels"]):
            continue
        learner.record(case.name)
        try:
            learner.learn(case, folder)
        except NotLearned as error:
            not_learned[case.name] = str(error)
    return last, not_learned


def parse(arguments: list[str]) -> argparse.Namespace:
    """Parses the command line."""
    parser = argparse.ArgumentParser(prog="scripts/cohort", description="Segments the volumes of a table and writes one page with the results.",
                                     epilog="After --: further options of Snakemake.")
    parser.add_argument("table", type=Path, metavar="TABLE", help="CSV file with one row per case (docs/cohort.md)")
    parser.add_argument("out", type=Path, metavar="OUT", help="folder of the results; existing results are kept")
    parser.add_argument("--profile", choices=("local", "gpu", "slurm"), default="local",
                        help="cores of this machine, its GPU, or a Slurm cluster (default: local)")
    parser.add_argument("--config", type=Path, help="YAML file with settings of all cases, see workflows/config.yaml")
    parser.add_argument("--model", type=Path, help="model of the organ (simplexseg-cli model train), for rows that name none")
    parser.add_argument("--learn", type=Path, metavar="MODEL",
                        help="model to write: cases run in the order of the table, and each accepted case is added to the model "
                             "that the following ones use")
    parser.add_argument("--bids", metavar="DESC",
                        help="also write the labels as a BIDS derivative dataset, OUT/derivatives/simplexseg, with names of "
                             "desc-DESC; images must be in a BIDS dataset")
    parser.add_argument("--cores", type=int, default=len(os.sched_getaffinity(0)),
                        help="cores to use on this machine (default: all)")
    parser.add_argument("--gpu-processes", type=int, default=4, help="processes that share the GPU (default: 4)")
    parser.add_argument("--backend", choices=("cpu", "cuda"), default="cpu", help="backend of jobs on a cluster (default: cpu)")
    split = arguments.index("--") if "--" in arguments else len(arguments)
    options = parser.parse_args(arguments[:split])
    options.snakemake = arguments[split + 1:]
    if options.cores < 1 or options.gpu_processes < 1:
        parser.error("--cores and --gpu-processes must be at least 1")
    if options.profile == "slurm" and not shutil.which("sbatch"):
        raise BadInput("--profile slurm: sbatch is missing; run this on a submit host, or install slurm-client")
    options.program = os.environ["SIMPLEXSEG_CLI"]
    options.jobs = options.gpu_processes if options.profile == "gpu" else options.cores
    if options.profile == "gpu":
        options.cores = max(options.cores, options.gpu_processes)
    return options


def run(options: argparse.Namespace) -> int:
    """Runs the cohort. Returns the exit status: 0, or 1 if a case failed."""
    settings = read_settings(options.config)
    cases = Table(options.table, options.model, options.learn is not None).cases(settings["scene"], settings["mesh"])
    places = derivatives_of(cases, settings, options.bids) if options.bids is not None else []
    if options.model and not options.learn:
        model_checksum(options.program, options.model)
    logs = options.out / "logs"
    try:
        logs.mkdir(parents=True, exist_ok=True)
        lock = open(logs / "lock", "w", encoding="ascii")  # locked until the process ends
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        cohort = make_cohort(options, cases, settings)
        write_cohort(options, cohort)
    except BlockingIOError:
        raise BadInput(f"folder '{options.out}': another call uses it; wait for its end, or choose another folder") from None
    except OSError as error:
        raise BadInput(f"folder '{options.out}': {error.strerror}; choose another folder") from None
    folders = {case.name: options.out / "cases" / case.name for case in cases}
    before: dict[str, int] = {}
    for name, folder in folders.items():
        if is_done(folder, settings["labels"]):
            before[name] = (folder / "status").stat().st_mtime_ns
        else:
            (folder / "status").unlink(missing_ok=True)  # failed cases run again
            (folder / "errors.log").unlink(missing_ok=True)
    not_learned: dict[str, str] = {}
    if options.learn:
        last, not_learned = run_learning(options, cases, cohort, settings)
    else:
        last = run_snakemake(snakemake_command(options, settings), logs / "snakemake.log", len(cases))
    if len(before) < len(cases) and not any((folders[name] / "errors.log").exists()
                                           for name in folders.keys() - before.keys()):
        raise BadInput(f"Snakemake ran no case: {last}; see {logs / 'snakemake.log'}")
    results = [read_result(name, folder, settings["labels"], settings["steps"] == 0) for name, folder in folders.items()]
    find_outliers(results)
    write_summary(options.out / "summary.csv", results)
    write_page(options.out / "index.html", options.table.stem, results)
    failed = [result for result in results if result.failure]
    if places:
        finished = {result.name: result.folder for result in results if not result.failure}
        write_dataset(options.out / "derivatives" / PIPELINE, places, finished, settings, options.program)
    kept = sum(1 for result in results if not result.failure
               and before.get(result.name) == (result.folder / "status").stat().st_mtime_ns)
    for result in failed:
        print(f"{result.name}: {result.failure}", file=sys.stderr)
    for name, why in not_learned.items():
        print(f"{name}: not learned: {why}", file=sys.stderr)
    print(f"{len(results) - len(failed) - kept} done, {len(failed)} failed, {kept} skipped (done before); "
          f"page: {options.out / 'index.html'}")
    return 1 if failed or not_learned else 0


def main() -> int:
    """Returns the exit status; 2 for invalid usage or input, before any case runs."""
    try:
        return run(parse(sys.argv[1:]))
    except BadInput as error:
        print(f"cohort: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("cohort: interrupted; repeat the call to continue", file=sys.stderr)
        return 130


if __name__ == "__main__":
    sys.exit(main())
