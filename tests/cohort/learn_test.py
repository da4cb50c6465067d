#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""learn_test.py PROGRAM: models of organs in cohorts, and models that learn from accepted cases."""
from __future__ import annotations

import csv
import json
import os
import shutil
import signal
import subprocess
import time
from typing import Any

import fixture
from fixture import CohortFixture

SEED = {"x": "0", "y": "0", "z": "0", "radius": "9"}


class LearnTest(CohortFixture):
    def setUp(self) -> None:
        super().setUp()
        self.model = self.folder / "ball.model"
        self.config.write_text("settings: [simulation.final_vertices=320]\n")
        self.rows = []
        for number in "123":
            self.call("phantom", "sphere", f"image{number}.nii.gz", "--labels", f"truth{number}.nii.gz", "--size", "32",
                      "--noise", "40", "--contrast", "60", "--seed", number)
            self.rows.append({"name": f"case{number}", "image": f"image{number}.nii.gz", **SEED,
                              "reference": f"truth{number}.nii.gz"})

    def run_cohort(self, *arguments: str, status: int = 0) -> subprocess.CompletedProcess[str]:
        self.write_table(self.rows)
        done = self.cohort(*arguments)
        self.assertEqual(done.returncode, status, done.stderr)
        return done

    def log(self) -> list[dict[str, Any]]:
        return [json.loads(line) for line in (self.out / "learn.jsonl").read_text().splitlines()]

    def summary(self) -> dict[str, dict[str, str]]:
        with open(self.out / "summary.csv", newline="", encoding="utf-8") as file:
            return {row["name"]: row for row in csv.DictReader(file)}

    def labels(self, name: str) -> bytes:
        return (self.out / "cases" / name / "labels.nii.gz").read_bytes()

    def bare_labels(self, number: str, *arguments: str) -> bytes:
        self.call("segment", f"image{number}.nii.gz", "bare.nii.gz", "--seed", "0,0,0", "--radius", "9",
                  "--set", "simulation.final_vertices=320", "--backend", "cpu", *arguments)
        return (self.folder / "bare.nii.gz").read_bytes()

    def results(self) -> dict[str, bytes]:
        """Returns everything that a repeated run must repeat: the log, the models and the labels."""
        files = [self.out / "learn.jsonl", self.model, *sorted(self.out.glob("learn/*.model")),
                 *sorted(self.out.glob("cases/*/labels.nii.gz"))]
        return {str(file.relative_to(self.out)) if file != self.model else "model": file.read_bytes() for file in files}

    def assert_repeated(self, results: dict[str, bytes]) -> None:
        again = self.results()
        self.assertEqual(sorted(again), sorted(results))
        self.assertEqual([name for name, content in results.items() if again[name] != content], [])

    def test_each_accepted_case_teaches_the_following_ones_and_a_run_can_be_repeated(self) -> None:
        done = self.run_cohort("--learn", str(self.model))
        self.assertIn("3 done, 0 failed, 0 skipped", done.stdout)
        log = self.log()
        self.assertEqual([(event["event"], event.get("case")) for event in log],
                         [("start", None), ("segment", "case1"), ("learn", "case1"), ("segment", "case2"), ("learn", "case2"),
                          ("segment", "case3"), ("learn", "case3")])
        self.assertEqual([log[k]["model"] for k in (1, 3, 5)], ["", log[2]["model"], log[4]["model"]])
        self.assertEqual(len({log[k]["model"] for k in (2, 4, 6)}), 3)
        self.assertTrue(all(log[k]["image"].startswith("crc32-") and log[k]["labels"].startswith("crc32-") for k in (2, 4, 6)))
        # The first case has no model; the following ones have that of the cases before them. That of one case is silent.
        self.assertTrue(self.labels("case1") == self.bare_labels("1"))
        for number in "23":
            model = self.out / "learn" / f"000{int(number) - 1}.model"
            self.assertTrue(self.labels(f"case{number}") == self.bare_labels(number, "--model", str(model)), number)
        self.assertTrue(self.labels("case3") != self.bare_labels("3"), "the model has no effect")
        summary = self.summary()
        self.assertEqual([summary[f"case{k}"]["model"] for k in "123"], ["", log[2]["model"], log[4]["model"]])
        shown = self.call("model", "show", str(self.model))
        self.assertIn("cases      3\n", shown)
        self.assertIn(log[6]["model"], shown)
        self.assertEqual(self.model.read_bytes(), (self.out / "learn" / "0003.model").read_bytes())
        # A repeated call has nothing to do; a call with another folder repeats every bit.
        results = self.results()
        self.assertIn("0 done, 0 failed, 3 skipped", self.run_cohort("--learn", str(self.model)).stdout)
        self.assert_repeated(results)
        self.out = self.folder / "out2"
        self.run_cohort("--learn", str(self.model))
        self.assert_repeated(results)

    def test_a_killed_run_continues_to_the_same_bits(self) -> None:
        self.run_cohort("--learn", str(self.model))
        results = self.results()
        for moment, skipped in (('$2 == train && $* == *0002.model*', 2), ('$1 == segment && $* == *image2.nii.gz*', 1)):
            shutil.rmtree(self.out)
            reached = self.folder / "reached"
            reached.unlink(missing_ok=True)
            slow = self.wrapper(f'if [[ {moment} && ! -e {reached} ]]; then touch {reached}; exec sleep 60; fi')
            environment = dict(os.environ, SIMPLEXSEG_CLI=slow)
            with subprocess.Popen(self.command("--learn", str(self.model)), env=environment, start_new_session=True,
                                  stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as running:
                until = time.monotonic() + 40
                while time.monotonic() < until and not reached.exists():
                    time.sleep(0.05)
                os.killpg(running.pid, signal.SIGKILL)
            self.assertTrue(reached.exists(), moment)
            with open(self.out / "learn.jsonl", "a", encoding="utf-8") as log:
                log.write('{"event": "le')  # cut off
            done = self.cohort("--learn", str(self.model), environment=environment)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn(f"{3 - skipped} done, 0 failed, {skipped} skipped", done.stdout)
            self.assert_repeated(results)

    def test_a_locked_segmentation_is_accepted_in_the_next_call(self) -> None:
        for row in self.rows:
            del row["reference"]
        self.run_cohort("--learn", str(self.model))
        self.assertEqual([event["event"] for event in self.log()], ["start", "segment", "segment", "segment"])
        self.assertFalse(self.model.exists())
        scene = self.out / "cases" / "case2" / "scene.json"
        locked = json.loads(scene.read_text())
        locked["meshes"][0]["locked"] = True
        scene.write_text(json.dumps(locked))
        self.rows.append(self.rows[0] | {"name": "case4", "image": "image3.nii.gz"})
        done = self.run_cohort("--learn", str(self.model))
        self.assertIn("1 done, 0 failed, 3 skipped", done.stdout)
        log = self.log()
        self.assertEqual([(event["event"], event["case"]) for event in log[4:]], [("learn", "case2"), ("segment", "case4")])
        self.assertEqual(log[5]["model"], log[4]["model"])
        self.assertIn("cases      1\n", self.call("model", "show", str(self.model)))
        self.assertEqual((self.out / "learn" / "case2.nii.gz").read_bytes(), self.labels("case2"))

    def test_a_model_of_the_option_or_the_row(self) -> None:
        with open(self.folder / "train.csv", "w", encoding="utf-8") as file:
            file.write("image,labels\nimage1.nii.gz,truth1.nii.gz\nimage2.nii.gz,truth2.nii.gz\n")
        for name in ("a.model", "b.model"):
            self.call("model", "train", "train.csv", name, "--modes", "10" if name == "a.model" else "12")
        self.rows[1]["model"] = "b.model"
        self.run_cohort("--model", str(self.folder / "a.model"))
        self.assertEqual(self.labels("case1"), self.bare_labels("1", "--model", "a.model"))
        self.assertEqual(self.labels("case2"), self.bare_labels("2", "--model", "b.model"))
        summary = self.summary()
        self.assertEqual(summary["case1"]["model"], summary["case3"]["model"])
        self.assertNotEqual(summary["case1"]["model"], summary["case2"]["model"])
        # A model to begin with.
        del self.rows[1]["model"]
        self.out = self.folder / "learning"
        self.run_cohort("--model", str(self.folder / "a.model"), "--learn", str(self.model))
        self.assertEqual(self.log()[1]["model"], summary["case1"]["model"])
        self.assertIn("cases      5\n", self.call("model", "show", str(self.model)))

    def test_what_cannot_be_learned_is_refused_or_reported(self) -> None:
        def expect_refused(rows: list[dict[str, str]], words: tuple[str, ...], *arguments: str) -> None:
            self.write_table(rows)
            done = self.cohort(*arguments)
            self.assertEqual(done.returncode, 2, words)
            self.assertEqual(len(done.stderr.splitlines()), 1, done.stderr)
            for word in words:
                self.assertIn(word, done.stderr)

        learn = ("--learn", str(self.model))
        row = self.rows[0]
        (self.folder / "no.model").write_text("no model")
        expect_refused([row | {"model": "no.model"}], ("row 2", "'model'", "--learn"), *learn)
        expect_refused([row | {"model": "none.model"}], ("row 2", "'model'", "none.model"))
        expect_refused([row | {"volume": "1"}], ("row 2", "'volume'", "--learn"), *learn)
        start = {"name": "a", "image": "image1.nii.gz", "labels": "truth1.nii.gz"}
        expect_refused([start], ("row 2", "'labels'", "model"), *learn)
        expect_refused([start], ("row 2", "'labels'", "model"), "--model", str(self.folder / "no.model"))
        expect_refused([row], ("no.model",), "--model", str(self.folder / "no.model"))
        # A reference without the object: the case is segmented, but not learned.
        self.rows = [row | {"reference_label": "1"}, self.rows[1]]
        self.call("phantom", "sphere", "x.nii.gz", "--labels", "empty.nii.gz", "--size", "32")
        self.rows[0]["reference"] = "image1.nii.gz"
        self.rows[0]["reference_label"] = "30000"
        done = self.run_cohort(*learn, status=1)
        self.assertRegex(done.stderr, r"(?m)^case1: (not learned: )?.*30000")
        self.assertEqual([event["case"] for event in self.log() if event["event"] == "learn"], ["case2"])
        # The model of the log must still exist.
        (self.out / "learn" / "0001.model").unlink()
        expect_refused(self.rows, ("0001.model", "another folder"), *learn)


if __name__ == "__main__":
    fixture.main(("snakemake", "snakemake"))
