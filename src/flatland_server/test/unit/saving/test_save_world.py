"""The service /save_world: what it writes into world files, and what it refuses."""

import errno
import os
import random

import pytest
from edited_world import BOX, Server

from flatland_server.exceptions import FlatlandError, StateError
from flatland_server.geometry import Pose
from flatland_server.simulation.world import World

WORLD = """\
# A test world.
properties: {}   # none
layers:
- name: walls    # a list without an indentation
models:
    # The first.
    - name: a
      model: box.yaml            # a box
      pose: [ $eval 1 + 1,  2.50, 0 ]

    # The second.
    - name: b
      model: "box.yaml"
    - {name: c,  model: box.yaml, pose: [5, 5, 0]}   # in one line
# The end.
"""
TO_A = "    - name: a\n      model: box.yaml            # a box\n"
TO_B = '    - name: b\n      model: "box.yaml"\n'


@pytest.fixture
def server(files):
    return Server(files, WORLD)


def test_only_the_numbers_that_differ_are_written(server):
    server.move("a", 2.0, 3.12345678, 0.0)
    server.move("b", 5.0, 0.0, 1.0)
    server.move("c", -1.0, 5.0, -0.0)
    assert server.edits.count == 3

    message = server.save()

    expected = WORLD.replace("2.50", "3.1235").replace("[5, 5, 0]", "[-1.0, 5, 0]")
    expected = expected.replace(TO_B, f"{TO_B}      pose: [5.0, 0.0, 1.0]\n")
    assert server.text == expected
    assert message == f"3 changed models saved in {server.path}"
    assert server.edits.count == 0
    assert server.opened == [str(server.path)]


def test_saving_models_keeps_comments_and_other_entries(server):
    server.delete("b")
    server.delete("a")
    server.spawn("robot", 1.0, 2.0, ns="~r1")
    server.spawn("no", 1.0, 3.0)
    server.move("no", 1.0, 4.0)

    server.save()

    expected = WORLD.replace(TO_A, "").replace("      pose: [ $eval 1 + 1,  2.50, 0 ]\n", "")
    expected = expected.replace(TO_B, "").replace(
        "# The end.",
        "    - {name: robot, namespace: ~r1, model: box.yaml, pose: [1.0, 2.0, 0.0]}\n"
        '    - {name: "no", model: box.yaml, pose: [1.0, 4.0, 0.0]}\n'
        "# The end.",
    )
    assert server.text == expected


def test_a_saved_world_is_the_one_that_a_reset_and_a_reload_make(server):
    server.delete("a")
    server.spawn("d", 7.0, 8.0)
    server.move("c", 1.0, 1.0)
    server.save()
    saved = server.poses()
    server.move("c", 2.0, 2.0)

    server.reset()

    assert server.poses() == saved
    assert server.edits.count == 0
    server.manager.reload(server.world.read_config())
    assert server.poses() == saved
    assert list(saved) == ["b", "c", "d"]


def test_an_edit_that_is_undone_is_no_change(server):
    server.move("a", 0.0, 0.0)
    server.delete("b")
    server.spawn("d", 0.0, 0.0)
    assert server.edits.count == 3

    server.move("a", 2.0, 2.5)
    server.spawn("b", 0.0, 0.0)
    server.delete("d")
    assert server.edits.count == 0

    server.delete("b")
    server.spawn("b", 0.0, 0.0, ns="other")
    assert server.edits.count == 1
    server.reset()
    assert server.edits.count == 0


def test_motion_of_a_robot_is_no_edit(server):
    server.world.models["a"].move(Pose(1.0, 1.0, 0.0))
    server.world.spawn_model("box.yaml", "of_a_plugin", "", Pose())

    assert server.edits.count == 0
    server.save()
    assert server.text == WORLD


@pytest.mark.parametrize(
    ("models", "expected"),
    [
        ("", "models:\n  - name: d\n    model: box.yaml\n    pose: [1.0, 2.0, 0.0]\n"),
        ("models: []  # none\n", "models: \n  - name: d\n"),
        ("models: [{name: e, model: box.yaml}]  # few\n", "box.yaml}, {name: d, "),
        ("models:\n- name: e\n  model: box.yaml", "\n- name: d\n  model: box.yaml\n  pose: "),
    ],
)
def test_a_model_is_added_to_lists_of_any_form(files, models, expected):
    server = Server(files, f"properties: {{}}\nlayers: []\n{models}")
    server.spawn("d", 1.0, 2.0)

    server.save()

    assert server.text.startswith("properties: {}\nlayers: []\nmodels:")
    assert expected in server.text
    assert server.world.read_config().models[-1].name == "d"


@pytest.mark.parametrize(
    "models",
    ["models:  # two\n- {name: e, model: box.yaml}\n", "models: [{name: e, model: box.yaml}]"],
)
def test_all_models_may_go(files, models):
    server = Server(files, f"properties: {{}}\nlayers: []\n{models}")
    server.delete("e")

    server.save()

    assert "models: []" in server.text


def test_a_file_of_windows_and_one_line_of_json_keep_their_form(files):
    server = Server(files, '{"properties": {}, "layers": []}')
    server.spawn("d", 1.0, 2.0)
    server.save()
    assert len(server.world.read_config().models) == 1
    text = "properties: {}\r\nlayers: []\r\nmodels:\r\n- name: e\r\n  model: box.yaml\r\n"
    server.path.write_bytes(b"\xef\xbb\xbf" + text.encode())
    server.manager.reload(server.world.read_config())
    server.move("e", 1.0, 2.0)

    server.save()

    expected = b"\xef\xbb\xbf" + text.encode() + b"  pose: [1.0, 2.0, 0.0]\r\n"
    assert server.path.read_bytes() == expected


@pytest.mark.parametrize(
    ("pose", "saved"), [("[5, 5, 0]", "[5, 6.0, 0]"), ("[7, 5, 1]", "[5.0, 6.0, 0.0]")]
)
def test_an_edit_in_the_file_since_it_was_read_is_kept_but_for_poses(server, pose, saved):
    edited = WORLD.replace("# The end.", "# Mine.")
    server.path.write_text(edited.replace("[5, 5, 0]", pose))
    server.move("c", 5.0, 6.0)

    server.save()

    assert server.text == edited.replace("[5, 5, 0]", saved)


@pytest.mark.parametrize(
    ("models", "error"),
    [
        ("models: $include more.yaml", 'more.yaml:1: the model "e" is written here'),
        ("models:\n- $[include] each.yaml", 'each.yaml:1: the model "e" is written here'),
        (
            "models: [{name: e, model: box.yaml, pose: &p [0, 0, 0]}, "
            "{name: f, model: box.yaml, pose: *p}]",
            "cannot be changed without changing others",
        ),
    ],
)
def test_models_that_cannot_be_changed_alone_are_not_saved(files, models, error):
    files.write("more.yaml", "[{name: e, model: box.yaml}]\n")
    files.write("each.yaml", "{name: e, model: box.yaml}\n")
    server = Server(files, f"properties: {{}}\nlayers: []\n{models}\n")
    before = {path.name: path.read_bytes() for path in server.path.parent.iterdir()}
    server.delete("e")

    with pytest.raises(FlatlandError, match=error):
        server.save()

    assert {path.name: path.read_bytes() for path in server.path.parent.iterdir()} == before
    assert server.edits.count == 1


def test_a_copy_in_another_folder_finds_its_files(files, tmp_path):
    files.write("more.yaml", "{name: e, model: box.yaml}\n")
    walls = files.walls("room", "0 0 1 1")
    text = (
        f"properties: {{}}\nlayers: [{{name: walls, map: {walls}}}]\n"
        "models: [{name: a, model: box.yaml}, $include more.yaml]\n"
    )
    server = Server(files, text)
    server.spawn("d", 1.0, 2.0)
    copy = tmp_path / "my worlds" / "copy.yaml"
    copy.parent.mkdir()

    server.save(copy)

    assert server.text == text
    again = server.world.read_config()
    assert again.path == copy
    assert [entry.name for entry in again.models] == ["a", "e", "d"]
    assert server.opened == [str(copy)]
    server.move("d", 2.0, 2.0)
    server.save()
    assert "[2.0, 2.0, 0.0]" in copy.read_text()


def test_a_client_writes_worlds_alone(server, files, tmp_path):
    (tmp_path / "folder.yaml").mkdir()
    for path, error in (
        ("world.yaml", "expected an absolute path"),
        (tmp_path / "folder.yaml", "expected a new file or a world, found something else"),
        (tmp_path / ".bashrc", r"expected a file \*.yaml"),
        (tmp_path / "nowhere" / "world.yaml", "cannot write .*: No such file"),
    ):
        with pytest.raises(FlatlandError, match=error):
            server.save(path)
    kept = tmp_path / "kept"
    kept.mkdir()
    fenced = Server(files, WORLD, state_folder=kept)
    with pytest.raises(FlatlandError, match="in the folders that the server's ~state_folder"):
        fenced.save()
    fenced.save(kept / "mine.yaml")
    assert fenced.world.config.path == kept / "mine.yaml"


def test_a_shipped_world_is_saved_only_if_it_is_named(server, monkeypatch):
    shipped = {"ours": server.path}
    monkeypatch.setattr("flatland_server.config.worlds.shipped_worlds", lambda: shipped)
    with pytest.raises(FlatlandError, match="one of Flatland's own; save a copy"):
        server.save()
    assert server.save(server.path) == f"0 changed models saved in {server.path}"


@pytest.mark.parametrize(
    "text",
    [
        "site_name: Docs\nplugins:\n  - search\n",
        "services: {}\nlayers: [a]\n",
        "costmap:\n  plugins:\n  - {name: static_layer, type: 'costmap_2d::StaticLayer'}\n",
        BOX,
        "properties: {}\nlayers: []\nother: 1\n",
        "properties: {}\nlayers: [\n",
    ],
)
def test_a_file_that_is_no_world_is_not_replaced(server, tmp_path, text):
    foreign = tmp_path / "foreign.yaml"
    foreign.write_text(text)
    server.move("c", 5.0, 6.0)

    with pytest.raises(FlatlandError, match="expected a new file or a world, found something else"):
        server.save(foreign)

    assert foreign.read_text() == text


def test_another_world_is_replaced(server, tmp_path):
    other = tmp_path / "other.yaml"
    other.write_text("properties: {}\nlayers: []\n")

    server.save(other)

    assert other.read_text() == WORLD


@pytest.mark.parametrize("is_own", [True, False])
def test_no_link_is_followed_or_replaced(server, tmp_path, is_own):
    real = tmp_path / "real.yaml"
    link = server.path if is_own else tmp_path / "link.yaml"
    server.path.rename(real) if is_own else real.write_text(WORLD)
    link.symlink_to(real)
    server.move("c", 5.0, 6.0)

    with pytest.raises(FlatlandError, match="expected a new file or a world, found a link"):
        server.save("" if is_own else link)

    assert link.is_symlink()
    assert real.read_text() == WORLD


def test_permissions_and_owner_stay(server):
    server.path.chmod(0o640)
    if os.geteuid() == 0:
        os.chown(server.path, 1234, 1235)
    before = server.path.stat()
    server.move("c", 5.0, 6.0)

    server.save()

    now = server.path.stat()
    assert (now.st_mode, now.st_uid, now.st_gid) == (before.st_mode, before.st_uid, before.st_gid)


def test_a_full_disk_leaves_the_former_file(server, monkeypatch):
    server.move("c", 5.0, 6.0)

    def fail(descriptor):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "fsync", fail)
    with pytest.raises(FlatlandError, match=r"cannot write .*: No space left on device"):
        server.save()

    assert server.text == WORLD
    assert not list(server.path.parent.glob(".*"))
    assert server.edits.count == 1


def test_states_and_history_include_the_edits_of_clients(server, tmp_path):
    state = str(tmp_path / "state")
    server.manager.keep_history(interval=0.01)
    server.move("a", 1.0, 1.0)
    server.delete("b")
    server.spawn("x", 1.0, 2.0)
    server.manager.step(5)
    server.call("save_state", path=state)
    for name in ("a", "x"):
        server.delete(name)
    server.manager.step(5)

    server.call("seek", time=0.05)

    assert server.edits.count == 3
    server.reset()
    assert server.edits.count == 0
    server.call("load_state", path=state)
    assert server.edits.count == 3
    server.save()
    assert [entry.name for entry in server.world.read_config().models] == ["a", "c", "x"]


def test_a_state_is_not_loaded_into_a_model_of_another_namespace(server, tmp_path):
    server.call("save_state", path=str(tmp_path / "state"))
    server.delete("c")
    server.spawn("c", 5.0, 5.0, ns="~r2")
    server.save()

    with pytest.raises(StateError, match=r"expected the models a, b, c \(~r2\); found a, b, c$"):
        server.call("load_state", path=str(tmp_path / "state"))


@pytest.mark.parametrize(
    ("change", "error"),
    [
        ("    - {name: x, model: box.yaml}", 'the name "x" is given twice'),
        ("    - {name: y, model: box.yaml}", "expected a, b, c, x; found a, b, c, y, x"),
        ("other: 1", r'world.yaml:\d+: .*unknown key "other"'),
    ],
)
def test_saving_does_not_lose_models_changed_in_the_file(server, change, error):
    server.spawn("x", 1.0, 2.0)
    text = WORLD.replace("# The end.", f"{change}\n# The end.")
    server.path.write_text(text)

    with pytest.raises(FlatlandError, match=error):
        server.save()

    assert server.text == text
    assert server.edits.count == 1


def test_a_model_without_its_file_is_not_saved(server, files):
    path = files.write("gone.yaml", BOX)
    server.spawn("x", 1.0, 2.0, path=str(path))
    path.unlink()

    with pytest.raises(FlatlandError, match=r"world.yaml:.* models\[3\].model: .*gone.yaml"):
        server.save()

    assert server.text == WORLD


def test_inline_models_are_saved_in_copies_of_copies(files, tmp_path):
    text = f"properties: {{}}\nlayers: []\nmodels:\n- {{name: a, model: {{{BOX.strip()}}}}}\n"
    server = Server(files, text)
    for number in range(3):
        folder = tmp_path / f"copy {number}"
        folder.mkdir()
        server.move("a", number, 1.0)
        server.save(folder / "world.yaml")
        assert server.edits.count == 0

    assert server.world.read_config().models[0].pose == Pose(2.0, 1.0, 0.0)


class RandomUser:
    """Calls services at random, and notes the models that the world must have."""

    def __init__(self, server, folder, seed):
        self.server, self.folder = server, folder
        self.rng = random.Random(seed)
        self.present, self.filed = {}, {}
        self.states = {}
        self.forget(server.poses())

    def forget(self, poses):
        self.present = {name: ("", tuple(pose)) for name, pose in poses.items()}
        self.filed = dict(self.present)

    def pose(self):
        return tuple(round(self.rng.uniform(-5, 5), 2) for _ in range(2))

    def spawn(self):
        free = [name for name in "abcdefg" if name not in self.present]
        if free:
            name, ns, pose = self.rng.choice(free), self.rng.choice(["", "~r2", "ns"]), self.pose()
            path = self.rng.choice(["box.yaml", "more/box.yaml"])
            self.server.spawn(name, *pose, path=path, ns=ns)
            self.present[name] = (ns.lstrip("~"), (*pose, 0.0))

    def some(self):
        return self.rng.choice(sorted(self.present)) if self.present else None

    def delete(self):
        name = self.some()
        if name is not None:
            self.server.delete(name)
            del self.present[name]

    def move(self):
        name = self.some()
        if name is not None:
            pose = self.pose()
            self.server.move(name, *pose)
            self.present[name] = (self.present[name][0], (*pose, 0.0))

    def save_state(self):
        name = str(self.folder / self.rng.choice("12"))
        self.server.call("save_state", path=name)
        self.states[name] = dict(self.present)

    def load_state(self):
        if not self.states:
            return
        name = self.rng.choice(sorted(self.states))
        try:
            self.server.call("load_state", path=name)
        except StateError as error:  # a model that came with the file is not in it any more
            if "the state is of another world" not in str(error):
                raise
        else:
            self.present = dict(self.states[name])

    def reset(self):
        self.server.reset()
        self.present = dict(self.filed)

    def reload(self):
        self.server.call("reload_world")
        self.present = dict(self.filed)

    def seek(self):
        """Goes back to before a change."""
        self.server.manager.step(2)
        before, time = dict(self.present), self.server.manager.time
        self.rng.choice([self.spawn, self.delete, self.move])()
        self.server.manager.step(2)
        self.server.call("seek", time=time)
        self.present = before

    def save(self):
        server = self.server
        server.save()
        assert server.edits.count == 0
        self.filed = dict(self.present)
        loaded = World(server.world.read_config(), loader=server.world._loader)
        assert {
            name: (model.namespace, pytest.approx(tuple(model.pose), abs=1e-4))
            for name, model in loaded.models.items()
        } == self.present
        kinds = [
            {name: (model.namespace, model.config.path) for name, model in world.models.items()}
            for world in (loaded, server.world)
        ]
        assert kinds[0] == kinds[1]

    def do(self, count):
        actions = [self.spawn, self.spawn, self.delete, self.move, self.save, self.save_state]
        actions += [self.load_state, self.reset, self.reload, self.seek]
        for _ in range(count):
            self.rng.choice(actions)()
            assert set(self.server.world.models) == set(self.present)
        self.save()


@pytest.mark.parametrize("seed", range(8))
def test_a_saved_file_has_the_models_after_random_edits(files, tmp_path, seed):
    (files.folder / "more").mkdir()
    files.write("more/box.yaml", BOX)
    server = Server(files, WORLD)
    server.manager.keep_history(interval=0.01)

    RandomUser(server, tmp_path, seed).do(60)


@pytest.mark.parametrize(
    "models",
    [
        "\n".join(["", *(f"  - name: {name}\n    model: box.yaml" for name in "abcd")]),
        f" [{', '.join(f'{{name: {name}, model: box.yaml}}' for name in 'abcd')}]",
    ],
    ids=["block", "flow"],
)
@pytest.mark.parametrize("deleted", ["a", "ab", "bc", "d", "ad"])
def test_a_copy_in_another_folder_lacks_deleted_models(files, tmp_path, models, deleted):
    server = Server(files, f"properties: {{}}\nlayers: [{{name: walls}}]\nmodels:{models}\n")
    for name in deleted:
        server.delete(name)
    server.spawn("new", 1.0, 2.0)
    copies = tmp_path / "copies"
    copies.mkdir()

    server.save(copies / "world.yaml")

    kept = [name for name in "abcd" if name not in deleted]
    config = server.world.read_config()
    assert config.path == copies / "world.yaml"
    assert [entry.name for entry in config.models] == [*kept, "new"]
