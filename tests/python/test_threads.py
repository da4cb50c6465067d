# SPDX-License-Identifier: Apache-2.0
import os
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import simplexseg
from simplexseg import Error, Session


class Ticks:
    """Counter in a separate thread that needs the GIL every two milliseconds."""

    def __enter__(self):
        self.count, self.over, self.start = 0, False, time.perf_counter()
        self.thread = threading.Thread(target=self.run)
        self.thread.start()
        return self

    def run(self):
        while not self.over:
            time.sleep(0.002)
            self.count += 1

    def __exit__(self, *_):
        self.seconds = time.perf_counter() - self.start
        self.over = True
        self.thread.join()

    def per_second(self):
        return self.count / self.seconds


@pytest.fixture(scope="module")
def large(tmp_path_factory):
    """File of a phantom that takes tenths of a second to read, and its labels."""
    image, labels = simplexseg.make_phantom("tube", size=160, noise=20)
    path = tmp_path_factory.mktemp("large") / "v.nii.gz"
    simplexseg.write_volume(path, image)
    return path, labels


def test_other_threads_run_during_a_run(session):
    session.set("simulation.final_vertices", 20480)
    with Ticks() as ticks:
        while time.perf_counter() - ticks.start < 0.5:
            session.run(200)
    assert ticks.per_second() > 60  # if run() held the GIL, there would be one tick per call


@pytest.mark.parametrize("work", ["read", "compare", "mesh", "phantom", "picture"])
def test_other_threads_run_during(large, tmp_path, work):
    path, labels = large
    works = {
        "read": lambda: simplexseg.read_volume(path),
        "compare": lambda: simplexseg.compare(labels, labels),
        "mesh": lambda: simplexseg.mesh_from_labels(labels),
        "phantom": lambda: simplexseg.make_phantom("tube", size=160, noise=20),
        "picture": lambda: simplexseg.write_volume(tmp_path / "v.nii.gz", labels),
    }
    with Ticks() as ticks:
        while time.perf_counter() - ticks.start < 0.3:
            works[work]()
    assert ticks.per_second() > 60


def test_parallel_sessions_have_the_results_of_serial_ones(phantom):
    def run(radius, results):
        with Session(phantom[0], backend="cpu", threads=1) as session:
            mesh = session.add_mesh(centre=(1, 2, 0), radius=radius)
            for _ in range(10):
                session.run(20)
            results[radius] = mesh.mesh.vertices

    alone, beside = {}, {}
    for radius in (5, 8):
        run(radius, alone)
    threads = [threading.Thread(target=run, args=(radius, beside)) for radius in (5, 8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for radius in (5, 8):
        np.testing.assert_array_equal(alone[radius], beside[radius])


def test_a_session_in_use_by_another_thread_raises_error(session):
    session.set("simulation.final_vertices", 20480)
    stop = threading.Event()

    def work():
        while not stop.is_set():
            try:
                session.run(500)
            except Error:
                pass

    thread = threading.Thread(target=work)
    thread.start()
    mesh, refused, succeeded = None, 0, 0
    end = time.perf_counter() + 0.5
    while time.perf_counter() < end:
        for call in [lambda: session.meshes, session.labels, session.undo, lambda: session.run(1), session.redo]:
            try:
                call()
                succeeded += 1
            except Error as error:
                assert "another call is using it" in str(error)
                refused += 1
    stop.set()
    thread.join()
    assert refused > 0
    assert session.run(10).steps == 10


def interrupt_after(seconds):
    timer = threading.Timer(seconds, lambda: os.kill(os.getpid(), signal.SIGINT))
    timer.start()
    return timer


def test_ctrl_c_ends_a_run_and_the_session_continues(session):
    session.set("simulation.final_vertices", 5120)
    timer = interrupt_after(0.2)
    start = time.perf_counter()
    with pytest.raises(KeyboardInterrupt):
        session.run(10**9)
    assert time.perf_counter() - start < 5
    timer.join()
    done = session.steps
    assert done > 0
    assert session.run(10).steps == 10 and session.steps == done + 10


def test_ctrl_c_ends_a_reading(large):
    path, _ = large
    timer = interrupt_after(0.2)
    with pytest.raises(KeyboardInterrupt):
        while True:
            simplexseg.read_volume(path)
    timer.join()
    assert simplexseg.read_volume(path).shape == (160, 160, 160)


def test_a_signal_handler_that_uses_the_session_raises_error_without_deadlock(session):
    results = []

    def handler(*_):
        try:
            results.append(session.steps)
        except Error as error:
            results.append(str(error))
            raise

    before = signal.signal(signal.SIGINT, handler)
    try:
        timer = interrupt_after(0.2)
        with pytest.raises(Error, match="another call is using it"):
            session.set("simulation.final_vertices", 5120)
            session.run(10**9)
        timer.join()
    finally:
        signal.signal(signal.SIGINT, before)
    assert len(results) == 1
    assert session.run(1).steps == 1


ENDS = {
    "a daemon thread runs": "threading.Thread(target=lambda: [session.run(300) for _ in range(10**6)], daemon=True).start()",
    "a field is solved": "session.mesh('ball').add_point((5, 0, 0), 'inside'); session.run_for(0.01)",
    "arrays are left": "vertices, voxels = session.mesh('ball').mesh.vertices, session.volume.array",
}


@pytest.mark.parametrize("last", ENDS.values(), ids=ENDS.keys())
def test_the_interpreter_ends_cleanly_while(last):
    code = f"""
import threading, time, simplexseg
session = simplexseg.Session(simplexseg.make_phantom("sphere", size=24, spacing=2)[0], backend="cpu")
session.add_mesh("ball", centre=(1, 0, 0), radius=9)
{last}
end = time.perf_counter() + 0.2
while time.perf_counter() < end:
    pass
"""
    for _ in range(2):
        done = subprocess.run([sys.executable, "-W", "ignore", "-c", code], capture_output=True, text=True, check=False)
        assert (done.returncode, done.stderr) == (0, "")


def test_unclosed_sessions_are_released(phantom):
    for _ in range(5):
        mesh = Session(phantom[0], backend="cpu").add_mesh(centre=(0, 0, 0), radius=5)
        assert len(mesh.mesh) > 0
