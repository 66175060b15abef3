"""A page of pictures: what browsers get, and that they do not hold up the program."""

import io
import socket
import urllib.error
import urllib.request

import numpy as np
import pytest
from PIL import Image
from waiting import wait_until

from flatland2d import PicturePage


@pytest.fixture
def opened(monkeypatch):
    """The addresses of pages that were opened in the browser."""
    urls = []
    monkeypatch.setattr("flatland2d.picture_page.open_in_browser", urls.append)
    return urls


def picture(grey):
    return np.full((48, 64, 3), grey, np.uint8)


def next_picture(stream):
    """The next picture of a stream: its grey in the middle; None if the stream has ended."""
    boundary = stream.readline()
    head = dict(line.split(": ") for line in iter(lambda: stream.readline().decode().strip(), ""))
    if not head:
        return None
    assert boundary == b"--picture\r\n"
    content = stream.read(int(head["Content-Length"]))
    assert stream.readline() == b"\r\n"
    image = Image.open(io.BytesIO(content))
    assert image.size == (64, 48)
    return image.getpixel((32, 24))[0]


def test_browsers_get_each_picture_and_the_last_one(opened):
    with PicturePage("a <run>") as page:
        page.show(picture(10))
        [url] = opened
        html = urllib.request.urlopen(url).read().decode()
        assert "<title>a &lt;run&gt;</title>" in html
        stream = urllib.request.urlopen(f"{url}pictures")
        page.wait_until_open()
        assert next_picture(stream) == pytest.approx(10, abs=2)
        page.show(picture(200))
        assert next_picture(stream) == pytest.approx(200, abs=2)
        page.show(picture(90))
    assert next_picture(stream) == pytest.approx(90, abs=2)
    assert next_picture(stream) is None
    assert len(opened) == 1


def test_browsers_that_leave_or_do_not_read_are_no_trouble(opened):
    with PicturePage("run") as page:
        page.show(picture(10))
        port = int(opened[0].rpartition(":")[2].strip("/"))
        stalled, gone = (socket.create_connection(("127.0.0.1", port)) for _ in range(2))
        for each in (stalled, gone):
            each.sendall(f"GET /pictures HTTP/1.1\r\nHost: localhost:{port}\r\n\r\n".encode())
            assert each.recv(1)
        wait_until(lambda: page._browsers == 2, "both")
        gone.close()
        noise = np.random.default_rng(1).integers(0, 256, (400, 400, 3), dtype=np.uint8)
        for _ in range(100):
            page.show(noise)
        wait_until(lambda: page._browsers == 1 or page.show(noise), "the one that has left")
        stalled.close()


def test_pages_of_other_sites_get_nothing(opened):
    with PicturePage("run") as page:
        page.show(picture(10))
        for path in ("", "pictures", "../etc/passwd"):
            request = urllib.request.Request(opened[0] + path, headers={"Host": "evil.example"})
            with pytest.raises(urllib.error.HTTPError, match="404"):
                urllib.request.urlopen(request)


def test_pictures_are_paced(opened, monkeypatch):
    slept = []
    monkeypatch.setattr("flatland2d.picture_page.time.sleep", slept.append)
    with PicturePage("run", rate=10.0) as page:
        page.show(picture(10))
        page.show(picture(20))
    assert slept[0] == 0.0
    assert slept[1] == pytest.approx(0.1, abs=0.05)


def test_a_page_without_pictures_opens_nothing(opened):
    PicturePage("run").close()
    assert opened == []
