"""Files that clients of services name: what they can read, write and learn."""

import os
import socket
from pathlib import Path

import pytest

from flatland_server.exceptions import FlatlandError, StateError, YamlError
from flatland_server.hub.client_files import ClientFiles, told
from flatland_server.simulation.world import World
from flatland_server.simulation.world_config import WorldConfig
from flatland_server.simulation.world_state import read_state, write_state

STATE = b'{"flatland_state":1}'
BOX = "bodies: [{name: box, footprints: [{type: circle, radius: 1, density: 1}]}]\n"


@pytest.fixture
def world(tmp_path, loader):
    folder = tmp_path / "worlds"
    folder.mkdir()
    (folder / "world.yaml").write_text("properties: {}\nlayers: []\n")
    (folder / "box.yaml").write_text(BOX)
    return World.from_file(folder / "world.yaml", loader=loader)


@pytest.fixture
def kept(tmp_path):
    """The folder of states of a server."""
    folder = tmp_path / "states"
    folder.mkdir()
    return folder


@pytest.mark.parametrize(
    ("name", "found"),
    [
        *((name, "worlds/box.yaml") for name in ("box.yaml", "./box.yaml", "../worlds/box.yaml")),
        ("../box.yaml", "box.yaml"),
    ],
)
def test_a_relative_model_path_begins_in_the_worlds_folder(
    world, tmp_path, monkeypatch, name, found
):
    (tmp_path / "box.yaml").write_text(BOX)
    elsewhere = tmp_path / "home" / ".ros"  # the server's own folder
    elsewhere.mkdir(parents=True)
    for folder in (elsewhere, elsewhere.parent):
        (folder / "box.yaml").write_text("not a model")
    monkeypatch.chdir(elsewhere)

    assert ClientFiles(world, None).model_file(name).resolve() == tmp_path / found


def a_socket(path):
    with socket.socket(socket.AF_UNIX) as each:
        each.bind(str(path))


def a_link_to_a_state(path):
    path.with_name("target").write_bytes(STATE)
    path.symlink_to("target")


MAKE = {
    "a folder": Path.mkdir,
    "a pipe": os.mkfifo,
    "a socket": a_socket,
    "a device": lambda path: path.symlink_to("/dev/zero"),
    "somebody's file": lambda path: path.write_text("alias ll='ls -l'\n"),
    "a link to a state": a_link_to_a_state,
    "a link to nothing": lambda path: path.symlink_to("nothing"),
}


@pytest.mark.parametrize("kind", MAKE)
def test_a_state_is_written_over_nothing_but_a_state(tmp_path, kind):
    path = tmp_path / "state"
    MAKE[kind](path)
    before = path.lstat()

    with pytest.raises(StateError, match="expected a new file or a saved state"):
        write_state(path, STATE)

    assert (path.lstat().st_ino, path.lstat().st_size) == (before.st_ino, before.st_size)
    assert not (tmp_path / "nothing").exists()
    assert not list(tmp_path.glob(".*"))  # nothing is left behind


def test_a_state_replaces_a_state_with_its_permissions(tmp_path):
    path = tmp_path / "state"
    write_state(path, STATE)
    path.chmod(0o600)

    write_state(path, STATE + b" ")

    assert path.read_bytes() == STATE + b" "
    assert path.stat().st_mode & 0o777 == 0o600
    assert os.listdir(tmp_path) == ["state"]


def test_a_folder_that_cannot_be_written_is_named(tmp_path):
    with pytest.raises(StateError, match=r"cannot write .*/none/state: No such file or directory"):
        write_state(tmp_path / "none" / "state", STATE)


@pytest.mark.parametrize("kind", ["a folder", "a pipe", "a device"])
def test_a_state_is_read_from_a_regular_file_alone(tmp_path, kind):
    path = tmp_path / "state"
    MAKE[kind](path)

    with pytest.raises(StateError, match=r"/state: (expected a regular file|cannot be read)"):
        read_state(path)


def test_a_state_has_a_largest_size(tmp_path):
    path = tmp_path / "state"
    with path.open("wb") as file:
        file.truncate(65 << 20)  # takes no space

    with pytest.raises(StateError, match="expected a file of at most 64 MiB, found a larger one"):
        read_state(path)


def test_without_a_folder_of_states_a_path_is_absolute(world, tmp_path):
    files = ClientFiles(world, None)

    assert files.state(str(tmp_path / "state")) == tmp_path / "state"
    with pytest.raises(StateError, match=r"expected an absolute path .*~state_folder"):
        files.state("state")


def test_state_paths_are_confined_to_the_state_folder(world, kept, tmp_path):
    files = ClientFiles(world, kept)
    (kept / "link").symlink_to(tmp_path)

    assert files.state("night.state") == kept / "night.state"
    assert files.state(f"{kept}/night.state") == kept / "night.state"
    for name in ("../state", "link/state", str(tmp_path / "state"), "~/.bashrc", "/dev/null", "."):
        with pytest.raises(FlatlandError, match="expected a file in the folders"):
            files.state(name)


def test_with_a_state_folder_clients_name_only_the_owners_files(world, kept, tmp_path):
    files = ClientFiles(world, kept)
    foreign = tmp_path / "foreign.yaml"
    foreign.write_text(BOX)

    assert files.model_file("box.yaml") == world.config.path.parent / "box.yaml"
    office = "package://flatland_server/worlds/office/world.yaml"
    assert files.world_file(office).is_file()
    for find in (files.model_file, files.world_file):
        with pytest.raises(FlatlandError, match="expected a file in the folders"):
            find(str(foreign))
    assert ClientFiles(world, None).model_file(str(foreign)) == foreign


@pytest.mark.parametrize(
    "content",
    [
        *("root:x:0:0:secret\n", "password: secret\n", "- secret\n"),
        *("a: [secret\n", "a: *secrets\n"),
        "site_name: secret\nplugins:\n- secret\nsecret: 1\n",
        "layers: secret\nproperties: secret\n",
        "layers: [{name: secret, secret: 1}]\n",
        "costmap:\n  layers: secret\nproperties:\n  velocity_iterations: secret\n",
        "models: secret\n",
        "bodies: secret\n",
        "? [secret]\n: bodies: []\n",
    ],
)
def test_a_client_learns_nothing_from_files_of_other_kinds(world, tmp_path, content):
    path = tmp_path / "passwords"
    path.write_text(content)
    model = tmp_path / "model.yaml"
    model.write_text(f"bodies: [{{name: a, footprints: [$include {path}]}}]\n")

    for read in (world.read_model, WorldConfig.from_file):
        for file in (path, model):
            with pytest.raises(YamlError) as error:
                read(file)
            assert "secret" not in told(error.value)


def test_a_folder_costs_no_descriptor(tmp_path):
    before = os.listdir("/proc/self/fd")
    for _ in range(10):
        with pytest.raises(StateError, match="Is a directory"):
            read_state(tmp_path)

    assert len(os.listdir("/proc/self/fd")) == len(before)


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("properties: {}\nlayers: [{name: wide, color: blue}]\nmodles: []\n", "blue"),
        (BOX.replace("radius: 1", "radius: wide"), "wide"),
    ],
)
def test_a_client_is_told_all_about_worlds_and_models(world, tmp_path, text, found):
    path = tmp_path / "file.yaml"
    path.write_text(text)

    with pytest.raises(YamlError) as error:
        (world.read_model if "bodies" in text else WorldConfig.from_file)(path)

    assert told(error.value) == f"YamlError: {error.value}"
    assert f'found "{found}"' in told(error.value)


@pytest.mark.parametrize(
    "name",
    ["/" + "x" * 1_000_000, "/x" * 500_000, "/" + "x\n" * 500_000],
    ids=["a name", "folders", "lines"],
)
def test_a_long_name_makes_a_short_line_at_once(world, tmp_path, name):
    for files in (ClientFiles(world, None), ClientFiles(world, tmp_path)):
        for find in (files.state, files.world_file, files.model_file):
            with pytest.raises(FlatlandError, match=r"of at most 4096|found a text") as error:
                find(name)

            assert len(str(error.value)) < 200
