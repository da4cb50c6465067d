#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""faults_test.py PROGRAM: every fault of an archive gives a message of one line, and no incomplete series remains."""
from __future__ import annotations

import signal
import socket
import subprocess
import time
from pathlib import Path

import fakes
import fixture
from fakes import SERIES, STUDY, Response, Handler, Proxy, Server
from fixture import ArchiveFixture

JSON = "application/dicom+json"
MOST_OF_A_RESPONSE = 40_000_000


class WebFaults(ArchiveFixture):
    """Faults of an HTTP server."""

    def setUp(self) -> None:
        super().setUp()
        fixture.make_series(self.folder / "ball", 3)
        self.bodies = [(self.folder / "ball" / f"{k}.dcm").read_bytes() for k in range(3)]
        self.uids = [f"1.2.826.0.1.3680043.9.7.1.{k + 1}" for k in range(3)]

    def serve(self, rules: dict[str, Response]) -> Server:
        server = Server(rules)
        self.addCleanup(server.stop)
        return server

    def fetch(self, series: Response, uids: list[str] | None = None, status: int = 1, *options: str, before: str = "") -> str:
        """Fetches from a server with this series; returns the messages of the program."""
        server = self.serve({"/instances": fakes.listing(uids or self.uids), "/series/": series})
        done = self.call("archive", "get", STUDY, SERIES, "--server", server.address, *options, status=status, before=before)
        if status:
            self.assert_clean()
        return done.stderr

    def find(self, response: Response, *options: str) -> str:
        """Searches a server with this response; returns the messages of the program."""
        server = self.serve({"/studies": response})
        message = self.call("archive", "find", "--patient-name", "Secretperson", "--server", server.address, *options, status=1).stderr
        self.assertNotIn("Secretperson", message)
        return message

    def test_complete_series(self) -> None:
        """Control without a fault."""
        self.fetch(fakes.parts(self.bodies), status=0)
        self.assertEqual(len([path for path in self.cached() if path.suffix == ".dcm"]), 3)

    def test_incomplete_series(self) -> None:
        self.assertIn("incomplete series: 2 of 3", self.fetch(fakes.parts(self.bodies[:2])))

    def test_truncated_parts(self) -> None:
        whole = sum(map(len, self.bodies))
        self.assertIn("is incomplete", self.fetch(fakes.parts(self.bodies, cut=whole - 1000)))  # no last delimiter
        self.assertIn("damaged", self.fetch(fakes.parts([*self.bodies[:2], self.bodies[2][:-900]])))  # the file itself
        self.assertIn("is incomplete", self.fetch(fakes.parts(self.bodies, length=len(self.bodies[0]) + 10)))
        self.assertIn("ended in the middle", self.fetch(
            lambda handler: handler.reply(b"--frontier\r\n", "multipart/related; boundary=frontier", claim=100000)))

    def test_unexpected_instances(self) -> None:
        self.assertIn("does not belong to the series", self.fetch(fakes.parts(self.bodies), uids=self.uids[:2]))
        self.assertIn("twice", self.fetch(fakes.parts([self.bodies[0], self.bodies[0]])))
        self.assertIn("damaged", self.fetch(fakes.parts([b"no DICOM at all " * 100])))
        renamed = self.bodies[0].replace(self.uids[0].encode(), b"../../../../../../../tmp/xyz"[:27])
        self.assertIn("does not belong to the series", self.fetch(fakes.parts([renamed])))

    def test_responses_without_a_series(self) -> None:
        self.assertIn("instead of a series", self.fetch(lambda handler: handler.reply(b"<html>", "text/html")))
        self.assertIn("is empty", self.fetch(lambda handler: handler.reply(b"", "multipart/related; boundary=frontier")))
        self.assertIn("is damaged", self.fetch(lambda handler: handler.reply(
            b"--frontier\r\n" + b"X: y\r\n" * 20000, "multipart/related; boundary=frontier")))
        self.assertIn("has no such series", self.fetch(lambda handler: handler.send_error(404)))

    def test_endless_parts_are_cancelled(self) -> None:
        kind = 'multipart/related; boundary=frontier'
        message = self.fetch(fakes.endless(kind, 200 << 20), None, 1, "--cache-limit", "0.01")
        self.assertIn("larger than 10.0 MB", message)

    def test_a_full_disk(self) -> None:
        message = self.fetch(fakes.parts(self.bodies), before="ulimit -f 2")  # 2 KiB per file
        self.assertIn("File too large", message)
        self.assertIn("cannot store received files", message)

    def test_statuses(self) -> None:
        for status, words in {401: "requires credentials (401)", 403: "denies access", 404: "check its URL", 500: "it failed (500)",
                              302: "redirects to another URL (302)"}.items():
            with self.subTest(status):
                self.assertIn(words, self.find(lambda handler, status=status: handler.reply(b"Secretperson", "text/plain", status)))

    def test_two_gigabytes_for_a_small_query(self) -> None:
        server = self.serve({"/studies": fakes.endless(JSON, 2 << 30)})
        message = self.call("archive", "find", "--server", server.address, status=1, timeout=60).stderr
        self.assertIn("larger than 32.0 MB and was cancelled", message)
        self.assertLess(server.handler.sent, MOST_OF_A_RESPONSE)
        self.assertIn("larger than", self.find(lambda handler: handler.reply(b"[", JSON, claim=2 << 30)))

    def test_invalid_json(self) -> None:
        for body in (b"<html>", b"{}", b"[1, 2", b"\xff\xfe", b"[" * 5_000_000, b'[{"0020000D": {"Value": ["1.2'):
            with self.subTest(body[:20]):
                self.assertIn("not DICOM JSON", self.find(lambda handler, body=body: handler.reply(body)))

    def test_invalid_entries_are_skipped(self) -> None:
        odd = b'[1, null, [], {"0020000D": 3}, {"0020000D": {"Value": []}}, {"0020000D": {"Value": [{}]}}, ' \
              b'{"0020000D": {"Value": ["../../etc"]}}, {"0020000D": {"Value": ["1.2.3"]}, "00100010": {"Value": [7]}, ' \
              b'"00080061": {"Value": "CT"}, "00201206": {"Value": [-4]}, "00201208": {"Value": ["many"]}}]'
        server = self.serve({"/studies": lambda handler: handler.reply(odd)})
        found = self.json("find", "--server", server.address)["studies"]
        self.assertEqual([(one["study"], one["series"], one["instances"], one["modalities"]) for one in found],
                         [("1.2.3", None, None, [])])

    def test_time_out(self) -> None:
        start = time.monotonic()
        self.assertIn("time-out: no data for 1 s", self.find(fakes.silent(30), "--timeout", "1"))
        self.assertLess(time.monotonic() - start, 20)
        self.assertIn("time-out", self.fetch(fakes.silent(30), None, 1, "--timeout", "1"))

    def test_cancel(self) -> None:
        """Ctrl+C while a response is awaited, with both protocols."""
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

    def test_rejected_instances(self) -> None:
        file = str(self.folder / "ball" / "0.dcm")

        def reject(handler: Handler) -> None:
            handler.rfile.read(int(handler.headers["Content-Length"]))
            handler.reply(b'{"00081198": {"vr": "SQ", "Value": [{"00081197": {"vr": "US", "Value": [42752]}}]}}', JSON, 409)
        server = self.serve({"/studies": reject})
        message = self.call("archive", "send", file, "--server", server.address, status=1).stderr
        self.assertIn("rejected '0.dcm' (A700)", message)
        message = self.call("archive", "send", file, file, "--server", server.address, status=1).stderr
        self.assertIn("0 of 2 instances were stored", message)
        (self.folder / "no.dcm").write_text("no DICOM")
        message = self.call("archive", "send", file, "no.dcm", "--server", server.address, status=2).stderr
        self.assertIn("it is not a DICOM file", message)


class KilledServers(ArchiveFixture):
    """Orthanc is killed during a transfer."""

    def address(self, protocol: str, port: int) -> str:
        return f"http://{fixture.LOCAL}:{port}/dicom-web" if protocol == "web" else f"ORTHANC@{fixture.LOCAL}:{port}"

    def killed(self, protocol: str, upwards: bool, after: int, full: bool) -> tuple[fixture.Orthanc, str]:
        """Orthanc that is killed after `after` bytes, and its address. `full`: it stores the series."""
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
                message = self.call("archive", "get", str(first.StudyInstanceUID), str(first.SeriesInstanceUID), "--server", address,
                                 status=1).stderr
                self.assertRegex(message, "the connection ended|is incomplete")
                self.assert_clean()

    def test_while_sending(self) -> None:
        size = sum(Path(file).stat().st_size for file in self.files())
        for protocol in ("web", "classic"):
            with self.subTest(protocol):
                _, address = self.killed(protocol, True, size // 2, False)
                message = self.call("archive", "send", *self.files(), "--server", address, status=1).stderr
                self.assertRegex(message, r"[1-9]\d* of \d+ instances were stored")

    def test_a_full_disk(self) -> None:
        import pydicom

        server = self.orthanc()
        self.call("archive", "send", *self.files(), "--server", server.dicom)
        first = pydicom.dcmread(self.files()[0], stop_before_pixels=True)
        message = self.call("archive", "get", str(first.StudyInstanceUID), str(first.SeriesInstanceUID), "--server", server.dicom,
                         before="ulimit -f 3", status=1).stderr
        self.assertIn("free space on the disk", message)
        self.assert_clean()


class ClassicFaults(ArchiveFixture):
    """Faults of a DIMSE port."""

    def find(self, talk: object, *options: str) -> str:
        port = fakes.Port(talk) if talk else fakes.Port()  # type: ignore[arg-type]
        self.addCleanup(port.stop)
        return self.call("archive", "find", "--server", port.address, *options, status=1, timeout=60).stderr

    def test_time_out(self) -> None:
        start = time.monotonic()
        self.assertIn("time-out: no data for 1 s", self.find(None, "--timeout", "1"))
        self.assertLess(time.monotonic() - start, 20)

    def test_closed_connection(self) -> None:
        def close(connection: socket.socket) -> None:
            connection.recv(100)
        self.assertIn("the connection ended", self.find(close))

    def test_garbage(self) -> None:
        def garbage(connection: socket.socket) -> None:
            connection.recv(100)
            connection.sendall(b"HTTP/1.1 400 Bad Request\r\n\r\n" * 200)
        message = self.find(garbage, "--timeout", "2")
        self.assertRegex(message, "the connection ended|not respond like an archive|time-out")

    def test_endless_responses_are_cancelled(self) -> None:
        def flood(connection: socket.socket) -> None:
            connection.recv(100)
            connection.sendall(b"\x02\x00\xff\xff\xff\xf0")  # an A-ASSOCIATE-AC of 4 GB
            for _ in range(2000):
                connection.sendall(b"\0" * (1 << 20))
        message = self.find(flood, "--timeout", "2")
        self.assertRegex(message, "larger than|the connection ended|not respond like an archive|time-out")


if __name__ == "__main__":
    fixture.main((fixture.ORTHANC, "orthanc"), (fixture.DICOM_WEB, "orthanc-dicomweb"), ("pydicom", "python3-pydicom"))
