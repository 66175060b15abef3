"""Sensors that are read return the content of their messages of the same time."""

import numpy as np
import pytest
import yaml

from flatland2d import Simulation, UsageError
from flatland_server import quaternion
from flatland_server.testing import WorldFiles

DISC = {"type": "circle", "radius": 0.2, "density": 5}
PLUGINS = yaml.safe_load("""
drive: {type: DiffDrive, body: base, odom_pose_noise: [.1, .1, .1], odom_twist_noise: [.1, .1, .1],
  odom_drift: {translation_per_metre: 0.01, rotation_per_radian: 0.01}}
laser: {type: Laser, body: base, range: 9, noise_std_dev: 0.1,
  angle: {min: -1, max: 1, increment: 0.5}}
imu: {type: Imu, body: base, orientation_noise: [.1, .1, .1], angular_velocity_noise: [.1, .1, .1],
  linear_acceleration_noise: [.1, .1, .1]}
gps: {type: Gps, body: base, ref_lat: 50, update_rate: inf}
bumper: {type: Bumper}
touch: {type: BoolSensor}
""")


@pytest.fixture
def load(tmp_path):
    """Loads a robot that drives into a box and then, with it, into a wall."""
    files = WorldFiles(tmp_path)
    files.walls("map", "1.2 -3 1.2 3")

    def load(topics=(), plugins=PLUGINS, **options):
        entries = [{"name": name, **entry} for name, entry in plugins.items()]
        robot = {"bodies": [{"name": "base", "footprints": [DISC]}], "plugins": entries}
        world = {
            "properties": {},
            "layers": [{"name": "map", "map": tmp_path / "map.yaml"}, {"name": "reflectance"}],
            "models": [
                {"name": "robot", "model": robot},
                {"name": "box", "pose": [0.6, 0.1, 0], "model": {"bodies": robot["bodies"]}},
            ],
        }
        sim = Simulation(world, topics=topics, loader=files.loader, **options)
        sim.models["robot"].command(0.8, 0.1)
        return sim

    return load


def of_scan(message):
    return np.array(message.ranges, np.float32).tolist()


def of_odometry(message):
    pose, twist = message.pose.pose, message.twist.twist
    at, turn = pose.position, pose.orientation
    return (at.x, at.y, turn.z, turn.w), (twist.linear.x, twist.linear.y, twist.angular.z)


def as_odometry(reading):
    x, y, yaw = reading.pose
    return (x, y, *quaternion(yaw)[2:]), tuple(reading.velocity)


def of_imu(message):
    return [
        tuple(getattr(vector, axis) for axis in vector.__slots__)
        for vector in (message.orientation, message.angular_velocity, message.linear_acceleration)
    ]


def as_imu(reading):
    roll, pitch, yaw = reading.orientation
    turn = quaternion(yaw, roll, pitch)
    return [turn, reading.angular_velocity, reading.linear_acceleration]


def of_fix(message):
    return (message.latitude, message.longitude, message.altitude)


def of_collisions(message):
    points = [[(point.x, point.y) for point in c.contact_positions] for c in message.collisions]
    return [
        (each.body_A, each.entity_B, each.body_B, tuple(at), tuple(each.magnitude_forces))
        for each, at in zip(message.collisions, points)
    ]


def as_collisions(bumps):
    return [(b.body, b.other_model, b.other_body, b.points, b.forces) for b in bumps]


def list_of(array):
    return array.tolist()


BEFORE = [  # published at the begin of a step
    ("laser", "", "/scan", of_scan, list_of),
    ("drive", "", "/odometry/filtered", of_odometry, as_odometry),
    ("drive", "ground_truth", "/odometry/ground_truth", of_odometry, as_odometry),
    ("gps", "", "/gps/fix", of_fix, tuple),
]
AFTER = [  # published at its end
    ("imu", "", "/imu/filtered", of_imu, as_imu),
    ("imu", "ground_truth", "/imu/ground_truth", of_imu, as_imu),
    ("bumper", "", "/collisions", of_collisions, as_collisions),
    ("touch", "", "/bool_sensor", lambda message: message.data, bool),
]
CASES = [(*case, 1) for case in BEFORE] + [(*case, 0) for case in AFTER]
IDS = [topic for _, _, topic, _, _, _ in CASES]


@pytest.mark.parametrize(("name", "quantity", "topic", "of", "shaped", "lag"), CASES, ids=IDS)
def test_a_reading_is_the_message_of_its_time(load, name, quantity, topic, of, shaped, lag):
    sim = load([topic])
    sensor = sim.models["robot"].sensors[name]
    readings, messages = [], []

    for _ in range(300):
        sim.step()
        readings.append(shaped(sensor.read(quantity)))
        messages.append(of(sim.last(topic)))

    assert readings[: len(readings) - lag] == messages[lag:]
    assert any(reading != readings[0] for reading in readings)


@pytest.mark.parametrize("name", PLUGINS)
def test_readings_go_on_from_a_saved_state(load, name):
    sim = load(topics=["/imu/filtered"]).step(203)
    state = sim.save_state()
    expected = [repr(sim.models["robot"].sensors[name].read())]
    expected += [repr(sim.step().models["robot"].sensors[name].read()) for _ in range(50)]

    sim.load_state(state)

    sensor = sim.models["robot"].sensors[name]
    assert repr(sensor.read()) == repr(sensor.read()) == expected[0]
    assert [repr(sim.step() and sensor.read()) for _ in range(50)] == expected[1:]


@pytest.mark.parametrize("name", PLUGINS)
def test_arrays_and_lists_that_were_read_are_the_callers(load, name):
    sim = load().step(203)
    sensor = sim.models["robot"].sensors[name]

    first, before = sensor.read(), repr(sensor.read())
    if isinstance(first, np.ndarray):
        first[:] = 0.0
    elif isinstance(first, list):
        first.clear()

    assert repr(sensor.read()) == before


def test_a_laser_gives_ranges_as_floats_and_intensities(load):
    laser = load().models["robot"].sensors["laser"]

    assert laser.quantities == ("intensities",)
    assert (laser.read().dtype, laser.read().shape) == (np.float32, (5,))
    assert set(laser.read("intensities").tolist()) == {0.0, 255.0}  # the box is on all layers


def test_the_acceleration_is_the_mean_since_the_last_reading(load):
    limits = {"acceleration_limit": 0.5}
    drive = {"type": "DiffDrive", "body": "base", "linear_dynamics": limits}
    sim = load(plugins={"drive": drive, "imu": {"type": "Imu", "body": "base"}})
    imu = sim.models["robot"].sensors["imu"]
    assert imu.read().linear_acceleration == (0.0, 0.0, 9.80665)

    for count in (1, 7, 20):
        before = sim.models["robot"].velocity.vx
        sim.step(count)
        ax, _, _ = imu.read().linear_acceleration
        gained = sim.models["robot"].velocity.vx - before
        assert ax == pytest.approx(gained / (count * 0.005), rel=1e-3)
        assert imu.read().linear_acceleration[0] == ax
    sim.move("robot", [-1, 0, 0])
    sim.step()
    assert imu.read().linear_acceleration == (0.0, 0.0, 9.80665)


def test_a_bumper_forgets_what_was_deleted(load):
    sim = load()
    bumper = sim.models["robot"].sensors["bumper"]
    while not bumper.read():
        sim.step()
    assert bumper.read()[0].other_model == "box"

    sim.delete("box")

    assert bumper.read() == []


def test_a_sensor_has_the_facts_of_its_messages(load):
    upside_down = {**PLUGINS["laser"], "upside_down": True, "update_rate": 8, "frame": "eye"}
    sim = load(plugins={**PLUGINS, "laser": upside_down})
    sensors, scan = sim.models["robot"].sensors, sim.last("/scan")

    laser = sensors["laser"]
    assert laser.angles == pytest.approx(
        scan.angle_min + scan.angle_increment * np.arange(len(scan.ranges))
    )
    assert (laser.range_max, laser.frame_id) == (scan.range_max, scan.header.frame_id)
    assert laser.period == pytest.approx(scan.scan_time)
    assert sensors["imu"].frame_id == sim.last("/imu/filtered").header.frame_id
    assert sensors["gps"].frame_id == sim.last("/gps/fix").header.frame_id
    assert sensors["gps"].period == 0.0
    with pytest.raises(UsageError, match='the sensor "robot/bumper", a Bumper, has no angles'):
        sensors["bumper"].angles  # noqa: B018
