#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""cohort_test.py PROGRAM: tests of scripts/cohort on one machine."""
from __future__ import annotations

import csv
import json
import os
import re
import signal
import subprocess
import time
from html.parser import HTMLParser
from pathlib import Path

import fixture
from fixture import SHAPES, CohortFixture


class Page(HTMLParser):
    """Contents of a page: the order of its cases, and its addresses."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.cases: list[str] = []
        self.pictures = 0
        self.addresses: list[str] = []
        self.tags: list[str] = []
        self.text = path.read_text(encoding="utf-8")
        self.feed(self.text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        given = {key: value or "" for key, value in attrs}
        if tag == "article":
            self.cases.append(given["id"].removeprefix("case-"))
        self.pictures += tag == "img"
        self.addresses += [given[key] for key in ("src", "href", "action", "srcset") if key in given]


class CohortTest(CohortFixture):
    def summary(self) -> list[dict[str, str]]:
        with open(self.out / "summary.csv", newline="", encoding="utf-8") as file:
            return list(csv.DictReader(file))

    def test_cases_equal_single_runs_and_a_broken_one_is_reported(self) -> None:
        self.break_a_volume()
        self.write_table(self.rows)
        done = self.cohort()
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertEqual(done.stdout, f"3 done, 1 failed, 0 skipped (done before); page: {self.out}/index.html\n")
        self.assertRegex(done.stderr, r"(?m)^broken: .*broken\.nii\.gz")
        self.assert_labels_of_the_bare_program()
        for name in ("report.json", "picture.png", "meshes/object.ply", "scene.json"):
            self.assertTrue((self.out / "cases" / "cube" / name).is_file(), name)
        rows = self.summary()
        self.assertEqual((rows[0]["name"], rows[0]["state"]), ("broken", "failed"))
        self.assertIn("broken.nii.gz", rows[0]["why"])
        self.assertEqual(sorted(row["name"] for row in rows[1:]), sorted(SHAPES))
        self.assertTrue(all(float(row["dice"]) > 0.3 and float(row["volume_ml"]) > 0 for row in rows[1:]))
        # Page: all cases, failed ones first, no external resources.
        page = Page(self.out / "index.html")
        self.assertEqual(page.cases[0], "broken")
        self.assertEqual(sorted(page.cases), sorted([*SHAPES, "broken"]))
        self.assertEqual(page.pictures, 3)
        self.assertNotIn("link", page.tags)
        for address in page.addresses:
            self.assertRegex(address, r"^(#case-[\w.-]+$|data:image/png;base64,)")
        self.assertNotRegex(page.text, r"https?://|@import|url\(")
        # Only the repaired case runs again.
        stamps = {shape: (self.out / "cases" / shape / "labels.nii.gz").stat().st_mtime_ns for shape in SHAPES}
        (self.folder / "broken.nii.gz").write_bytes((self.folder / "sphere.nii.gz").read_bytes())
        again = self.cohort()
        self.assertEqual(again.returncode, 0, again.stderr)
        self.assertIn("1 done, 0 failed, 3 skipped", again.stdout)
        self.assertEqual(stamps, {shape: (self.out / "cases" / shape / "labels.nii.gz").stat().st_mtime_ns for shape in SHAPES})
        # A case runs again if its row was changed or a result was deleted.
        self.rows[0]["radius"] = "7"
        self.write_table(self.rows)
        (self.out / "cases" / "cube" / "labels.nii.gz").unlink()
        self.assertIn("2 done, 0 failed, 2 skipped", self.cohort().stdout)

    def test_labels_are_a_bids_derivative_dataset(self) -> None:
        places = {"sphere": "sub-01/anat/sub-01_T1w.nii.gz", "cube": "sub-02/ses-a/anat/sub-02_ses-a_acq-x_space-y_T1w.nii.gz"}
        rows = []
        for row in self.rows:
            if row["name"] in places:
                image = self.folder / "raw" / places[row["name"]]
                image.parent.mkdir(parents=True)
                (self.folder / row["image"]).rename(image)
                rows.append({**row, "image": f"raw/{places[row['name']]}"})
        self.write_table(rows)
        done = self.cohort("--bids", "object")
        self.assertEqual(done.returncode, 0, done.stderr)
        root = self.out / "derivatives" / "simplexseg"
        stems = {"sphere": "sub-01/anat/sub-01_desc-object_dseg", "cube": "sub-02/ses-a/anat/sub-02_ses-a_acq-x_desc-object_dseg"}
        files = {"dataset_description.json", "README", *(stem + end for stem in stems.values() for end in (".nii.gz", ".json", ".tsv"))}
        self.assertEqual({str(file.relative_to(root)) for file in root.rglob("*") if file.is_file()}, files)
        for case, stem in stems.items():
            self.assertEqual((root / (stem + ".nii.gz")).read_bytes(), (self.out / "cases" / case / "labels.nii.gz").read_bytes())
            sidecar = json.loads((root / (stem + ".json")).read_text())
            self.assertEqual(sidecar["Sources"], ["bids:raw:" + places[case]])
            with open(root / (stem + ".tsv"), newline="", encoding="utf-8") as file:
                lines = list(csv.reader(file, delimiter="\t"))
            self.assertEqual(lines[0], ["index", "name", "color"])
            self.assertEqual([line[:2] for line in lines[1:]], [["1", "object"]])
            self.assertRegex(lines[1][2], "^#[0-9a-f]{6}$")
        description = json.loads((root / "dataset_description.json").read_text())
        self.assertEqual((description["DatasetType"], description["GeneratedBy"][0]["Name"]), ("derivative", "SimplexSeg"))
        self.assertEqual(description["DatasetLinks"]["raw"], (self.folder / "raw").as_uri())
        # A case that fails later has no labels; the others stay.
        (self.folder / "raw" / places["sphere"]).write_bytes(b"no image")
        self.assertEqual(self.cohort("--bids", "object").returncode, 1)
        self.assertFalse((root / (stems["sphere"] + ".nii.gz")).exists())
        self.assertTrue((root / (stems["cube"] + ".nii.gz")).exists())

    def test_bids_refuses_names_that_it_cannot_follow(self) -> None:
        def refusal(image: str, *arguments: str) -> str:
            path = self.folder / image
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes((self.folder / "sphere.nii.gz").read_bytes())
            self.write_table([{**self.rows[0], "image": image}, *also])
            done = self.cohort("--bids", *(arguments or ("object",)))
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
            self.assertFalse(self.out.exists())
            return done.stderr

        also: list[dict[str, str]] = []
        good = "raw/sub-1/anat/sub-1_T1w.nii.gz"
        self.assertIn("letters and digits only", refusal(good, "left kidney"))
        self.assertIn("is not named as in BIDS", refusal("raw/sub-1/anat/head.nii.gz"))
        self.assertIn("is not named as in BIDS", refusal("raw/sub-1/images/sub-1_T1w.nii.gz"))
        self.assertIn("are not those of its name", refusal("raw/sub-2/anat/sub-1_T1w.nii.gz"))
        self.assertIn("are not those of its name", refusal("raw/sub-1/anat/sub-1_ses-2_T1w.nii.gz"))
        also = [{**self.rows[1], "image": good}]
        self.assertIn("have the same image", refusal(good))
        also = [{**self.rows[1], "image": "ellipsoid.nii.gz"}]
        self.assertIn("case 'ellipsoid'", refusal(good))
        other = self.folder / "other/sub-3/anat/sub-3_T1w.nii.gz"
        other.parent.mkdir(parents=True)
        other.write_bytes((self.folder / "sphere.nii.gz").read_bytes())
        also = [{**self.rows[1], "image": str(other)}]
        self.assertIn("different datasets", refusal(good))

    def test_rows_of_every_kind(self) -> None:
        (self.folder / "template.json").write_text(json.dumps({
            "simplexseg_scene": 1, "simulation": {"final_vertices": 320}, "steps": 20,
            "meshes": [{"name": "ball", "label": 3, "sphere": {"centre_mm": [1, 0, 0], "radius_mm": 8}}]}))
        self.config.write_text("steps: 0\nscenes: false\nmesh_format: stl\nlabels: labels.nrrd\n")
        image = {"image": "sphere.nii.gz"}
        self.write_table([
            image | {"name": "template", "scene": "template.json"},
            image | {"name": "placed", "scene": "template.json", "x": "3", "y": "0", "z": "0", "radius": "6"},
            image | {"name": "labels", "labels": "sphere_truth.nii.gz", "reference": "sphere_truth.nii.gz", "reference_label": "1"}])
        done = self.cohort()
        self.assertEqual(done.returncode, 0, done.stderr)
        self.call("segment", "sphere.nii.gz", "bare.nrrd", "--scene", "template.json")
        labels = {name: (self.out / "cases" / name / "labels.nrrd").read_bytes() for name in ("template", "placed", "labels")}
        self.assertEqual(labels["template"], (self.folder / "bare.nrrd").read_bytes())
        self.assertNotEqual(labels["placed"], labels["template"])
        self.assertTrue((self.out / "cases" / "placed" / "meshes" / "ball.stl").is_file())
        self.assertFalse((self.out / "cases" / "placed" / "scene.json").exists())
        self.assertGreater(next(float(row["dice"]) for row in self.summary() if row["name"] == "labels"), 0.9)

    def test_gpu_processes_sets_the_number_of_processes(self) -> None:
        self.write_table([row | {"name": f"{row['name']}{k}"} for row in self.rows for k in range(2)])
        # Replaces the device: counts the running processes, and computes on the CPU.
        at_work = self.folder / "at_work"
        at_work.mkdir()
        counted = self.wrapper(f"touch {at_work}/$$; ls {at_work} | wc -l >>{self.folder}/counts; sleep 0.3; rm {at_work}/$$\n"
                               'set -- "${@/cuda/cpu}"')
        done = self.cohort("--profile", "gpu", "--gpu-processes", "3", environment=dict(os.environ, SIMPLEXSEG_CLI=counted))
        self.assertEqual(done.returncode, 0, done.stderr)
        counts = [int(count) for count in (self.folder / "counts").read_text().split()]
        self.assertEqual((len(counts), max(counts)), (6, 3))
        self.assertIn("--backend cuda", (self.out / "logs" / "snakemake.log").read_text())

    def test_an_interrupted_call_continues(self) -> None:
        self.write_table(self.rows)
        calls = self.folder / "calls"
        slow = self.wrapper(f'echo "$2" >>{calls}\nif [[ $2 == *cube* && ! -e {calls}.killed ]]; then exec sleep 60; fi')
        environment = dict(os.environ, SIMPLEXSEG_CLI=slow)
        with subprocess.Popen(self.command("--cores", "1"), env=environment, start_new_session=True, stdout=subprocess.DEVNULL,
                              stderr=subprocess.DEVNULL) as running:
            until = time.monotonic() + 40
            cube_runs = re.compile(r"cube", re.M)
            while time.monotonic() < until and not (calls.exists() and cube_runs.search(calls.read_text())):
                time.sleep(0.05)
            before = calls.read_text().split()
            os.killpg(running.pid, signal.SIGKILL)
        self.assertTrue(before and "cube" in before[-1], before)
        Path(f"{calls}.killed").touch()
        calls.unlink()
        done = self.cohort(environment=environment)
        self.assertEqual(done.returncode, 0, done.stderr)
        finished = len(before) - 1  # cases before the killed one
        self.assertIn(f"{3 - finished} done, 0 failed, {finished} skipped", done.stdout)
        self.assertEqual(len(calls.read_text().split()), 3 - finished, "finished cases do not run again")
        self.assert_labels_of_the_bare_program()

    def test_a_killed_case_is_repeated(self) -> None:
        self.write_table(self.rows[:1])
        once = self.wrapper(f"if mkdir {self.folder}/killed 2>/dev/null; then kill -KILL $$; fi")
        done = self.cohort(environment=dict(os.environ, SIMPLEXSEG_CLI=once))
        self.assertEqual(done.returncode, 0, done.stderr)
        always = self.wrapper("kill -KILL $$")
        (self.out / "cases" / "sphere" / "status").unlink()
        done = self.cohort(environment=dict(os.environ, SIMPLEXSEG_CLI=always))
        self.assertEqual(done.returncode, 1)
        self.assertIn("sphere: killed: exit status 137", done.stderr)

    def test_bad_tables_are_refused_in_one_line_before_any_run(self) -> None:
        good = self.rows[0]

        def expect(rows: list[dict[str, str]], *words: str) -> None:
            self.write_table(rows)
            self.expect_refused(*words)

        expect([good, good | {"image": "cube.nii.gz"}], "row 3", "'name'", "twice")
        expect([good, good | {"name": "SPHERE"}], "row 3", "'name'", "twice")
        for name in ("../x", "a b", "", ".hidden", "a/b", "x" * 101):
            expect([good | {"name": name}], "row 2", "'name'")
        expect([good | {"image": "none.nii"}], "row 2", "'image'", "none.nii")
        expect([good | {"image": ""}], "row 2", "'image'")
        expect([good | {"x": "left"}], "row 2", "'x'", "'left'")
        expect([good | {"x": "nan"}], "row 2", "'x'")
        expect([good | {"y": ""}], "row 2", "'y'")
        expect([good | {"radius": "0"}], "row 2", "'radius'")
        expect([good | {"labels": "cube.nii.gz"}], "row 2", "'labels'", "seed")
        expect([{"name": "a", "image": "cube.nii.gz"}], "row 2", "position of the object is missing")
        expect([good | {"reference": "none.nii"}], "row 2", "'reference'")
        expect([good | {"reference": "", "reference_label": "1"}], "row 2", "'reference_label'")
        expect([good | {"volume": "1.5"}], "row 2", "'volume'")
        expect([good | {"seed": "1"}], "row 1", "'seed'", "no such column")
        expect([{"image": "cube.nii.gz"}], "row 1", "'name'")
        expect([], "empty")
        table = self.folder / "table.csv"
        table.write_text("name,image\n")
        self.expect_refused("no case")
        table.write_text("name,image\na,b,c\n")
        self.expect_refused("row 2", "3 cells")
        table.write_bytes(b"name,image\n\xff\xfe,b\n")
        self.expect_refused("UTF-8")
        table.unlink()
        self.expect_refused("No such file")
        self.write_table([good])
        for text, word in (("stepz: 3", "stepz"), ("steps: many", "'steps'"), ("[1]", "not a list of keys"), ("scene: x.json", "x.json"),
                           ("a: [", "YAML")):
            self.config.write_text(text)
            self.expect_refused(word)

    def expect_refused(self, *words: str) -> None:
        done = self.cohort()
        self.assertEqual(done.returncode, 2, words)
        self.assertEqual(len(done.stderr.splitlines()), 1, done.stderr)
        for word in words:
            self.assertIn(word, done.stderr)
        self.assertFalse(self.out.exists())


if __name__ == "__main__":
    fixture.main(("snakemake", "snakemake"))
