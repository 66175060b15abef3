"""SimulationBatch(vary=...): an environment has the bits of a file with its value."""

import copy
from fnmatch import fnmatchcase

import numpy as np
import pytest
from batch_world import write_world

from flatland2d import FlatlandError, Simulation, SimulationBatch, StateError, Walls, world_content

ROUNDS, SUBSTEPS = 12, 20
DRIVE = {
    "robot/drive/linear_dynamics/acceleration_limit": (0.5, 4.0),
    "robot/drive/linear_dynamics/velocity_limit": (0.2, 1.0),
    "robot/drive/angular_dynamics/velocity_limit": (0.2, 1.0),
    "robot/drive/actuators/delay": (0.0, 0.3),
    "robot/drive/actuators/time_constant": (0.0, 0.3),
    "robot/drive/actuators/linear/noise": (0.0, 0.02),
}
NAMES = {
    "DiffDrive": {
        **DRIVE,
        "robot/drive/linear_dynamics/deceleration_limit": (0.5, 4.0),
        "robot/drive/angular_dynamics/acceleration_limit": (0.5, 4.0),
        "robot/drive/actuators/angular/noise": (0.0, 0.02),
        "robot/drive/actuators/linear/dead_band": (0.0, 1.5),
        "robot/drive/actuators/command_timeout": (0.02, 0.1),
        "robot/drive/actuators/max_force": (1.0, 20.0),
        "robot/drive/actuators/max_torque": (0.01, 0.5),
        "robot/drive/actuators/traction/friction": (0.1, 0.6),
        "robot/laser/range": (1.0, 6.0),
        "robot/laser/range_min": (0.0, 1.0),
        "robot/laser/noise_std_dev": (0.0, 0.1),
        "robot/laser/origin/0": (0.0, 0.2),
        "robot/base/linear_damping": (0.0, 4.0),
        "robot/base/footprints/density": (2.0, 9.0),
        "robot/base/footprints/0/friction": (0.0, 1.0),
        "box*/base/footprints/density": (1.0, 9.0),
        "box*/base/footprints/friction": (0.0, 1.0),
        "box2/base/footprints/restitution": (0.0, 1.0),
        "box2/base/linear_damping": (0.0, 4.0),
        "box2/base/angular_damping": (0.0, 4.0),
    },
    "OmniDrive": DRIVE,
    "TricycleDrive": {**DRIVE, "robot/drive/max_steer_angle": (0.1, 0.7)},
    "AckermannDrive": {
        **DRIVE,
        "robot/drive/max_steer_angle": (0.1, 0.5),
        "robot/drive/jerk_limit": (2.0, 20.0),
        "robot/drive/single_track/friction": (0.2, 1.0),
        "robot/drive/single_track/front_stiffness": (2.0, 6.0),
    },
}
CASES = [(drive, name) for drive, names in NAMES.items() for name in names]


@pytest.fixture(scope="module")
def worlds(tmp_path_factory):
    return {
        drive: world_content(write_world(tmp_path_factory.mktemp(drive), drive=drive, noise="0.01"))
        for drive in NAMES
    }


def with_value(content, name, value):
    """The world with a value in its files."""
    content = copy.deepcopy(content)
    pattern, entry, *keys, last = name.split("/")
    for model in content["models"]:
        if not fnmatchcase(model["name"], pattern):
            continue
        parts = model["model"]
        [place] = [e for e in parts["bodies"] + parts.get("plugins", []) if e["name"] == entry]
        for key in keys:
            place = place[int(key)] if key.isdigit() else place.setdefault(key, {})
        for each in place if isinstance(place, list) and not last.isdigit() else [place]:
            each[int(last) if last.isdigit() else last] = value
    return content


def commands(size):
    rng = np.random.default_rng(4)
    return rng.uniform([0.5, -1.0, -1.0][:size], [2.0, 1.0, 1.0][:size], (ROUNDS, size))


def run_simulation(content, size):
    with Simulation(content, seed=7) as simulation:
        robot, rows = simulation.models["robot"], []
        for command in commands(size):
            robot.command(*command)
            simulation.step(SUBSTEPS)
            rows.append([robot.sensors["laser"].read(), simulation.poses, simulation.velocities])
    return [np.stack(each) for each in zip(*rows)]


def run_batch(batch):
    rows = []
    for command in commands(len(batch.action_names)):
        seen = batch.step(np.tile(command, (batch.num_envs, 1)), SUBSTEPS)
        rows.append([seen.ranges, *batch.model_motions()])
    return [np.stack(each, axis=1) for each in zip(*rows)]


def assert_varies(content, name, values):
    """Fails unless environments with three values of a number are simulations with them."""
    vary = {name: (values[0], values[-1])}
    with SimulationBatch(content, 3, seed=[7, 7, 7], vary=vary) as batch:
        batch.reset(vary={name: values[::-1]})
        run_batch(batch)
        batch.reset(vary={name: values})
        found = run_batch(batch)
        size = len(batch.action_names)
    for k, value in enumerate(values):
        expected = run_simulation(with_value(content, name, value), size)
        for seen, reference in zip(found, expected):
            assert np.array_equal(seen[k].reshape(reference.shape), reference), value
    assert any(not np.array_equal(seen[0], seen[2]) for seen in found)  # it has an effect


@pytest.mark.parametrize(("drive", "name"), CASES)
def test_an_environment_has_the_bits_of_a_file_with_its_value(worlds, drive, name):
    least, greatest = NAMES[drive][name]
    assert_varies(worlds[drive], name, [least, 0.3 * least + 0.7 * greatest, greatest])


@pytest.mark.parametrize(
    ("name", "range", "expected"),
    [
        ("robot/lasr/range", (1, 2), 'did you mean "laser"'),
        ("robots/laser/range", (1, 2), 'did you mean "robot"'),
        ("robot/laser/rang", (1, 2), 'did you mean "range'),
        ("robot/laser", (1, 2), "MODEL/PLUGIN/KEY"),
        ("robot/laser/range", (0, 2), "above 0, found 0"),
        ("robot/laser/range", (2, 1), "least, greatest"),
        ("robot/laser/range", (float("nan"), 1), "least, greatest"),
        ("robot/laser/range", 3, "least, greatest"),
        ("robot/laser/range", "12", "least, greatest"),
        ("robot/laser/range", (1, 10**400), "least, greatest"),
        ("robot/laser/range_min", (1, 7), "expected less than the range"),
        ("robot/laser/name/first", (1, 2), "leads to no number"),
        ("box*/base/footprints/density", (-1, 2), "of 0 or more, found -1"),
        ("robot/base/footprints/²/friction", (0, 1), 'unknown key "²"'),
        ("robot/laser/update_rate", (1, 2), "cannot differ"),
        ("robot/laser/angle/increment", (0.04, 0.05), "cannot differ"),
        ("robot/base/footprints/radius", (0.1, 0.2), "cannot differ"),
        ("robot/drive/actuators/max_force", (0, 9), "cannot differ"),  # 0 is no limit
    ],
)
def test_a_wrong_range_is_refused(worlds, name, range, expected):
    with pytest.raises(FlatlandError, match=expected):
        SimulationBatch(worlds["DiffDrive"], 2, vary={name: range})


def test_a_limit_of_force_from_none_is_refused_without_contacts():
    with pytest.raises(FlatlandError, match="cannot differ"):
        SimulationBatch("office", 2, vary={"turtlebot/diff_drive/actuators/max_force": (0, 1e6)})


def test_noise_from_none_varies_beside_other_numbers_of_a_drive(worlds):
    content = with_value(worlds["OmniDrive"], "robot/drive/actuators/delay", 0.1)
    assert_varies(content, "robot/drive/actuators/linear/noise", [0.0, 0.01, 0.02])


def test_the_last_name_of_a_number_counts(worlds):
    boxes = {"box*/base/footprints/density": (1, 2), "box2/base/footprints/density": (1, 3)}
    SimulationBatch(worlds["DiffDrive"], 2, vary=boxes).close()
    with pytest.raises(FlatlandError, match="cannot differ"):
        SimulationBatch(worlds["DiffDrive"], 2, vary=dict(reversed(boxes.items())))


RANGE, SPEED = "robot/laser/range", "robot/drive/linear_dynamics/velocity_limit"
DENSITY = "robot/base/footprints/density"
VARY = {RANGE: (1.0, 6.0), SPEED: (0.2, 1.0), DENSITY: (2.0, 9.0)}


@pytest.fixture
def batch(worlds):
    with SimulationBatch(worlds["DiffDrive"], 3, seed=[7, 7, 7], vary=VARY) as batch:
        yield batch


@pytest.mark.parametrize(
    ("vary", "expected"),
    [
        ({"robot/laser/rang": 3}, "did you mean"),
        ({RANGE: 7}, "from 1 to 6, found 7"),
        ({RANGE: [1, 2, float("nan")]}, "found nan"),
        ({RANGE: [1, 2]}, "as a number, or 3 of them"),
        ({RANGE: "far"}, "as a number, or 3 of them"),
        ({RANGE: "3"}, "as a number, or 3 of them"),
        ({RANGE: [1, 2, 10**400]}, "as a number, or 3 of them"),
    ],
)
def test_a_wrong_value_changes_nothing(batch, vary, expected):
    batch.reset(vary={RANGE: 2.0})
    former = batch.observe()
    with pytest.raises(FlatlandError, match=expected):
        batch.reset(vary={SPEED: 0.5, **vary})
    assert all(np.array_equal(a, b) for a, b in zip(batch.observe(), former))
    assert np.isfinite(batch.reset().ranges).any(axis=1).all()


def test_wrong_walls_leave_the_values_as_they_are(worlds):
    bare = {**worlds["DiffDrive"], "layers": []}
    with SimulationBatch(bare, 2, vary={RANGE: (1.0, 6.0)}) as batch:
        batch.reset(vary={RANGE: 2.0})
        states = batch.save_states()
        for walls, expected in ({7: None}, "from 0 to 1"), ({0: Walls([[0, 1, 1, 1]])}, "no layer"):
            with pytest.raises(FlatlandError, match=expected):
                batch.reset(walls=walls, vary={RANGE: 6.0})
            assert batch.save_states() == states
        with pytest.raises(FlatlandError, match="vary as a dict"):
            batch.reset(vary=3)


def test_only_environments_that_are_reset_change(batch):
    batch.reset(vary={RANGE: [1.5, 2.0, 2.5]})
    batch.reset(np.array([False, True, False]), vary={RANGE: [np.nan, 3.0, np.nan]})
    reach = np.where(np.isfinite(batch.observe().ranges), batch.observe().ranges, 0.0).max(axis=1)
    assert (np.array([1.5, 3.0, 2.5]) >= reach).all()
    assert reach[1] > 2.5


def test_a_state_has_its_values(batch, worlds):
    batch.reset(vary={RANGE: [2.0, 3.0, 4.0], SPEED: [0.3, 0.6, 0.9], DENSITY: [3, 5, 8]})
    batch.step(np.full((3, 2), 0.7), 50)
    states = batch.save_states()
    expected = run_batch(batch)
    batch.reset(vary={RANGE: 6.0, SPEED: 1.0, DENSITY: 2.0})
    batch.load_states(states[::-1])
    for a, b in zip(run_batch(batch), expected):
        assert np.array_equal(a[::-1], b)
    with Simulation(worlds["DiffDrive"]) as simulation:
        with pytest.raises(StateError, match="values of its own"):
            simulation.load_state(states[0])
        plain = simulation.save_state()
    batch.reset(vary={RANGE: 2.0})
    reached = batch.load_states(plain).ranges  # keeps the values that there are
    assert np.where(np.isfinite(reached), reached, 0.0).max() <= 2.0


def test_a_view_has_the_values_of_its_environment(batch):
    seen = batch.reset(vary={RANGE: [1.5, 2.0, 3.0]})
    for k in (2, 0):
        view = batch.view(k).models["robot"].sensors["laser"].read()
        assert np.isfinite(view).sum() == np.isfinite(seen.ranges[k]).sum()


def test_a_batch_that_begins_in_a_state_varies_nothing(worlds):
    with Simulation(worlds["DiffDrive"]) as simulation:
        state = simulation.save_state()
    with pytest.raises(FlatlandError, match="no vary"):
        SimulationBatch(worlds["DiffDrive"], 2, state=state, vary={RANGE: (1, 2)})
