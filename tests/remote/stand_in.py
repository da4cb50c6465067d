#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Stand-in for segmentation servers, on the loopback: the inference server of nnInteractive, and MONAI Label.

stand_in.py [PROTOCOL [FAULT [TOKEN]]] serves until it is killed, and prints its port first. The mask is the set of voxels
whose value is within 100 of that of the first inside point. Arrays are read and written by the library c-blosc, not by
code of the project."""
from __future__ import annotations

import array
import email.parser
import email.policy
import gzip
import json
import math
import socket
import struct
import sys
import threading
import time
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

import blosc

TYPES = {"int8": "b", "uint8": "B", "int16": "h", "uint16": "H", "int32": "i", "uint32": "I", "float32": "f", "float64": "d"}
NIFTI_TYPES = {2: "B", 4: "h", 8: "i", 16: "f", 64: "d", 256: "b", 512: "H", 768: "I"}


def unpack(message: bytes) -> tuple[list[int], str, array.array[Any]]:
    """Shape, type and elements of an array."""
    magic, version, codec, axes, length = struct.unpack_from("<4sBBBB", message)
    assert (magic, version) == (b"NNIA", 1) and codec in (1, 2), message[:8]
    name = message[8:8 + length].decode()
    shape = list(struct.unpack_from(f"<{axes}q", message, 8 + length))
    at = 8 + length + 8 * axes
    (chunks,) = struct.unpack_from("<I", message, at)
    at += 4
    raw = b""
    for _ in range(chunks):
        size, stored = struct.unpack_from("<QQ", message, at)
        chunk = blosc.decompress(message[at + 16:at + 16 + stored])
        assert len(chunk) == size
        raw += chunk
        at += 16 + stored
    assert at == len(message) and len(raw) == math.prod(shape) * array.array(TYPES[name]).itemsize
    return shape, name, array.array(TYPES[name], raw)


def runs_chunk(raw: bytes) -> bytes:
    """Chunk of version 2 with the extended header: blocks of 64 bytes that are runs of one byte, or stored as they are."""
    blocks = [raw[n:n + 64] for n in range(0, len(raw), 64)]
    body, starts = b"", []
    for block in blocks:
        starts.append(32 + 4 * len(blocks) + len(body))
        if block == bytes([block[0]]) * len(block):
            body += struct.pack("<i", -block[0]) + (b"\1" if block[0] else b"")
        else:
            body += struct.pack("<i", len(block)) + block
    body = struct.pack(f"<{len(starts)}i", *starts) + body
    return struct.pack("<BBBBiii", 5, 1, 0x95, 1, len(raw), min(64, len(raw)), 32 + len(body)) + bytes(16) + body


def pack(shape: list[int], raw: bytes, runs: bool) -> bytes:
    """Message with an array of uint8."""
    chunk = runs_chunk(raw) if runs else blosc.compress(raw, typesize=1, cname="zstd", shuffle=blosc.NOSHUFFLE)
    head = struct.pack("<4sBBBB", b"NNIA", 1, 1, len(shape), 5) + b"uint8" + struct.pack(f"<{len(shape)}q", *shape)
    return head + struct.pack("<IQQ", 1, len(raw), len(chunk)) + chunk


class HttpServer(ThreadingHTTPServer):
    """Server that does not report clients that leave."""

    daemon_threads = True

    def handle_error(self, request: Any, client_address: Any) -> None:
        if not isinstance(sys.exc_info()[1], ConnectionError):
            super().handle_error(request, client_address)


class StandIn:
    """Server in a thread. `fault`: name of a fault, see the handlers. `token`: bearer token that it requires."""

    def __init__(self, protocol: str = "nninteractive", fault: str = "", token: str = "") -> None:
        self.protocol, self.fault, self.token = protocol, fault, token
        self.paths: list[str] = []             # of all requests, in their order
        self.received: list[bytes] = []        # headers and bodies of all requests; images decompressed
        self.points: list[tuple[list[int], bool]] = []
        self.scribbles: list[tuple[list[list[int]], bytes, bool]] = []  # box along k, j, i, its voxels, and whether inside
        self.leases = 0
        self.image: array.array[Any] = array.array("h")
        self.size = [0, 0, 0]                  # along k, j, i
        self.nifti = b""
        handler = type("Handler", (NnInteractive if protocol == "nninteractive" else MonaiLabel,), {"owner": self})
        self.http = HttpServer(("127.0.0.1", 0), handler)
        self.thread = threading.Thread(target=self.http.serve_forever, kwargs={"poll_interval": 0.05}, daemon=True)
        self.thread.start()

    @property
    def port(self) -> int:
        return int(self.http.server_address[1])

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self.port}"

    def stop(self) -> None:
        """Stops the server."""
        self.http.shutdown()
        self.http.server_close()

    def mask(self, seed: list[int]) -> bytes:
        """Mask of the voxels as bright as the seed, whose indices are along k, j, i."""
        _, rows, columns = self.size
        value = self.image[(seed[0] * rows + seed[1]) * columns + seed[2]]
        if self.fault == "empty":
            return bytes(len(self.image))
        inside = (lambda v: abs(v - value) >= 100) if self.fault == "elsewhere" else (lambda v: abs(v - value) < 100)
        return bytes(map(inside, self.image))


class Handler(BaseHTTPRequestHandler):
    """Common parts of both protocols."""

    owner: StandIn
    protocol_version = "HTTP/1.1"

    def log_message(self, *arguments: Any) -> None:
        pass

    def respond(self, status: int, body: bytes, content_type: str = "application/json", meta: str = "", cut: int = 0) -> None:
        self.send_response(status)
        self.send_header("Content-Type", content_type)
        self.send_header("Content-Length", str(len(body)))
        if meta:
            self.send_header("X-Meta", meta)
        self.end_headers()
        self.wfile.write(body[:len(body) - cut])
        if cut:
            self.wfile.flush()
            self.connection.shutdown(socket.SHUT_RDWR)
            self.close_connection = True

    def json(self, value: Any, status: int = 200) -> None:
        self.respond(status, json.dumps(value).encode())

    def fail(self, status: int, detail: str) -> None:
        self.json({"detail": detail}, status)

    def read(self) -> bytes:
        """Body of the request; records path, headers and body."""
        body = self.rfile.read(int(self.headers.get("Content-Length", 0)))
        self.owner.paths.append(self.command + " " + self.path)
        self.owner.received += [self.path.encode(), str(self.headers).encode(), body]
        return body

    def allowed(self) -> bool:
        if not self.owner.token or self.headers.get("Authorization") == "Bearer " + self.owner.token:
            return True
        self.fail(401, "Invalid bearer token")
        return False

    def serve(self, body: bytes) -> None:
        raise NotImplementedError

    def handle_request(self) -> None:
        if self.path == "/stand-in/requests":  # for tests in another process
            return self.respond(200, " ".join(self.owner.paths).encode(), "text/plain")
        body = self.read()
        if self.owner.fault == "slow" and self.path in ("/claim", "/info/"):
            time.sleep(4)
        self.serve(body)

    do_GET = do_POST = do_PUT = do_DELETE = handle_request


class NnInteractive(Handler):
    """Inference server of nnInteractive."""

    def serve(self, body: bytes) -> None:
        owner, fault = self.owner, self.owner.fault
        if self.path == "/healthz":
            return self.json({"ok": True})
        if not self.allowed():
            return None
        if self.path == "/capabilities":
            licence = "!!MISSING!!" if fault == "no licence" else "CC BY-NC-SA 4.0\nfor tests"
            kinds = {"points": fault != "no points", "bbox3d": False, "scribble": fault != "no scribbles"}
            return self.json({"supported_interactions": kinds, "preferred_scribble_thickness": [2, 2, 2], "license": licence})
        if self.path == "/claim":
            if fault == "503":
                return self.fail(503, "server is at capacity (1 sessions)")
            owner.leases += 1
            return self.json({"lease_token": f"lease-{owner.leases}", "idle_timeout_seconds": 600, "liveness_timeout_seconds": 2})
        lease = self.headers.get("X-Lease-Token")
        if self.path == "/release":
            return self.json({"released": True})
        if lease != f"lease-{owner.leases}":
            return self.fail(410, "lease expired or unknown")
        if self.path == "/heartbeat":
            return self.json({"remaining_seconds": 600})
        if self.path == "/set_image":
            return self.set_image(body)
        if self.path == "/set_target_buffer":
            wanted = {"shape": owner.size, "dtype": "uint8"}
            return self.json({}) if json.loads(body) == wanted else self.fail(400, f"expected {wanted}")
        if self.path == "/add_point_interaction":
            return self.add_point(json.loads(body))
        if self.path == "/add_scribble_interaction":
            return self.add_scribble(json.loads(self.headers["X-Meta"]), body)
        return self.fail(404, "Not Found")

    def set_image(self, body: bytes) -> None:
        owner = self.owner
        if owner.fault == "413":
            return self.fail(413, "image too large")
        shape, _, owner.image = unpack(body)
        owner.received.append(owner.image.tobytes())
        owner.size, owner.points, owner.scribbles = shape[1:], [], []
        if len(json.loads(self.headers["X-Meta"])["image_properties"]["spacing"]) != 3 or shape[0] != 1:
            return self.fail(400, "expected one channel and a spacing")
        return self.json({"original_image_shape": shape})

    def add_point(self, request: dict[str, Any]) -> None:
        owner, fault = self.owner, self.owner.fault
        if fault == "410" or (fault == "410 once" and owner.leases == 1):
            owner.leases += fault == "410 once"
            return self.fail(410, "lease expired or unknown")
        if fault == "500":
            return self.respond(500, b"Internal Server Error", "text/plain")
        if fault == "400":
            return self.fail(400, "coordinates are odd\n")
        owner.points.append((request["coordinates"], request["include_interaction"]))
        if not request["run_prediction"]:
            return self.respond(200, b"", "application/octet-stream", json.dumps({"ran_prediction": False, "bbox": None}))
        if fault == "slow prediction":
            time.sleep(4)
        whole = owner.mask(next(at for at, inside in owner.points if inside))
        box, raw = self.region(whole)
        body = pack([high - low for low, high in box], raw, runs=fault != "blosc 1")
        if fault == "shape":
            body = pack([1] + [high - low for low, high in box], raw, runs=False)
        if fault == "outside":
            box = [[low + 1000, high + 1000] for low, high in box]
        if fault == "damaged":
            body = body[:30] + bytes(len(body) - 30)
        if fault == "page":
            body = b"<html>no</html>"
        meta = json.dumps({"ran_prediction": True, "bbox": box, "dtype": "uint8"})
        if fault == "no meta":
            meta = ""
        self.respond(200, body, "application/octet-stream", meta, cut=len(body) // 2 if fault == "cut" else 0)

    def add_scribble(self, request: dict[str, Any], body: bytes) -> None:
        shape, kind, voxels = unpack(body)
        box = request["interaction_bbox"]
        fits = all(0 <= low < high <= size for (low, high), size in zip(box, self.owner.size))
        if not fits or shape != [high - low for low, high in box] or kind != "uint8" or not any(voxels) or request["run_prediction"]:
            return self.fail(400, "the scribble does not fit")
        self.owner.scribbles.append((box, voxels.tobytes(), request["include_interaction"]))
        return self.respond(200, b"", "application/octet-stream", json.dumps({"ran_prediction": False, "bbox": None}))

    def region(self, whole: bytes) -> tuple[list[list[int]], bytes]:
        """Smallest region of the mask, as the server sends it, or all of an empty one."""
        slices, rows, columns = self.owner.size
        found = [n for n, inside in enumerate(whole) if inside] or [0, len(whole) - 1]
        axes = [[n // (rows * columns) for n in found], [n // columns % rows for n in found], [n % columns for n in found]]
        box = [[min(axis), max(axis) + 1] for axis in axes]
        raw = b"".join(whole[(k * rows + j) * columns + box[2][0]:(k * rows + j) * columns + box[2][1]]
                       for k in range(*box[0]) for j in range(*box[1]))
        return box, raw


class MonaiLabel(Handler):
    """MONAI Label."""

    def serve(self, body: bytes) -> None:
        owner, fault = self.owner, self.owner.fault
        path = self.path.split("?")[0]
        if path == "/info/":
            if not self.allowed():
                return None
            models = {"organs": {"type": "segmentation"}, "clicks": {"type": "deepgrow", "labels": ["object"]}}
            return self.json({"name": "stand-in", "models": {} if fault == "no models" else models})
        if path == "/session/" and self.command == "PUT":
            if fault == "413":
                return self.fail(413, "too large")
            if fault == "406":
                return self.fail(406, "Session Feature is Not Enabled")
            owner.nifti = gzip.decompress(self.form(body)["files"])
            owner.received.append(owner.nifti)
            return self.json({"session_id": "session-1", "session_info": {}})
        if path.startswith("/session/") and self.command == "DELETE":
            return self.json({})
        if path == "/infer/clicks" and "session_id=session-1" in self.path:
            return self.infer(json.loads(self.form(body)["params"]))
        return self.fail(404, "Not Found")

    def form(self, body: bytes) -> dict[str, bytes]:
        head = f"Content-Type: {self.headers['Content-Type']}\r\n\r\n".encode()
        parts = email.parser.BytesParser(policy=email.policy.HTTP).parsebytes(head + body)
        return {str(part.get_param("name", header="content-disposition")): part.get_payload(decode=True) for part in parts.iter_parts()}

    def infer(self, params: dict[str, Any]) -> None:
        owner, fault = self.owner, self.owner.fault
        if fault == "500":
            return self.fail(500, "Failed to execute infer")
        owner.points = [(at, True) for at in params["foreground"]] + [(at, False) for at in params["background"]]
        size = struct.unpack_from("<3h", owner.nifti, 42)
        owner.size = [size[2], size[1], size[0]]
        code, = struct.unpack_from("<h", owner.nifti, 70)
        offset = int(struct.unpack_from("<f", owner.nifti, 108)[0])
        owner.image = array.array(NIFTI_TYPES[code], owner.nifti[offset:])
        mask = owner.mask(params["foreground"][0][::-1])
        head = bytearray(owner.nifti[:offset])
        struct.pack_into("<hh", head, 70, 2, 8)
        if fault == "grid":
            struct.pack_into("<f", head, 280 + 12, struct.unpack_from("<f", head, 292)[0] + 50)
            struct.pack_into("<f", head, 268, struct.unpack_from("<f", head, 268)[0] + 50)
        labels = gzip.compress(bytes(head) + mask, 1)
        if fault == "damaged":
            labels = labels[:100] + bytes(len(labels) - 100)
        self.respond(200, labels, "application/gzip", cut=len(labels) // 2 if fault == "cut" else 0)


if __name__ == "__main__":
    server = StandIn(*sys.argv[1:4])
    print(server.port, flush=True)
    server.thread.join()
