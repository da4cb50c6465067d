#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""faults_test.py PROGRAM: whatever an archive does, it is told in one line, and nothing half-fetched is used or left."""
from __future__ import annotations

import signal
import socket
import subprocess
import time
from pathlib import Path

import fakes
import fixture
from fakes import SERIES, STUDY, Answer, Handler, Proxy, Server
from fixture import ArchiveFixture

JSON = "application/dicom+json"
MOST_OF_AN_ANSWER = 40_000_000


class WebFaults(ArchiveFixture):
    """Those of a server that speaks HTTP."""

    def setUp(self) -> None:
        super().setUp()
        fixture.make_series(self.folder / "ball", 3)
        self.bodies = [(self.folder / "ball" / f"{k}.dcm").read_bytes() for k in range(3)]
        self.uids = [f"1.2.826.0.1.3680043.9.7.1.{k + 1}" for k in range(3)]

    def serve(self, rules: dict[str, Answer]) -> Server:
        server = Server(rules)
        self.addCleanup(server.stop)
        return server

    def fetch(self, series: Answer, uids: list[str] | None = None, status: int = 1, *options: str, before: str = "") -> str:
        """Fetches from a server that gives the series so; what the program says."""
        server = self.serve({"/instances": fakes.listing(uids or self.uids), "/series/": series})
        done = self.call("archive", "get", STUDY, SERIES, "--server", server.address, *options, status=status, before=before)
        if status:
            self.assert_clean()
        return done.stderr

    def find(self, answer: Answer, *options: str) -> str:
        """Searches a server that answers so."""
        server = self.serve({"/studies": answer})
        told = self.call("archive", "find", "--patient-name", "Secretperson", "--server", server.address, *options, status=1).stderr
        self.assertNotIn("Secretperson", told)
        return told

    def test_a_series_that_is_whole_is_taken(self) -> None:
        """What the others are held against."""
        self.fetch(fakes.parts(self.bodies), status=0)
        self.assertEqual(len([path for path in self.cached() if path.suffix == ".dcm"]), 3)

    def test_half_a_series(self) -> None:
        self.assertIn("half a series: 2 of 3", self.fetch(fakes.parts(self.bodies[:2])))

    def test_parts_that_are_cut(self) -> None:
        whole = sum(map(len, self.bodies))
        self.assertIn("cut short", self.fetch(fakes.parts(self.bodies, cut=whole - 1000)))  # no last delimiter
        self.assertIn("damaged", self.fetch(fakes.parts([*self.bodies[:2], self.bodies[2][:-900]])))  # the file itself
        self.assertIn("cut short", self.fetch(fakes.parts(self.bodies, length=len(self.bodies[0]) + 10)))
        self.assertIn("ended in the middle", self.fetch(
            lambda handler: handler.give(b"--frontier\r\n", "multipart/related; boundary=frontier", claim=100000)))

    def test_instances_that_were_not_asked_for(self) -> None:
        self.assertIn("not of the series", self.fetch(fakes.parts(self.bodies), uids=self.uids[:2]))
        self.assertIn("twice", self.fetch(fakes.parts([self.bodies[0], self.bodies[0]])))
        self.assertIn("damaged", self.fetch(fakes.parts([b"no DICOM at all " * 100])))
        renamed = self.bodies[0].replace(self.uids[0].encode(), b"../../../../../../../tmp/xyz"[:27])
        self.assertIn("not of the series", self.fetch(fakes.parts([renamed])))

    def test_what_is_no_series(self) -> None:
        self.assertIn("rather than the parts", self.fetch(lambda handler: handler.give(b"<html>", "text/html")))
        self.assertIn("is empty", self.fetch(lambda handler: handler.give(b"", "multipart/related; boundary=frontier")))
        self.assertIn("is damaged", self.fetch(lambda handler: handler.give(
            b"--frontier\r\n" + b"X: y\r\n" * 20000, "multipart/related; boundary=frontier")))
        self.assertIn("has no such series", self.fetch(lambda handler: handler.send_error(404)))

    def test_endless_parts_are_cut_off(self) -> None:
        kind = 'multipart/related; boundary=frontier'
        told = self.fetch(fakes.endless(kind, 200 << 20), None, 1, "--cache-limit", "0.01")
        self.assertIn("larger than 10.0 MB", told)

    def test_a_full_disk(self) -> None:
        told = self.fetch(fakes.parts(self.bodies), before="ulimit -f 2")  # 2 KiB a file
        self.assertIn("check the space left", told)
        self.assertIn("cannot keep what comes", told)

    def test_statuses(self) -> None:
        for status, words in {401: "wants credentials (401)", 403: "forbids", 404: "check its URL", 500: "it failed (500)",
                              302: "sends elsewhere (302)"}.items():
            with self.subTest(status):
                self.assertIn(words, self.find(lambda handler, status=status: handler.give(b"Secretperson", "text/plain", status)))

    def test_two_gigabytes_for_a_small_question(self) -> None:
        server = self.serve({"/studies": fakes.endless(JSON, 2 << 30)})
        told = self.call("archive", "find", "--server", server.address, status=1, timeout=60).stderr
        self.assertIn("larger than 32.0 MB and was cut off", told)
        self.assertLess(server.handler.sent, MOST_OF_AN_ANSWER)
        self.assertIn("larger than", self.find(lambda handler: handler.give(b"[", JSON, claim=2 << 30)))

    def test_answers_that_are_garbage(self) -> None:
        for body in (b"<html>", b"{}", b"[1, 2", b"\xff\xfe", b"[" * 5_000_000, b'[{"0020000D": {"Value": ["1.2'):
            with self.subTest(body[:20]):
                self.assertIn("not the JSON of DICOMweb", self.find(lambda handler, body=body: handler.give(body)))

    def test_entries_that_are_odd_are_left_out(self) -> None:
        odd = b'[1, null, [], {"0020000D": 3}, {"0020000D": {"Value": []}}, {"0020000D": {"Value": [{}]}}, ' \
              b'{"0020000D": {"Value": ["../../etc"]}}, {"0020000D": {"Value": ["1.2.3"]}, "00100010": {"Value": [7]}, ' \
              b'"00080061": {"Value": "CT"}, "00201206": {"Value": [-4]}, "00201208": {"Value": ["many"]}}]'
        server = self.serve({"/studies": lambda handler: handler.give(odd)})
        found = self.json("find", "--server", server.address)["studies"]
        self.assertEqual([(one["study"], one["series"], one["instances"], one["modalities"]) for one in found],
                         [("1.2.3", None, None, [])])

    def test_time_out(self) -> None:
        start = time.monotonic()
        self.assertIn("time-out: nothing came for 1 s", self.find(fakes.silent(30), "--timeout", "1"))
        self.assertLess(time.monotonic() - start, 20)
        self.assertIn("time-out", self.fetch(fakes.silent(30), None, 1, "--timeout", "1"))

    def test_called_off(self) -> None:
        """By Ctrl+C, while an answer is waited for, in whichever protocol."""
        port = fakes.Port()
        self.addCleanup(port.stop)
        server = self.serve({"/instances": fakes.listing(self.uids), "/series/": fakes.silent(20)})
        for address in (server.address, port.address):
            with subprocess.Popen([fixture.program(), "archive", "get", STUDY, SERIES, "--server", address], env=self.environment,
                                  stderr=subprocess.PIPE, text=True) as program:
                time.sleep(1.5)
                self.assertIsNone(program.poll())
                program.send_signal(signal.SIGINT)
                self.assertEqual(program.wait(15), 1)
                self.assertIn("interrupted", program.stderr.read())
            self.assert_clean()

    def test_answers_to_what_is_sent(self) -> None:
        file = str(self.folder / "ball" / "0.dcm")

        def refuse(handler: Handler) -> None:
            handler.rfile.read(int(handler.headers["Content-Length"]))
            handler.give(b'{"00081198": {"vr": "SQ", "Value": [{"00081197": {"vr": "US", "Value": [42752]}}]}}', JSON, 409)
        server = self.serve({"/studies": refuse})
        told = self.call("archive", "send", file, "--server", server.address, status=1).stderr
        self.assertIn("refuses '0.dcm' (A700)", told)
        told = self.call("archive", "send", file, file, "--server", server.address, status=1).stderr
        self.assertIn("of 2 instances it had taken 0", told)
        (self.folder / "no.dcm").write_text("no DICOM")
        told = self.call("archive", "send", file, "no.dcm", "--server", server.address, status=2).stderr
        self.assertIn("it is no DICOM file", told)


class KilledServers(ArchiveFixture):
    """Orthanc is killed in the middle."""

    def address(self, protocol: str, port: int) -> str:
        return f"http://{fixture.LOCAL}:{port}/dicom-web" if protocol == "web" else f"ORTHANC@{fixture.LOCAL}:{port}"

    def killed(self, protocol: str, upwards: bool, after: int, full: bool) -> tuple[fixture.Orthanc, str]:
        """An Orthanc that dies when so many bytes have gone, and its address. `full`: it keeps the series."""
        server = self.orthanc()
        if full:
            self.call("archive", "send", *self.files(), "--server", server.web)
        proxy = Proxy(server.web_port if protocol == "web" else server.dicom_port, after, upwards, server.kill)
        self.addCleanup(proxy.stop)
        return server, self.address(protocol, proxy.port)

    def test_while_fetching(self) -> None:
        import pydicom

        first = pydicom.dcmread(self.files()[0], stop_before_pixels=True)
        size = sum(Path(file).stat().st_size for file in self.files())
        for protocol in ("web", "classic"):
            with self.subTest(protocol):
                _, address = self.killed(protocol, False, size // 2, True)
                told = self.call("archive", "get", str(first.StudyInstanceUID), str(first.SeriesInstanceUID), "--server", address,
                                 status=1).stderr
                self.assertRegex(told, "the connection ended|cut short")
                self.assert_clean()

    def test_while_sending(self) -> None:
        size = sum(Path(file).stat().st_size for file in self.files())
        for protocol in ("web", "classic"):
            with self.subTest(protocol):
                _, address = self.killed(protocol, True, size // 2, False)
                told = self.call("archive", "send", *self.files(), "--server", address, status=1).stderr
                self.assertRegex(told, r"of \d+ instances it had taken [1-9]")

    def test_a_full_disk(self) -> None:
        import pydicom

        server = self.orthanc()
        self.call("archive", "send", *self.files(), "--server", server.dicom)
        first = pydicom.dcmread(self.files()[0], stop_before_pixels=True)
        told = self.call("archive", "get", str(first.StudyInstanceUID), str(first.SeriesInstanceUID), "--server", server.dicom,
                         before="ulimit -f 3", status=1).stderr
        self.assertIn("check the space left", told)
        self.assert_clean()


class ClassicFaults(ArchiveFixture):
    """Those of a port that is to speak as DICOM does."""

    def find(self, talk: object, *options: str) -> str:
        port = fakes.Port(talk) if talk else fakes.Port()  # type: ignore[arg-type]
        self.addCleanup(port.stop)
        return self.call("archive", "find", "--server", port.address, *options, status=1, timeout=60).stderr

    def test_time_out(self) -> None:
        start = time.monotonic()
        self.assertIn("time-out: nothing came for 1 s", self.find(None, "--timeout", "1"))
        self.assertLess(time.monotonic() - start, 20)

    def test_it_hangs_up(self) -> None:
        def hang_up(connection: socket.socket) -> None:
            connection.recv(100)
        self.assertIn("the connection ended", self.find(hang_up))

    def test_garbage(self) -> None:
        def rubbish(connection: socket.socket) -> None:
            connection.recv(100)
            connection.sendall(b"HTTP/1.1 400 Bad Request\r\n\r\n" * 200)
        told = self.find(rubbish, "--timeout", "2")
        self.assertRegex(told, "the connection ended|not that of an archive|time-out")

    def test_endless_answers_are_cut_off(self) -> None:
        def flood(connection: socket.socket) -> None:
            connection.recv(100)
            connection.sendall(b"\x02\x00\xff\xff\xff\xf0")  # an A-ASSOCIATE-AC of 4 GB
            for _ in range(2000):
                connection.sendall(b"\0" * (1 << 20))
        told = self.find(flood, "--timeout", "2")
        self.assertRegex(told, "larger than|the connection ended|not that of an archive|time-out")


if __name__ == "__main__":
    fixture.main((fixture.ORTHANC, "orthanc"), (fixture.DICOM_WEB, "orthanc-dicomweb"), ("pydicom", "python3-pydicom"))
