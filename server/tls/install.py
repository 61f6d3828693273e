"""A listener without encryption that hands out the authority's certificate and sends all else to https."""

from __future__ import annotations

import re
import socket
from collections.abc import Iterator
from contextlib import contextmanager
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from threading import Thread

PATH = "/ca.crt"


@contextmanager
def certificate_at(host: str, port: int, certificate: bytes, https_port: int) -> Iterator[int]:
    """Hand out a certificate on a port (0: a free one) while the context is open; yield the port.

    Raises:
        OSError: the port is taken.
    """

    class Handler(BaseHTTPRequestHandler):
        timeout = 10

        def do_GET(self) -> None:
            if self.path == PATH:
                self.send_response(HTTPStatus.OK)
                self.send_header("Content-Type", "application/x-x509-ca-cert")
                self.send_header("Content-Length", str(len(certificate)))
                self.end_headers()
                if self.command == "GET":
                    self.wfile.write(certificate)
                return
            name = re.sub(r":\d+$", "", self.headers.get("Host", ""))
            self.send_response(HTTPStatus.TEMPORARY_REDIRECT)
            self.send_header("Location", f"https://{name}:{https_port}{self.path}")
            self.send_header("Content-Length", "0")
            self.end_headers()

        def do_HEAD(self) -> None:
            self.do_GET()

        def log_message(self, format: str, *args: object) -> None:
            """Say nothing."""

    class Listener(ThreadingHTTPServer):
        address_family = socket.AF_INET6 if ":" in host else socket.AF_INET
        daemon_threads = True

    server = Listener((host, port), Handler)
    thread = Thread(target=server.serve_forever, daemon=True)
    thread.start()
    try:
        yield server.server_address[1]
    finally:
        server.shutdown()
        server.server_close()
        thread.join()
