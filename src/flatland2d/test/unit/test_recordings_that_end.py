"""Recordings after a kill of their process or on a full disk, and files of other kinds."""

import os
import random
import resource
import signal
import struct
import subprocess
import sys
import tracemalloc
from pathlib import Path

import pytest
from mcap.reader import make_reader
from test_recorder import READERS
from waiting import wait_until

from flatland2d import Recorder, RecordingError, Simulation, messages, recording_file
from flatland2d.cli import main
from flatland_server import LocalTransport, Timekeeper

STEP = 5_000_000  # ns
STEPS = 40
String = messages.get("std_msgs/String")

PROGRAM = f"""
import sys
from flatland2d import Simulation
sim = Simulation("office")
recorder = sim.record(sys.argv[1])
sim.step({STEPS})
print("stepped", flush=True)
sys.stdin.read()
"""


def recording(path: Path) -> "subprocess.Popen[bytes]":
    """A process that records, has made its steps, and waits for the end of its input."""
    command = [sys.executable, "-c", PROGRAM, str(path)]
    process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    assert process.stdout.readline() == b"stepped\n"
    return process


def record_noise(path: Path) -> None:
    """Records steps with a message of 10 kB each, which cannot be compressed."""
    transport, timekeeper = LocalTransport(), Timekeeper(0.005)
    noise = random.Random(1)
    publisher = transport.advertise("/noise", String, latch=False, queue_size=1)
    with Recorder(transport, timekeeper, path) as recorder:
        for _ in range(STEPS):
            timekeeper.step()
            publisher.publish(String("".join(noise.choices("0123456789abcdef", k=10_000))))
            recorder.write_step()


def times(path: Path) -> list:
    """The times in a recording [ns]."""
    read = READERS[path.suffix](path)
    if path.suffix == ".mcap":
        with path.open("rb") as file:
            statistics = make_reader(file).get_summary().statistics
        assert sum(statistics.channel_message_counts.values()) == statistics.message_count
        assert statistics.message_count == len(read)
    return [each.message.clock.to_nsec() for each in read if each.topic == "/clock"]


@pytest.mark.slow
@pytest.mark.parametrize(("suffix", "name"), [(".bag", signal.SIGKILL), (".mcap", signal.SIGTERM)])
def test_all_chunks_of_a_killed_process_can_be_read(suffix, name, tmp_path, capsys):
    path = tmp_path / f"run{suffix}"
    active = tmp_path / f"run{suffix}.active"
    process = recording(path)
    # Nothing steps any more: the chunk is written because its time has come. It is whole once it
    # can be read; a longer file may have a part of it.
    copy = str(tmp_path / f"copy{suffix}")
    wait_until(lambda: main(["recover", str(active), "-o", copy]) == 0, "the chunk", limit=5.0)
    process.send_signal(name)
    process.communicate()
    capsys.readouterr()

    assert main(["recover", str(active)]) == 0
    assert times(path) == [i * STEP for i in range(STEPS + 1)]
    assert capsys.readouterr().out.endswith(" messages of 0.000 s to 0.200 s\n")
    if suffix == ".bag":
        subprocess.run(["rosbag", "reindex", "--quiet", active], check=True)
        active.rename(tmp_path / "indexed.bag")
        assert times(tmp_path / "indexed.bag") == times(path)


@pytest.mark.parametrize("suffix", READERS)
def test_a_cut_recording_is_read_up_to_its_last_whole_chunk(suffix, tmp_path, monkeypatch):
    monkeypatch.setattr(recording_file, "CHUNK_SIZE", 50_000)
    whole = tmp_path / f"whole{suffix}"
    record_noise(whole)
    content = whole.read_bytes()
    cut = tmp_path / f"cut{suffix}"
    last = -1
    for size in range(len(content) // 5, len(content), len(content) // 5):
        cut.write_bytes(content[:size])

        assert main(["recover", str(cut), "-o", str(tmp_path / f"new{suffix}")]) == 0

        read = times(tmp_path / f"new{suffix}")
        assert read == [i * STEP for i in range(len(read))]
        assert len(read) > last
        last = len(read)


@pytest.fixture
def tmpfs(tmp_path):
    """Mounts a disk of 200 kB."""
    folder = tmp_path / "disk"
    folder.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=200k", "none", str(folder)]
    if os.geteuid() != 0 or subprocess.run(mount, stderr=subprocess.DEVNULL).returncode:
        pytest.skip("only root can mount a small disk")
    yield folder
    subprocess.run(["umount", str(folder)], check=True)


@pytest.mark.parametrize("suffix", READERS)
def test_a_full_disk_ends_the_recording_not_the_simulation(suffix, tmpfs, monkeypatch):
    monkeypatch.setattr(recording_file, "CHUNK_SIZE", 20_000)
    path = tmpfs / f"run{suffix}"

    with Simulation("office") as sim:
        recorder = sim.record(path)
        with pytest.raises(RecordingError) as error:
            sim.step(100_000)
        time = sim.step().time
        assert not recorder.is_open

    assert f"{path}: cannot be written: No space left on device; " in str(error.value)
    read = times(path)
    assert str(error.value).endswith(f"the recording is complete up to {read[-1] * 1e-9:.3f} s")
    assert read == [i * STEP for i in range(len(read))]
    assert 5 * STEP < read[-1] < time * 1e9
    assert [each.name for each in tmpfs.iterdir()] == [path.name]


@pytest.fixture
def file_size():
    """A function that limits the size of files, as a full disk would."""
    former = resource.getrlimit(resource.RLIMIT_FSIZE)
    yield lambda size: resource.setrlimit(resource.RLIMIT_FSIZE, (size, former[1]))
    resource.setrlimit(resource.RLIMIT_FSIZE, former)


@pytest.mark.parametrize("suffix", READERS)
def test_all_chunks_before_the_disk_was_full_are_complete(suffix, tmp_path, monkeypatch, file_size):
    monkeypatch.setattr(recording_file, "CHUNK_SIZE", 25_000)
    path = tmp_path / f"run{suffix}"
    record_noise(path)
    whole = path.stat().st_size
    for size in [*range(whole // 5, whole, whole // 20), whole - 1]:  # the last: within the index
        file_size(size)
        with pytest.raises(RecordingError, match="File too large; the recording is complete up to"):
            record_noise(path)
        file_size(resource.RLIM_INFINITY)

        read = times(path)
        assert read == [i * STEP for i in range(len(read))]
        assert len(read) * 10_000 > size - 2 * 30_000 if suffix == ".bag" else read


def test_a_recording_without_room_for_its_index_is_recoverable(tmp_path, monkeypatch, file_size):
    path = tmp_path / "run.bag"
    file_size(4200)  # the beginning takes 4117
    with pytest.raises(RecordingError, match=r"`flatland recover .*run\.bag\.active` reads what"):
        record_noise(path)
    file_size(100)
    with pytest.raises(RecordingError, match="File too large"):
        Recorder(LocalTransport(), Timekeeper(0.005), tmp_path / "other.bag")

    assert [each.name for each in tmp_path.iterdir()] == ["run.bag.active"]
    file_size(resource.RLIM_INFINITY)
    assert main(["recover", f"{path}.active"]) == 1


@pytest.mark.parametrize("name", ["run.bag", "run.bag.active"])
@pytest.mark.parametrize("kind", ["link", "dangling link", "folder", "pipe", "file", "empty file"])
def test_nothing_but_a_recording_is_replaced(kind, name, tmp_path):
    place, other = tmp_path / name, tmp_path / "other.bag"
    if kind == "link":
        record_noise(other)
    if "link" in kind:
        place.symlink_to(other)
    elif kind == "folder":
        place.mkdir()
    elif kind == "pipe":
        os.mkfifo(place)
    else:
        place.write_text("notes" if kind == "file" else "")
    before = {each: each.lstat() for each in tmp_path.iterdir()}

    with pytest.raises(RecordingError, match="expected a new file or a recording of this format"):
        record_noise(tmp_path / "run.bag")

    assert {each: each.lstat() for each in tmp_path.iterdir()} == before


def test_a_file_that_another_process_records_is_refused(tmp_path):
    path = tmp_path / "run.bag"
    process = recording(path)

    with pytest.raises(RecordingError, match=r"run\.bag: is being recorded already"):
        record_noise(path)

    process.communicate()
    assert times(path)[-1] == STEPS * STEP


@pytest.mark.parametrize("told", [True, False], ids=["as it is", "as a megabyte"])
def test_a_chunk_that_expands_to_gigabytes_is_refused(told, tmp_path):
    zstandard = pytest.importorskip("zstandard")
    compressor = zstandard.ZstdCompressor().compressobj()
    packed = b"".join(compressor.compress(bytes(1 << 20)) for _ in range(1024)) + compressor.flush()
    assert len(packed) < 100_000
    size = 1 << (30 if told else 20)
    content = struct.pack("<QQQI", 0, 0, size, 0) + b"\4\0\0\0zstd" + struct.pack("<Q", len(packed))
    path = tmp_path / "run.mcap.active"
    path.write_bytes(
        b"\x89MCAP0\r\n\x06" + struct.pack("<Q", len(content) + len(packed)) + content + packed
    )
    tracemalloc.start()
    try:
        assert main(["recover", str(path)]) == 1
        assert tracemalloc.get_traced_memory()[1] < 20_000_000
    finally:
        tracemalloc.stop()


def test_a_pipe_is_no_recording(tmp_path, capsys):
    os.mkfifo(tmp_path / "run.bag.active")

    assert main(["recover", str(tmp_path / "run.bag.active")]) == 1
    assert "expected a regular file, found a pipe" in capsys.readouterr().err
