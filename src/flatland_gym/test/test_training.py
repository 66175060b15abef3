"""The learner: its gradients against differences, a short training, policies and their files."""

import math
import os
import subprocess
import sys
import zipfile
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from environments import make

from flatland2d import FlatlandError, UsageError, messages
from flatland_gym import NavigationVectorEnv, Policy, train
from flatland_gym.evaluation import evaluate
from flatland_gym.policy_node import PolicyNode
from flatland_gym.train import Network, Ppo, main

SETTINGS = {"world": "empty_room", "frame_skip": 2, "time_limit": 30.0}


@pytest.fixture(scope="module")
def policy():
    """A policy trained for a second or two."""
    env = NavigationVectorEnv(64, autoreset_mode="SameStep", **SETTINGS)
    try:
        return Ppo(env, seed=1).train(steps=60_000)
    finally:
        env.close()


@pytest.mark.slow
def test_a_policy_learns_to_reach_its_goals(policy):
    result = evaluate(policy, range(1_000_000, 1_000_100), **SETTINGS)

    assert result.success.mean() >= 0.9
    assert not (result.success & result.collision).any()
    assert result.seconds.max() <= 30.0


@pytest.mark.slow
def test_episodes_of_an_evaluation_are_independent(policy):
    all_of_them = evaluate(policy, range(20), **SETTINGS)
    some = evaluate(policy, [3, 11, 4], threads=2, **SETTINGS)

    for together, alone in zip(all_of_them, some):
        assert together[[3, 11, 4]].tolist() == alone.tolist()


@pytest.mark.slow
def test_a_policy_drives_a_robot_through_messages(policy):
    """The node succeeds as in the environment."""
    env = make(**SETTINGS)
    reached = [drive(policy, env, seed) for seed in range(10)]

    assert sum(reached) >= 9


def drive(policy, env, seed):
    """True if the node gets to the goal of an episode."""
    _, info = env.reset(seed=seed)
    sim = env.navigation.simulation(0)
    node = PolicyNode(policy, Publisher(sim), goal_radius=0.3)
    goal = messages.get("geometry_msgs/PoseStamped")()
    goal.pose.position.x, goal.pose.position.y = info["goal"]
    node.on_goal(goal)
    for _ in range(600):
        sim.step()
        node.on_odometry(sim.last("/odometry/ground_truth"))
        node.on_scan(sim.last("/scan"))
        if np.hypot(*(np.array(sim.models["robot"].pose[:2]) - info["goal"])) < 0.3:
            return True
    return False


class Publisher:
    """Publishes to a simulation."""

    def __init__(self, sim):
        self._sim = sim

    def publish(self, message):
        self._sim.publish("/cmd_vel", message)


class Sink:
    """Keeps what is published."""

    def __init__(self):
        self.sent = []
        self.publish = self.sent.append


def scan_at(seconds, beams=4):
    """A scan with this stamp."""
    scan = messages.get("sensor_msgs/LaserScan")(ranges=[1.0] * beams)
    scan.header.stamp.nsecs = round(seconds % 1.0 * 1e9)
    scan.header.stamp.secs = int(seconds)
    return scan


def at_the_origin():
    odometry = messages.get("nav_msgs/Odometry")()
    odometry.pose.pose.orientation.w = 1.0
    return odometry


def test_a_node_stops_at_the_goal_and_acts_at_its_rate():
    sink, odometry = Sink(), at_the_origin()
    sent = sink.sent
    node = PolicyNode(untrained(), sink, goal_radius=0.3)
    goal = messages.get("geometry_msgs/PoseStamped")()

    def act(milliseconds):
        node.on_scan(scan_at(milliseconds / 1000.0))

    act(0)
    node.on_odometry(odometry)
    act(50)
    assert sent == []  # there is no goal yet
    goal.pose.position.x = 2.0
    node.on_goal(goal)
    for time in (100, 150, 199, 250, 300):
        act(time)
    assert len(sent) == 3  # at 100, 199 and 300 ms
    assert (sent[0].linear.x, sent[0].angular.z) != (0, 0)
    odometry.pose.pose.position.x = 1.9
    node.on_odometry(odometry)
    act(400)
    act(500)
    assert len(sent) == 4
    assert (sent[3].linear.x, sent[3].angular.z) == (0, 0)


def test_a_node_survives_time_going_back():
    sink, reports = Sink(), []
    node = PolicyNode(untrained(), sink, goal_radius=0.3, report=reports.append)
    goal = messages.get("geometry_msgs/PoseStamped")()
    goal.pose.position.x = 2.0
    node.on_goal(goal)
    node.on_odometry(at_the_origin())

    for seconds in (60.0, 0.05, 0.1):  # reset after a minute
        node.on_scan(scan_at(seconds))
    assert len(sink.sent) == 2

    node.on_scan(scan_at(1.0, beams=5))
    assert (sink.sent[-1].linear.x, sink.sent[-1].angular.z) == (0, 0)
    assert reports == ["expected scans of 4 ranges, for which the policy was trained, found 5"]
    node.on_scan(scan_at(2.0))
    assert len(sink.sent) == 3

    odometry = at_the_origin()
    odometry.twist.twist.angular.z = math.nan
    node.on_odometry(odometry)
    node.on_goal(goal)
    node.on_scan(scan_at(3.0))
    assert (sink.sent[-1].linear.x, sink.sent[-1].angular.z) == (0, 0)
    assert reports[1:] == ["expected finite odometry, found (0.0, 0.0, 0.0) and (0.0, 0.0, nan)"]


def test_equal_seeds_train_equal_policies():
    def trained(threads):
        arguments = {**SETTINGS, "world": "discs", "beams": 8}
        env = NavigationVectorEnv(8, threads, autoreset_mode="SameStep", **arguments)
        policy = Ppo(env, seed=3).train(steps=1500)
        env.close()
        return policy

    a, b = trained(1), trained(2)
    assert all((x == y).all() for x, y in zip(a.weights, b.weights))


def test_gradients_are_those_of_differences():
    rng = np.random.default_rng(1)
    network = Network((5, 7, 6, 3), 1.0, rng)
    for parameter in network.parameters:
        parameter += rng.normal(0.0, 0.1, parameter.shape).astype(np.float32)
    inputs = rng.normal(size=(4, 5)).astype(np.float32)
    towards = rng.normal(size=(4, 3)).astype(np.float32)
    gradients = network.backward(network.forward(inputs), towards)

    for parameter, gradient in zip(network.parameters, gradients):
        place = tuple(rng.integers(size) for size in parameter.shape)
        values = []
        for step in (1e-2, -1e-2):
            former = parameter[place]
            parameter[place] = former + step
            values.append(float((network.forward(inputs)[-1] * towards).sum()))
            parameter[place] = former
        assert gradient[place] == pytest.approx((values[0] - values[1]) / 2e-2, rel=0.02, abs=5e-3)


def untrained():
    """A policy of random numbers for four beams."""
    network = Network((4 + 3 + 2, 2), 1.0, np.random.default_rng(1))
    weights, biases = tuple(network.weights), tuple(network.biases)
    return Policy(weights, biases, 4, 10.0, (0.8, 0.0, 2.0), (0.8, 2.0), 0.1)


def test_a_policy_is_written_and_read(tmp_path):
    policy = untrained()
    policy.save(tmp_path / "a.npz")
    read = Policy.load(tmp_path / "a.npz")

    observations = np.random.default_rng(2).random((6, 9), np.float32)
    assert (read.act(observations) == policy.act(observations)).all()
    assert (np.abs(policy.act(observations * 100)) <= (0.8 + 1e-6, 2.0)).all()
    assert (read.beams, read.period, read.action_limits) == (4, 0.1, (0.8, 2.0))
    with pytest.raises(
        UsageError, match=r"expected observations of shape \(n, 9\), found \(6, 5\)"
    ):
        policy.act(observations[:, :5])


def rewritten(path, **arrays):
    """A policy's file with other arrays."""
    untrained().save(path)
    with np.load(path) as file:
        content = {**dict(file), **arrays}
    np.savez(path, **content)


def with_a_header_of_terabytes(path):
    rewritten(path)
    with zipfile.ZipFile(path) as archive:
        parts = {name: archive.read(name) for name in archive.namelist()}
    header = str({"descr": "<f8", "fortran_order": False, "shape": (2**39,)}).encode().ljust(117)
    parts["weight_0.npy"] = b"\x93NUMPY\x01\x00\x76\x00" + header + b"\n"
    with zipfile.ZipFile(path, "w") as archive:
        for name, data in parts.items():
            archive.writestr(name, data)


def cut(path):
    untrained().save(path)
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])


def with_an_odd_flag(path):
    rewritten(path)
    content = bytearray(path.read_bytes())
    content[content.rindex(b"PK\x01\x02") + 8] |= 1  # "encrypted", in the directory
    path.write_bytes(content)


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (with_a_header_of_terabytes, ""),
        (with_an_odd_flag, ""),
        (cut, "file of a policy, but .*not a zip file"),
        (lambda path: None, "cannot be read: No such file"),
        (lambda path: path.write_text("policy"), "expected a file of a policy, but"),
        (lambda path: np.savez(path, a=np.zeros(3)), "expected a file of a policy, but"),
        (lambda path: path.symlink_to("/dev/zero"), ""),
        *((make, "") for make in (os.mkfifo, Path.mkdir, Path.touch)),
        *((partial(rewritten, period=np.array(period)), "") for period in (0.0, -1.0, np.nan)),
        (partial(rewritten, max_range=np.array(np.nan)), ""),
        (partial(rewritten, action_limits=np.array([np.nan, 1.0])), ""),
        (partial(rewritten, velocity_limits=np.array([np.inf, 0.0, 1.0])), ""),
        (partial(rewritten, bias_0=np.array([np.nan, 0.0])), "finite"),
        (partial(rewritten, beams=np.array(5)), "10 inputs"),
        (partial(rewritten, beams=np.array(10**9)), ""),
        (partial(rewritten, layers=np.array(10**9)), ""),
    ],
)
def test_a_file_that_is_no_sound_policy_is_refused(tmp_path, spoil, message):
    path = tmp_path / "a.npz"
    spoil(path)

    with pytest.raises(FlatlandError, match=message) as error:
        Policy.load(path)
    assert "a.npz" in str(error.value)
    with pytest.raises(FlatlandError, match="expected the path of a policy, found 5"):
        Policy.load(5)


def test_the_policy_of_the_package_is_known_by_name():
    assert Policy.load("discs").beams == 64


def test_a_policy_takes_what_robots_measure():
    policy = untrained()
    place = {"pose": [0, 0, 0], "velocity": [0, 0, 0], "goal": [1, 1]}
    nothing, invalid = (policy.drive([1, 2, 3, value], **place) for value in (np.inf, np.nan))
    assert nothing == invalid  # a beam without a return, by REP 117 and by others
    with pytest.raises(UsageError, match="expected the goal as 2 finite numbers, found None"):
        policy.drive([1, 2, 3, 4], **{**place, "goal": None})


def test_the_command_trains_and_says_what_is_wrong(tmp_path, capsys):
    path = tmp_path / "policy.npz"
    arguments = ["--envs", "4", "--threads", "1", "--steps", "300", "--episodes", "3"]
    assert main([str(path), "--world", "empty_room", *arguments]) == 0
    assert Policy.load(path).beams == 64
    assert "of 3 episodes with new seeds" in capsys.readouterr().out
    settings = ["--set", "beams=8", "--set", "rewards={time: -1}"]
    assert main([str(path), "--world", "empty_room", *arguments, *settings]) == 0
    assert Policy.load(path).beams == 8
    assert main([str(path), "--world", "empty_room", *arguments, "--set", "lidr=front"]) == 1
    assert "error: got an unexpected keyword argument 'lidr'" in capsys.readouterr().err
    assert main([str(path), "--world", "ofice", *arguments]) == 1
    assert 'error: no world is named "ofice"' in capsys.readouterr().err
    for wrong in (["--discount", "1.1"], ["--learning-rate", "nan"]):
        assert main([str(path), *arguments, *wrong]) == 1
        assert "error: expected a learning_rate above 0 and a disc" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["no/policy.npz"], "No such file or directory: 'no/policy.npz'"),
        (["."], "Is a directory: '.'"),
        (["a.npz", "--seed", "-1"], 'expected a whole number of 0 or more, found "-1"'),
        (["a.npz", "--episodes", "0"], 'expected a whole number of 1 or more, found "0"'),
        (["a.npz", "--set", "beams"], 'expected NAME=VALUE with a value in YAML, found "beams"'),
        (["a.npz", "--minutes", "nan"], 'expected a number above 0, 1e+09 at most, found "nan"'),
    ],
)
def test_wrong_arguments_are_reported_before_the_training(
    tmp_path, monkeypatch, capsys, arguments, message
):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(Ppo, "train", None)
    try:
        code = main(arguments)
    except SystemExit as error:
        code = error.code

    assert code in (1, 2)
    assert message in capsys.readouterr().err


def test_ctrl_c_keeps_the_policy(tmp_path, capsys, monkeypatch):
    steps = []

    def step(env, *arguments):
        steps.append(arguments)
        if len(steps) == 100:
            raise KeyboardInterrupt
        return original(env, *arguments)

    original = NavigationVectorEnv.step
    monkeypatch.setattr(NavigationVectorEnv, "step", step)
    path = tmp_path / "policy.npz"

    assert main([str(path), "--world", "empty_room", "--envs", "2", "--threads", "1"]) == 130

    assert Policy.load(path).beams == 64
    assert "policy.npz: interrupted after 128 steps" in capsys.readouterr().err


_WITHOUT_GYMNASIUM = """
import runpy, sys
sys.modules["gymnasium"] = None
sys.argv = ["train", "policy.npz"]
runpy.run_module("flatland_gym.train", run_name="__main__")
"""


def test_without_gymnasium_it_says_what_to_install():
    result = subprocess.run(
        [sys.executable, "-c", _WITHOUT_GYMNASIUM],
        env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
        stderr=subprocess.PIPE,
        text=True,
        timeout=60,
    )
    assert result.returncode == 1
    assert (
        result.stderr
        == "error: NavigationVectorEnv needs Gymnasium: pip install '.[gym]' in Flatland's clone\n"
    )


def test_the_program_restarts_with_one_blas_thread_by_default(monkeypatch):
    calls = []
    monkeypatch.setattr(os, "execv", lambda program, arguments: calls.append(arguments))
    monkeypatch.setattr(sys, "argv", ["train.py", "policy.npz", "--seed", "2"])
    monkeypatch.delenv("OPENBLAS_NUM_THREADS", raising=False)
    train._limit_blas_threads()
    assert calls == [[sys.executable, "-m", "flatland_gym.train", "policy.npz", "--seed", "2"]]
    assert os.environ["OPENBLAS_NUM_THREADS"] == "1"
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "2")
    train._limit_blas_threads()
    assert len(calls) == 1
