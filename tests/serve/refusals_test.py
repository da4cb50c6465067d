#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""refusals_test.py PROGRAM: what `simplexseg-cli serve` refuses: tokens, leases, damaged and too large requests, options, silent
clients, and its end."""
from __future__ import annotations

import ctypes
import json
import os
import random
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "support"))
sys.path.insert(0, str(Path(__file__).resolve().parent))
import client as wire  # noqa: E402
from client import Client, pack  # noqa: E402
from serve_case import Serve, ServeCase, TOKEN, shared  # noqa: E402
from with_program import main, program, skip  # noqa: E402


class Refusals(ServeCase):
    """Leases, tokens, sizes and damaged requests."""
    options = ("--max-megabytes", "4", "--idle-timeout", "600", "--liveness-timeout", "60")

    def test_token(self) -> None:
        """Without the token, only /healthz is served."""
        self.assertEqual(Client(self.server.port).get("/healthz").json, {"ok": True})
        for token in (None, TOKEN[:-1], TOKEN + "x", "x"):
            client = Client(self.server.port, token)
            for method, path in (("GET", "/capabilities"), ("POST", "/claim"), ("POST", "/set_image"), ("GET", "/nothing")):
                self.assert_refused(client.request(method, path, b"{}" if method == "POST" else None), 401, "token")
        self.assert_refused(Client(self.server.port, extra={"Authorization": TOKEN}).get("/capabilities"), 401)

    def test_leases(self) -> None:
        """One client at a time; requests without a lease are refused."""
        client = self.claimed()
        second = self.server.client()
        response = second.post("/claim")
        self.assert_refused(response, 503)
        self.assertEqual(response.headers["retry-after"], "10")
        for path in ("/heartbeat", "/undo", "/reset_interactions", "/add_point_interaction"):
            self.assert_refused(second.post(path), 410)
        self.assertGreater(client.post("/heartbeat").json["remaining_seconds"], 500)
        status = client.get("/lease_status").json
        self.assertEqual(status["idle_timeout_seconds"], 600)
        self.assertEqual(client.post("/release").json, {"released": True})
        self.assertEqual(client.post("/release").json, {"released": True})
        self.assert_refused(client.post("/heartbeat"), 410)
        self.assert_refused(client.get("/lease_status"), 410)
        second.claim()
        self.assert_refused(client.post("/undo"), 410)
        second.post("/release")

    def test_too_large(self) -> None:
        """Sizes are limited before and after decompression."""
        client = self.claimed()
        self.assert_refused(client.send("/set_image", bytes(5 << 20)), 413)
        zeros = pack("uint8", [1, 200, 200, 200], bytes(8_000_000))
        self.assertLess(len(zeros), 1 << 20)
        self.assert_refused(client.send("/set_image", zeros), 413, "larger")
        self.assert_refused(client.post("/add_point_interaction", {"x": "y" * 100_000}), 413)
        claimed = struct.pack("<4sBBBB5s4qI", b"NNIA", 1, 1, 4, 5, b"uint8", 1, 1 << 20, 1 << 20, 1 << 20, 0)
        self.assert_refused(client.send("/set_image", claimed), 413)

    def test_bad_arrays(self) -> None:
        """Damaged arrays, and those that do not fit, are refused and change nothing."""
        client, target = self.opened()
        good = self.image.message()
        target.receive(client.post("/add_point_interaction", {"coordinates": self.centre(), "include_interaction": True}))
        bad = [b"", b"NNIA", b"x" * 100, good[:50], good[:-1], good + b"x", b"XXXX" + good[4:],
               pack("uint8", [2, 4, 4, 4], bytes(128)), pack("uint8", [4, 4, 4], bytes(64)), pack("uint8", [1, 0, 4, 4], b""),
               pack("complex64", [1, 2, 2, 2], bytes(64)), struct.pack("<4sBBBB5s4qI", b"NNIA", 1, 1, 4, 5, b"uint8", 1, -1, 4, 4, 0)]
        for message in bad:
            self.assert_refused(client.send("/add_scribble_interaction", message, {"include_interaction": True}), 400)
        scribble, box = self.drawn({(4, 4, 4), (4, 4, 5)})
        meta = {"include_interaction": True, "interaction_bbox": box}
        for wrong in ("{", "[]", "nonsense", {}, {"include_interaction": 1}, {**meta, "interaction_bbox": [[0, 1]]},
                      {**meta, "interaction_bbox": [[4, 5], [4, 5], [47, 49]]}, {**meta, "interaction_bbox": [[4, 5], [4, 5], [6, 6]]},
                      {**meta, "interaction_bbox": [[1e300, 5], [4, 5], [6, 7]]}, {**meta, "interaction_bbox": None}):
            self.assert_refused(client.send("/add_scribble_interaction", scribble, wrong), 400)
        empty = pack("uint8", [1, 1, 2], bytes(2))
        self.assert_refused(client.send("/add_lasso_interaction", empty, meta), 400)
        before = bytes(target.voxels)
        target.receive(client.post("/undo"))
        self.assertEqual(sum(target.voxels), 0, "the refused prompts were no units of undo")
        self.assertGreater(sum(before), 0)
        for message in bad:
            self.assert_refused(client.send("/set_image", message), 400)

    def test_bad_json(self) -> None:
        """Requests that are no JSON, lack keys, or have values out of range."""
        client, _ = self.opened()
        for body in (b"", b"{", b"[]", b"\xff\xfe", b"null", b"[" * 60_000):
            self.assert_refused(client.request("POST", "/add_point_interaction", body), 400)
        for body in ({"coordinates": [1, 2], "include_interaction": True}, {"coordinates": [1, 2, 3]}, {"include_interaction": True},
                     {"coordinates": [1, 2, "3"], "include_interaction": True}, {"coordinates": [1, 2, 1e308], "include_interaction": True},
                     {"coordinates": [-1, 2, 3], "include_interaction": True}, {"coordinates": [1, 2, 48], "include_interaction": True},
                     {"coordinates": [1, 2, 3], "include_interaction": "yes"},
                     {"coordinates": [1, 2, 3], "include_interaction": True, "run_prediction": None}):
            self.assert_refused(client.post("/add_point_interaction", body), 400)
        for box in (None, [[0, 5], [0, 5], [0, 5]], [[0, 1], [0, 5]], [[5, 5], [0, 5], [0, 5]], [[0, 1], [100, 105], [0, 5]], "x"):
            self.assert_refused(client.post("/add_bbox_interaction", {"bbox_coords": box, "include_interaction": True}), 400)
        for body in ({"shape": [4, 4, 4], "dtype": "uint8"}, {"shape": self.image.shape}, {"shape": self.image.shape, "dtype": "float32"},
                     {"shape": [1.5, 4, 4], "dtype": "uint8"}):
            self.assert_refused(client.post("/set_target_buffer", body), 400)
        for spacing in ([1, 1], [0, 1, 1], [1, 1, float("nan")], "x"):
            self.assert_refused(client.send("/set_image", self.image.message(), {"image_properties": {"spacing": spacing}}), 400)
        client.post("/release")
        client = self.claimed()
        self.assert_refused(client.post("/add_point_interaction", {"coordinates": [1, 2, 3], "include_interaction": True}), 400, "image")

    def test_transport(self) -> None:
        """Paths, methods, browsers, and bodies without a length."""
        client = self.claimed()
        self.assert_refused(client.get("/"), 404)
        self.assert_refused(client.get("/claim"), 405)
        self.assert_refused(client.post("/healthz"), 405)
        self.assert_refused(client.request("POST", "/undo", b"{}", Origin="http://example.org"), 403)
        self.assert_refused(client.request("POST", "/undo", b"{}", **{"Content-Encoding": "gzip"}), 415)
        self.assert_refused(client.request("POST", "/undo", b"{}", **{"Content-Type": "multipart/form-data; boundary=x"}), 415)
        self.assertEqual(client.post("/set_do_autozoom", {"do_autozoom": True}).json, {})

    def raw(self, data: bytes, timeout: float = 15) -> bytes:
        """Sends bytes to the server; returns its response."""
        with socket.create_connection((wire.LOCAL, self.server.port), timeout=timeout) as connection:
            try:
                connection.sendall(data)
                connection.shutdown(socket.SHUT_WR)
                received = b""
                while part := connection.recv(65536):
                    received += part
                return received
            except OSError:
                return b""

    def test_damaged_requests(self) -> None:
        """Random damage of requests: the server survives, and serves the next one."""
        client, target = self.opened()
        lease = client.lease or ""
        headers = f"Host: x\r\nAuthorization: Bearer {TOKEN}\r\nX-Lease-Token: {lease}\r\n".encode()
        array, box = self.drawn({(24, 20, i) for i in range(20, 28)})
        meta = json.dumps({"include_interaction": True, "interaction_bbox": box, "run_prediction": False}).encode()
        body = json.dumps({"coordinates": [1, 2, 3], "include_interaction": False, "run_prediction": False}).encode()
        seeds = [b"POST /add_point_interaction HTTP/1.1\r\n" + headers + b"Content-Length: %d\r\n\r\n" % len(body) + body,
                 b"POST /add_scribble_interaction HTTP/1.1\r\n" + headers + b"X-Meta: " + meta
                 + b"\r\nContent-Length: %d\r\n\r\n" % len(array) + array,
                 b"GET /capabilities HTTP/1.1\r\n" + headers + b"\r\n"]
        chance = random.Random(7)
        for round_ in range(150):
            data = bytearray(seeds[round_ % len(seeds)])
            for _ in range(chance.randint(1, 8)):
                at = chance.randrange(len(data))
                kind = chance.randrange(3)
                if kind == 0:
                    data[at] = chance.randrange(256)
                elif kind == 1:
                    del data[at:at + chance.randint(1, 20)]
                else:
                    data[at:at] = bytes(chance.randrange(256) for _ in range(chance.randint(1, 20)))
            self.raw(bytes(data))
        self.assertIsNone(self.server.process.poll())
        self.raw(b"GET /" + b"x" * 100_000 + b" HTTP/1.1\r\n\r\n")
        self.raw(b"GET /healthz HTTP/1.1\r\n" + b"".join(b"A%d: b\r\n" % n for n in range(20_000)) + b"\r\n")
        self.raw(b"POST /claim HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\nffffffff\r\n")
        self.raw(b"\x00" * 1000)
        self.assertIsNone(self.server.process.poll())
        self.assertEqual(Client(self.server.port).get("/healthz").status, 200)
        target.receive(client.post("/reset_interactions") and client.post("/predict"))

    def test_endless_headers_end(self) -> None:
        """Headers without an end are cut off at a limit of size."""
        with socket.create_connection((wire.LOCAL, self.server.port), timeout=15) as connection:
            connection.sendall(b"GET /healthz HTTP/1.1\r\n")
            sent = 0
            try:
                while sent < 50 << 20:
                    sent += connection.send(b"Name: value\r\n" * 1000)
            except OSError:
                pass
        self.assertLess(sent, 50 << 20)


class Times(unittest.TestCase):
    """Timeouts, the end of the server, and its options."""

    def test_a_silent_client_loses_its_lease(self) -> None:
        """After the liveness timeout another client may have the server; heartbeats prevent it, but not the idle timeout."""
        server = Serve("--liveness-timeout", "2", "--idle-timeout", "5")
        self.addCleanup(server.process.communicate)
        self.addCleanup(server.process.kill)
        first, second = server.client(), server.client()
        first.claim()
        for _ in range(4):
            time.sleep(0.8)
            self.assertEqual(first.post("/heartbeat").status, 200)
        self.assertEqual(second.post("/claim").status, 503)
        end = time.monotonic() + 4
        while first.post("/heartbeat").status == 200:
            self.assertLess(time.monotonic(), end, "the idle timeout")
            time.sleep(0.3)
        second.claim()
        time.sleep(2.5)
        self.assertEqual(second.post("/heartbeat").status, 410)

    def test_signals_end_it(self) -> None:
        """SIGTERM and SIGINT end it within a second, also while clients are connected and it computes."""
        for number in (signal.SIGTERM, signal.SIGINT):
            with self.subTest(signal=number), tempfile.TemporaryDirectory() as folder:
                server = Serve()
                image, _ = shared(Path(folder))
                client = server.client()
                client.claim()
                self.assertEqual(client.send("/set_image", image.message()).status, 200)
                silent = socket.create_connection((wire.LOCAL, server.port))
                busy = socket.create_connection((wire.LOCAL, server.port))
                body = json.dumps({"coordinates": [24, 24, 24], "include_interaction": True}).encode()
                busy.sendall(f"POST /add_point_interaction HTTP/1.1\r\nHost: x\r\nAuthorization: Bearer {TOKEN}\r\nX-Lease-Token: "
                             f"{client.lease}\r\nContent-Length: {len(body)}\r\n\r\n".encode() + body)
                time.sleep(0.05)
                seconds, _, err = server.end(number)
                silent.close()
                busy.close()
                self.assertEqual(server.process.returncode, 0)
                self.assertEqual(err, "")
                self.assertLess(seconds, 2.0)  # 1 s, and a margin for a loaded machine

    def test_options(self) -> None:
        """Beyond the loopback a token is needed; bad tokens and addresses are one line with status 2."""
        environment = {k: v for k, v in os.environ.items() if k != "NN_INTERACTIVE_API_KEY"}

        def refused(*options: str, token: str = "") -> str:
            done = subprocess.run([program(), "serve", *options], capture_output=True, text=True, timeout=60, check=False,
                                  env={**environment, **({"NN_INTERACTIVE_API_KEY": token} if token else {})})
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertEqual(done.stderr.count("\n"), 1)
            self.assertEqual(done.stdout, "")
            return done.stderr

        self.assertIn("no token", refused("--listen", "0.0.0.0"))
        self.assertIn("not an IP address", refused("--listen", "localhost"))
        short = refused(token="secret-short")
        self.assertIn("fewer than 16", short)
        self.assertNotIn("secret-short", short)
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "token"
            self.assertIn("cannot be read", refused("--token-file", str(file)))
            file.write_text(TOKEN + "\n", encoding="utf-8")
            file.chmod(0o644)
            self.assertIn("chmod 600", refused("--token-file", str(file)))
            file.chmod(0o600)
            server = Serve("--token-file", str(file), token=None)
            self.addCleanup(server.process.kill)
            self.assertEqual(Client(server.port).get("/capabilities").status, 401)
            self.assertEqual(Client(server.port, TOKEN).get("/capabilities").status, 200)
            self.assertIn("in use", refused("--port", str(server.port)))
            self.assertLess(server.end()[0], 2.0)


if __name__ == "__main__":
    try:
        ctypes.CDLL(wire.BLOSC)
    except OSError:
        skip("install libblosc1")
    main()
