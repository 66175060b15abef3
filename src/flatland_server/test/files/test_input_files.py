"""Pipes, devices and sockets, files that are too large, and unsupported kinds of images."""

import io
import os
import socket
import struct
import zlib
from pathlib import Path

import pytest
from PIL import Image

from flatland_server.config import composed_files, input_files
from flatland_server.exceptions import YamlError
from flatland_server.maps import map_reader

FILES = {
    "a world": ("world.yaml", None, ""),
    "a map": ("map.yaml", "map: map.yaml", "map: {}"),
    "an image": ("map.png", "image: map.png", "image: {}"),
    "line segments": ("lines.dat", "data: lines.dat", "data: {}"),
    "a model": ("robot.model.yaml", "model: robot.model.yaml", "model: {}"),
}


@pytest.mark.parametrize("name", [name for name, *_ in FILES.values()], ids=FILES.keys())
def test_a_named_pipe_is_refused_at_once(good_files, name):
    path = good_files.folder / name
    path.unlink()
    os.mkfifo(path)

    message = good_files.refusal()

    assert f"{name}: expected a regular file" in message or (
        f"expected a file, but {name} is not a regular file" in message
    )


@pytest.mark.parametrize("device", ["/dev/zero", "/dev/full", "/dev/urandom"])
def test_a_device_is_refused(files, device):
    with pytest.raises(YamlError, match="expected a regular file"):
        files.load(device)


def test_a_socket_is_refused(files):
    with socket.socket(socket.AF_UNIX) as server:
        server.bind(str(files.folder / "world.yaml"))

        assert files.refusal() == "world.yaml: cannot be read: No such device or address"


def grow(path, size: int) -> None:
    """Makes a file that large, without space on disk."""
    with path.open("r+b") as file:
        file.truncate(size + 1)


@pytest.mark.parametrize(
    ("name", "limit"),
    [
        ("world.yaml", input_files.MAX_YAML),
        ("map.yaml", input_files.MAX_YAML),
        ("robot.model.yaml", input_files.MAX_YAML),
        ("map.png", input_files.MAX_IMAGE),
        ("lines.dat", input_files.MAX_LINE_SEGMENTS),
    ],
)
def test_a_file_that_is_too_large_is_not_read(good_files, name, limit):
    grow(good_files.folder / name, limit)

    message = f"{name}: expected a file of at most {limit // 2**20} MiB, found a larger one"
    assert message in good_files.refusal().splitlines()


def test_a_file_without_a_size_is_read_up_to_the_limit():
    """As those in /proc: the size of this one is said to be 0."""
    with pytest.raises(YamlError, match="expected a file of at most 0 MiB"):
        input_files.read_input(Path("/proc/self/maps"), 100)


def test_a_file_with_too_many_values_is_refused_early(files, monkeypatch):
    monkeypatch.setattr(composed_files, "MAX_VALUES", 1000)
    files.write("world.yaml", f"x: [{'1, ' * 600}]\ny:\n- $include other.yaml\n")
    files.write("other.yaml", f"[{'1, ' * 300}\n{'1, ' * 300}]\n")

    assert files.refusal().startswith("other.yaml:2:")


# Line segments


@pytest.mark.parametrize("number", ["1e308", "-1e308", "1e10"])
def test_an_enormous_number_in_line_data_is_named_with_its_line(good_files, number):
    good_files.edit("lines.dat", "2 3 -1 2", f"2 3 -1 {number}")

    assert good_files.refusal() == (
        f'lines.dat:2: expected numbers within 1e+09 of zero, found "2 3 -1 {number}"'
    )


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        ("0 0 1 1\n2 3 -1 9e6", "within 100 km of the origin, found one beyond in lines.dat:2"),
        ("2 3 2 3.000001", "of a micrometre or more, found a shorter one in lines.dat:1"),
        ("2 3 2 3\n0 0 0 0", "of a micrometre or more, found a shorter one in lines.dat:1"),
    ],
)
def test_impossible_walls_are_named_with_their_line(good_files, lines, message):
    good_files.write("lines.dat", lines)

    assert good_files.refusal() == f"lines.yaml: expected walls {message}"


def test_zero_length_lines_and_extra_columns_cause_a_warning(good_files, caplog):
    """As in the original: CAD programs write them."""
    good_files.write("lines.dat", "0 0 5 0 0.5\n2 2 2.0 2\n0 0 0 5e0 wall\n1 1 1 1.000001")

    assert len(good_files.load().get_layer("lines").segments) == 2
    assert [each.message.replace(f"{good_files.folder}/", "") for each in caplog.records] == [
        "lines.dat:1: expected four numbers, x1 y1 x2 y2, found more, and in 1 further line: it is "
        "ignored",
        "lines.yaml: expected walls of a micrometre or more, found 2 shorter ones, left out, "
        "the first in lines.dat:2",
    ]


def test_a_line_without_an_end_is_quoted_in_part(good_files):
    good_files.edit("lines.dat", "2 3 -1 2", "x" * 70_000)

    assert len(good_files.refusal()) < 200


# Images


@pytest.mark.parametrize("kind", ["BMP", "GIF", "JPEG", "PCX", "PNG", "PPM", "TGA", "TIFF", "WEBP"])
def test_an_image_of_a_known_format_is_read(good_files, kind):
    image = Image.new("L", (20, 20), 255)
    image.paste(0, (5, 5, 15, 15))
    content = io.BytesIO()
    image.convert("RGB").save(content, kind)
    good_files.write("map.png", content.getvalue())

    assert len(good_files.load().get_layer("map").segments) >= 4


def test_an_image_that_another_program_would_draw_is_not_read(good_files, monkeypatch):
    """Pillow gives PostScript to Ghostscript."""
    good_files.edit("map.yaml", "map.png", "map.eps")
    mark = good_files.folder / "mark"
    ghostscript = good_files.write("gs", f"#!/bin/sh\ntouch {mark}\n")
    ghostscript.chmod(0o755)
    monkeypatch.setenv("PATH", f"{good_files.folder}:{os.environ['PATH']}")
    good_files.write("map.eps", "%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 20 20\n%%EOF\n")

    assert good_files.refusal().startswith("map.eps: is not an image of a known format: BMP, GIF")
    assert not mark.exists()


def png(width: int, height: int) -> bytes:
    """A PNG of white pixels, small however large the image is."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        check = zlib.crc32(kind + data)
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", check)

    header = struct.pack(">IIBBBBB", width, height, 1, 0, 0, 0, 0)
    pixels = zlib.compress(b"\xff" * 1000)
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        [chunk(b"IHDR", header), chunk(b"IDAT", pixels), chunk(b"IEND", b"")]
    )


@pytest.mark.parametrize("side", [9_000, 10_000, 100_000])
def test_a_decompression_bomb_is_refused(good_files, side, recwarn):
    good_files.write("map.png", png(side, side))

    assert good_files.refusal() == (
        "map.png: expected an image of at most 80 million pixels, found more"
    )
    assert not recwarn.list


@pytest.mark.parametrize("error", [IndexError("x"), MemoryError(), struct.error("short"), KeyError])
def test_any_failure_of_the_image_library_is_our_error(good_files, monkeypatch, error):
    def fail(*_):
        raise error

    monkeypatch.setattr(map_reader, "bright_pixels", fail)

    assert good_files.refusal().startswith("map.png: cannot be read as an image: ")
