#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""slurm_test.py PROGRAM: tests of scripts/cohort on a private Slurm of this machine."""
from __future__ import annotations

import subprocess

import fixture
from fixture import CohortFixture
from local_slurm import CannotStart, LocalSlurm, missing_package


class SlurmTest(CohortFixture):
    def test_labels_are_equal_and_killed_jobs_are_repeated(self) -> None:
        self.break_a_volume()
        self.write_table(self.rows)
        once = self.wrapper(f"if [[ $* != *--plan* && $2 == *cube* ]] && mkdir {self.folder}/killed 2>/dev/null; then "
                            "kill -KILL $$; fi")
        try:
            with LocalSlurm(self.folder / "slurm", cpus=2) as slurm:
                done = self.cohort("--profile", "slurm", environment=slurm.environment | {"SIMPLEXSEG_CLI": once})
                jobs = subprocess.run(["scontrol", "--oneliner", "show", "job"], env=slurm.environment, capture_output=True,
                                      text=True, check=True).stdout
        except CannotStart as why:
            self.skipTest(f"Slurm cannot be started: {why}")
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertIn("3 done, 1 failed, 0 skipped", done.stdout)
        self.assertTrue((self.folder / "killed").exists())
        self.assertEqual(jobs.count("JobName=segment-cube"), 2, jobs)
        self.assertEqual(jobs.count("JobName=segment-"), 5, jobs)
        self.assertNotIn("MinMemoryNode=0", jobs)
        self.assert_labels_of_the_bare_program()


if __name__ == "__main__":
    if missing_package():
        fixture.skip(f"install {missing_package()}")
    fixture.main(("snakemake", "snakemake"))
