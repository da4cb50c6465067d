# SPDX-License-Identifier: Apache-2.0
"""Client of the server for tests: the protocol by Python's standard library. Chunks of arrays are compressed and decompressed by
Debian's libblosc1, which shares no code with the program, or stored without compression."""
from __future__ import annotations

import ctypes
import http.client
import json
import struct
from dataclasses import dataclass, field
from typing import Any, Callable

LOCAL = "127.0.0.1"
MIB = 1 << 20
BLOSC = "libblosc.so.1"


def stored_chunk(data: bytes, element: int = 1) -> bytes:
    """Uncompressed chunk of Blosc 1: version 2, format 1, flag "memcpyed"."""
    size = len(data)
    return struct.pack("<BBBBIII", 2, 1, 2, element, size, max(size, 1), size + 16) + data


def zstd_chunk(data: bytes, element: int = 1) -> bytes:
    """Chunk of Blosc 1 with Zstandard and the byte shuffle."""
    blosc = ctypes.CDLL(BLOSC)
    to = ctypes.create_string_buffer(len(data) + 16)
    size = blosc.blosc_compress_ctx(3, 1, ctypes.c_size_t(element), ctypes.c_size_t(len(data)), data, to,
                                    ctypes.c_size_t(len(to)), b"zstd", ctypes.c_size_t(0), 1)
    if size <= 0:
        raise RuntimeError(f"libblosc1: {size}")
    return to.raw[:size]


def unpack(message: bytes) -> tuple[str, list[int], bytes]:
    """Type, shape and elements of an array message."""
    magic, version, _codec, axes, length = struct.unpack_from("<4sBBBB", message)
    if magic != b"NNIA" or version != 1:
        raise RuntimeError("not an array")
    at = 8 + length
    shape = list(struct.unpack_from(f"<{axes}q", message, at))
    at += 8 * axes
    (chunks,) = struct.unpack_from("<I", message, at)
    at += 4
    blosc = ctypes.CDLL(BLOSC)
    data = b""
    for _ in range(chunks):
        size, stored = struct.unpack_from("<QQ", message, at)
        at += 16
        to = ctypes.create_string_buffer(max(size, 1))
        if blosc.blosc_decompress_ctx(message[at:at + stored], to, ctypes.c_size_t(size), 1) != size:
            raise RuntimeError("damaged chunk")
        data += to.raw[:size]
        at += stored
    return message[8:8 + length].decode(), shape, data


def pack(dtype: str, shape: list[int], data: bytes, chunk: Callable[..., bytes] = zstd_chunk, element: int = 1,
         chunk_bytes: int = MIB) -> bytes:
    """Array message. `element`: bytes of an element."""
    parts = [data[at:at + chunk_bytes] for at in range(0, len(data), chunk_bytes)]
    name = dtype.encode()
    message = struct.pack("<4sBBBB", b"NNIA", 1, 1, len(shape), len(name)) + name
    message += struct.pack(f"<{len(shape)}q", *shape) + struct.pack("<I", len(parts))
    for part in parts:
        packed = chunk(part, element)
        message += struct.pack("<QQ", len(part), len(packed)) + packed
    return message


@dataclass
class Response:
    """Status, headers and body of a response."""
    status: int
    headers: dict[str, str]
    body: bytes

    @property
    def json(self) -> Any:
        """Body as JSON."""
        return json.loads(self.body)

    @property
    def meta(self) -> Any:
        """Header X-Meta."""
        return json.loads(self.headers["x-meta"])


@dataclass
class Client:
    """One client. Every request has a connection of its own."""
    port: int
    token: str | None = None
    lease: str | None = None
    extra: dict[str, str] = field(default_factory=dict)

    def request(self, method: str, path: str, body: bytes | None = None, meta: Any = None, timeout: float = 120,
                **headers: str) -> Response:
        """Sends a request and returns the response."""
        sent = dict(self.extra)
        if self.token:
            sent["Authorization"] = "Bearer " + self.token
        if self.lease:
            sent["X-Lease-Token"] = self.lease
        if meta is not None:
            sent["X-Meta"] = meta if isinstance(meta, str) else json.dumps(meta)
        sent.update(headers)
        connection = http.client.HTTPConnection(LOCAL, self.port, timeout=timeout)
        try:
            connection.request(method, path, body, sent)
            response = connection.getresponse()
            return Response(response.status, {k.lower(): v for k, v in response.getheaders()}, response.read())
        finally:
            connection.close()

    def get(self, path: str) -> Response:
        """GET."""
        return self.request("GET", path)

    def post(self, path: str, body: Any = None) -> Response:
        """POST with JSON."""
        return self.request("POST", path, json.dumps({} if body is None else body).encode())

    def send(self, path: str, array: bytes, meta: Any = None) -> Response:
        """POST with an array."""
        return self.request("POST", path, array, {} if meta is None else meta)

    def claim(self) -> None:
        """Claims the lease."""
        response = self.post("/claim")
        if response.status != 200:
            raise RuntimeError(f"claim: {response.status} {response.body!r}")
        self.lease = response.json["lease_token"]
