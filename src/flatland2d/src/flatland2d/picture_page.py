"""A page in the browser that shows pictures as they are made."""

import html
import io
import math
import threading
import time
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any, Optional

import numpy as np
from PIL import Image

from flatland2d.browser import open_in_browser
from flatland_server.arrays import UInt8Array

_HTML = """<!DOCTYPE html>
<title>{title}</title>
<link rel="icon" href="data:,">
<style>
  :root {{ color-scheme: light dark; }}
  body {{ margin: 0; height: 100vh; display: grid; place-items: center; }}
  img {{ max-width: 100%; max-height: 100vh; }}
</style>
<img src="pictures" alt="{title}">
"""
_BOUNDARY = b"--picture\r\n"
_QUALITY = 90
_LAST_PICTURE = 1.0
"""Real time for browsers to get the last picture [s]."""


class PicturePage:
    """A page that shows pictures; it is opened in the user's browser with the first one.

        with PicturePage("my run") as page:
            for _ in range(100):
                page.show(sim.step(20).render(follow="turtlebot"))

    Only browsers on this machine get it. They may come, go and be slow: `show` does not wait for
    them. Where there is no browser, a line says so, and nothing is encoded.

    Args:
        title: title of the page in the browser.
        rate: pictures per second of real time: `show` waits that long.
    """

    def __init__(self, title: str, rate: float = math.inf) -> None:
        self._html = _HTML.format(title=html.escape(title)).encode()
        self._period = 1.0 / rate
        self._next = 0.0  # time.monotonic of the next picture
        self._server: Optional[ThreadingHTTPServer] = None
        self._changed = threading.Condition()
        self._picture: UInt8Array = np.empty((0, 0, 3), np.uint8)
        self._number = 0  # of the picture
        self._browsers = 0

    def show(self, picture: UInt8Array) -> None:
        """Shows a picture, at the time at which it is due.

        Args:
            picture: red, green and blue: shape (height, width, 3).
        """
        time.sleep(max(0.0, self._next - time.monotonic()))
        self._next = time.monotonic() + self._period
        with self._changed:
            self._picture = picture
            self._number += 1
            self._changed.notify_all()
        if self._server is None:
            self._open()

    def wait_until_open(self) -> None:
        """Waits until a browser shows the page; call `show` before."""
        with self._changed:
            self._changed.wait_for(lambda: self._browsers)

    def close(self) -> None:
        """Ends the page; browsers keep the last picture."""
        if self._server is None:
            return
        server, self._server = self._server, None
        with self._changed:
            self._changed.notify_all()
            self._changed.wait_for(lambda: not self._browsers, _LAST_PICTURE)
        server.shutdown()
        server.server_close()

    def __enter__(self) -> "PicturePage":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def port(self) -> int:
        """The port of the page while it is open, and 0 otherwise."""
        return self._server.server_port if self._server is not None else 0

    def _open(self) -> None:
        page = self

        class Handler(_Handler):
            def do_GET(self) -> None:
                self.answer(page)

        self._server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self._server.daemon_threads = True
        threading.Thread(target=self._server.serve_forever, daemon=True).start()
        open_in_browser(f"http://localhost:{self.port}/")

    def _send_pictures(self, file: Any) -> None:
        """Sends each picture, or the latest one to a slow browser, until the page ends."""
        with self._changed:
            self._browsers += 1
            self._changed.notify_all()
        sent = 0
        try:
            file.write(_BOUNDARY)
            while self._wait_for_another(sent):
                with self._changed:
                    sent, picture = self._number, self._picture
                content = io.BytesIO()
                Image.fromarray(picture).save(content, "JPEG", quality=_QUALITY, subsampling=0)
                head = f"Content-Type: image/jpeg\r\nContent-Length: {content.tell()}\r\n\r\n"
                file.write(head.encode() + content.getvalue() + b"\r\n" + _BOUNDARY)
        except OSError:
            pass  # the browser has left
        finally:
            with self._changed:
                self._browsers -= 1
                self._changed.notify_all()

    def _wait_for_another(self, sent: int) -> bool:
        """Waits for another picture than that of a number. False if the page ends without one."""
        with self._changed:
            self._changed.wait_for(lambda: self._number != sent or self._server is None)
            return self._number != sent


class _Handler(BaseHTTPRequestHandler):
    """Answers browsers. Pages of other sites get nothing: they come with another host's name."""

    def answer(self, page: PicturePage) -> None:
        port = page.port
        is_ours = self.headers.get("Host") in (f"localhost:{port}", f"127.0.0.1:{port}")
        content = {"/": page._html, "/pictures": b""}.get(self.path) if is_ours else None
        if content is None:
            self.send_error(404)
            return
        self.send_response(200)
        self.send_header("Cache-Control", "no-store")
        self.send_header("Cross-Origin-Resource-Policy", "same-origin")
        kind = "text/html" if content else "multipart/x-mixed-replace; boundary=picture"
        self.send_header("Content-Type", kind)
        self.end_headers()
        if content:
            self.wfile.write(content)
        else:
            page._send_pictures(self.wfile)

    def log_message(self, format: str, *args: Any) -> None:
        """Says nothing."""
