# SPDX-License-Identifier: Apache-2.0
"""Misbehaving servers on the loopback, for tests of archives. Each ends with its test and sends a bounded number of bytes."""
from __future__ import annotations

import http.server
import json
import socket
import ssl
import threading
import time
from typing import Any, Callable

LOCAL = "127.0.0.1"
STUDY, SERIES = "1.2.826.0.1.3680043.9.7.2", "1.2.826.0.1.3680043.9.7.3"
Response = Callable[["Handler"], None]


class Handler(http.server.BaseHTTPRequestHandler):
    """Applies the first rule whose text is in the path."""
    rules: dict[str, Response] = {}
    sent = 0

    def log_message(self, *arguments: Any) -> None:
        """Prints nothing."""

    def response(self) -> None:
        """Handles any method; ignores clients that disconnect."""
        try:
            for text, rule in self.rules.items():
                if text in self.path:
                    rule(self)
                    return
            self.send_error(404)
        except OSError:
            pass

    do_GET = do_POST = response

    def reply(self, body: bytes, kind: str = "application/dicom+json", status: int = 200, claim: int | None = None) -> None:
        """Sends a complete response; `claim`: its Content-Length."""
        self.send_response(status)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(body) if claim is None else claim))
        self.end_headers()
        self.wfile.write(body)


class Server:
    """Server with these rules."""

    def __init__(self, rules: dict[str, Response]) -> None:
        self.handler = type("Rules", (Handler,), {"rules": rules})
        self.server = http.server.ThreadingHTTPServer((LOCAL, 0), self.handler)
        self.server.daemon_threads = True
        self.thread = threading.Thread(target=self.server.serve_forever, kwargs={"poll_interval": 0.05})
        self.thread.start()

    @property
    def address(self) -> str:
        """URL for DICOMweb."""
        return f"http://{LOCAL}:{self.server.server_address[1]}/web"

    def stop(self) -> None:
        """Stops the server."""
        self.server.shutdown()
        self.server.server_close()
        self.thread.join()


def listing(uids: list[str]) -> Response:
    """List of the instances of a series; pages after the first are empty."""
    def rule(handler: Handler) -> None:
        page = uids if "offset=0" in handler.path else []
        handler.reply(json.dumps([{"00080018": {"vr": "UI", "Value": [uid]}} for uid in page]).encode())
    return rule


def parts(bodies: list[bytes], ending: bytes = b"--\r\n", cut: int | None = None, length: int | None = None) -> Response:
    """Series as a multipart response. `ending`: end of the last delimiter; `cut`: number of bytes after which the
    connection is closed; `length`: Content-Length of the parts."""
    def rule(handler: Handler) -> None:
        body = b""
        for one in bodies:
            claim = b"" if length is None else b"Content-Length: %d\r\n" % length
            body += b"\r\n--frontier\r\nContent-Type: application/dicom\r\n" + claim + b"\r\n" + one
        body += b"\r\n--frontier" + ending
        handler.reply(body[:cut], 'multipart/related; type="application/dicom"; boundary=frontier')
    return rule


def endless(kind: str, total: int) -> Response:
    """`total` zero bytes in chunks, without a Content-Length."""
    def rule(handler: Handler) -> None:
        handler.protocol_version = "HTTP/1.1"
        handler.send_response(200)
        handler.send_header("Content-Type", kind)
        handler.send_header("Transfer-Encoding", "chunked")
        handler.end_headers()
        block = b"[" + b" " * ((1 << 20) - 1)
        for _ in range(total >> 20):
            handler.wfile.write(b"%x\r\n" % len(block) + block + b"\r\n")
            type(handler).sent += len(block)
    return rule


def silent(seconds: float) -> Response:
    """Sends nothing."""
    def rule(handler: Handler) -> None:
        del handler
        time.sleep(seconds)
    return rule


class Proxy:
    """Forwards bytes to a local port. After `after` bytes in the observed direction it calls `then` and closes both sides.
    `certificate`: file with a certificate and its key for TLS with the clients."""

    def __init__(self, port: int, after: int = 1 << 62, upwards: bool = True, then: Callable[[], None] = lambda: None,
                 certificate: str = "") -> None:
        self.target, self.left, self.upwards, self.then = port, after, upwards, then
        self.tls: ssl.SSLContext | None = None
        if certificate:
            self.tls = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
            self.tls.load_cert_chain(certificate)
        self.listener = socket.create_server((LOCAL, 0))
        self.port = self.listener.getsockname()[1]
        self.threads: list[threading.Thread] = []
        self.thread = threading.Thread(target=self.accept)
        self.thread.start()

    def accept(self) -> None:
        """Accepts connections until the listener is closed."""
        while True:
            try:
                client, _ = self.listener.accept()
            except OSError:
                return
            try:
                client.settimeout(20)
                if self.tls:
                    client = self.tls.wrap_socket(client, server_side=True)
                server = socket.create_connection((LOCAL, self.target), timeout=20)
            except OSError:  # the client does not trust the certificate
                client.close()
                continue
            for source, target, up in ((client, server, True), (server, client, False)):
                thread = threading.Thread(target=self.pass_on, args=(source, target, up))
                thread.start()
                self.threads.append(thread)

    def pass_on(self, source: socket.socket, target: socket.socket, up: bool) -> None:
        """Forwards one direction of a connection."""
        try:
            while data := source.recv(4096):
                if up == self.upwards:
                    self.left -= len(data)
                    if self.left < 0:
                        self.then()
                        break
                target.sendall(data)
        except OSError:
            pass
        for one in (source, target):
            try:
                one.shutdown(socket.SHUT_RDWR)
            except OSError:
                pass
        source.close()

    def stop(self) -> None:
        """Stops the server."""
        self.listener.shutdown(socket.SHUT_RDWR)
        self.listener.close()
        self.thread.join()
        for thread in self.threads:
            thread.join()


class Port:
    """Port that accepts connections and calls `talk`, or sends nothing."""

    def __init__(self, talk: Callable[[socket.socket], None] = lambda connection: None) -> None:
        self.talk = talk
        self.listener = socket.create_server((LOCAL, 0))
        self.address = f"ANY@{LOCAL}:{self.listener.getsockname()[1]}"
        self.over = threading.Event()
        self.thread = threading.Thread(target=self.accept)
        self.thread.start()

    def accept(self) -> None:
        """Handles one connection after the other."""
        while True:
            try:
                connection, _ = self.listener.accept()
            except OSError:
                return
            with connection:
                try:
                    self.talk(connection)
                    if self.talk.__name__ == "<lambda>":
                        self.over.wait(60)
                except OSError:
                    pass

    def stop(self) -> None:
        """Stops the server."""
        self.over.set()
        self.listener.shutdown(socket.SHUT_RDWR)
        self.listener.close()
        self.thread.join()
