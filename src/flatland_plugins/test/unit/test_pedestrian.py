"""Pedestrian: by itself, as an agent of another program, and on legs before a laser."""

import math
from typing import Any, Tuple

import pytest
from logged import warnings

from flatland_server import messages

DISC = "{type: circle, radius: 0.25, density: 400}"
LEG = "{type: circle, radius: 0.1, density: 1, collision: false}"
LEGS = f"""
  - {{name: left_leg, footprints: [{LEG}]}}
  - {{name: right_leg, footprints: [{LEG}]}}
"""
CALM = "force: {noise: 0}"
AGENTS = {
    "pedsim_msgs/AgentState": "uint64 id\ngeometry_msgs/Pose pose\ngeometry_msgs/Twist twist",
    "pedsim_msgs/AgentStates": "pedsim_msgs/AgentState[] agent_states",
}


def walker(files, keys: str = CALM, bodies: str = LEGS, pose: str = "[0, 0, 0]", **more: Any):
    """A world with a pedestrian, and with other models."""
    model = f"bodies:\n  - {{name: body, footprints: [{DISC}]}}\n{bodies}"
    files.write("walker.yaml", f"{model}\nplugins:\n  - {{type: Pedestrian, name: walk, {keys}}}\n")
    return files.load_models({"walker7": f"model: walker.yaml, pose: {pose}", **more})


def place(simulation, body: str = "body") -> Tuple[float, float]:
    return tuple(simulation.model("walker7").bodies[body].pose[:2])


def odometry(x: float, y: float, yaw: float, forwards: float):
    message = messages.get("nav_msgs/Odometry")()
    message.pose.pose.position.x, message.pose.pose.position.y = x, y
    message.pose.pose.orientation.z = math.sin(yaw / 2)
    message.pose.pose.orientation.w = math.cos(yaw / 2)
    message.twist.twist.linear.x = forwards
    return message


# By itself


def test_a_pedestrian_walks_like_a_person_of_a_crowd(files, town):
    goals = "goals: [[3, 0.5], [0, 0]]"
    box = {"box": f"model: {files.model('box')}, pose: [1.5, 0.1, 0]"}
    crowd = town(f"pose: [0, 0, 0], {goals}, legs: true", keys=CALM, robots=box)
    path = []
    for _ in range(16):
        bodies = crowd.run(0.5).model("people_0").bodies.values()
        path.append([tuple(body.pose[:2]) for body in bodies])

    alone = walker(files, f"{goals}, {CALM}", **box)

    for expected in path:
        alone.run(0.5)
        found = [place(alone, name) for name in ("body", "left_leg", "right_leg")]
        assert found == [pytest.approx(each, abs=1e-4) for each in expected]
    assert max(y for (_, y), _, _ in path) > 0.3  # around the box


def test_without_goals_and_agents_it_stays(files):
    assert place(walker(files, pose="[1, 2, 0.5]").run(3.0)) == pytest.approx((1, 2), abs=1e-5)


# As an agent


def test_it_goes_where_odometry_says_and_stands_when_that_ceases(files):
    person = walker(files).run(0.5)

    person.send("/agent", odometry(5.0, 3.0, math.pi / 2, 0.8)).run(0.5)

    # It jumps there, and walks on at that speed, for a second at most.
    assert place(person) == pytest.approx((5.0, 3.0 + 0.8 * 0.5), abs=1e-3)
    person.run(0.3)
    person.send("/agent", odometry(5.0, 3.7, 0.0, 1.0)).run(0.2)
    assert place(person) == pytest.approx((5.2, 3.7), abs=1e-3)
    person.run(3.0)
    assert place(person) == pytest.approx((6.0, 3.7), abs=1e-3)
    for side, leg in ((1, "left_leg"), (-1, "right_leg")):
        assert abs(place(person, leg)[1] - 3.7 - side * 0.1) < 0.02


def test_non_finite_odometry_is_ignored_after_one_warning(files, caplog):
    person = walker(files)

    for x in (math.nan, math.inf, 1e9):
        person.send("/agent", odometry(x, 0.0, 0.0, 1.0)).run(0.1)

    assert place(person) == pytest.approx((0.0, 0.0), abs=1e-5)
    [warning] = warnings(caplog)
    assert warning.startswith("walker7/walk: expected an agent with numbers below 50000, found Ag")


@pytest.fixture
def agent_states(monkeypatch):
    """A message of agents, as if pedsim_msgs were there."""
    types = messages.message_types.MessageTypes()
    monkeypatch.setattr("flatland_server.transport.node.get", types.get)
    for name, definition in AGENTS.items():
        types.add(name, definition)

    def states(**agents: Tuple[float, float, float, float]) -> Any:
        message = types.get("pedsim_msgs/AgentStates")()
        for name, (x, y, vx, vy) in agents.items():
            agent = types.get("pedsim_msgs/AgentState")(id=int(name[1:]))
            agent.pose.position.x, agent.pose.position.y = x, y
            agent.twist.linear.x, agent.twist.linear.y = vx, vy
            message.agent_states.append(agent)
        return message

    return states


def test_a_name_without_a_number_follows_no_agent(files, agent_states):
    simulation = files.robot("type: Pedestrian, name: walk, agent_topic: /agents")

    simulation.send("/agents", agent_states(a7=(0.5, 0.0, 0.0, 0.0))).run(0.5)

    assert simulation.model().pose.x == 0.0


@pytest.mark.parametrize(("keys", "id"), [("", 7), (", agent_id: 3", 3)])
def test_a_pedestrian_follows_the_agent_of_its_id_or_number(files, agent_states, keys, id):
    person = walker(files, f"agent_topic: /agents{keys}, {CALM}").run(0.5)

    agents = {"a1": (9.0, 9.0, 0.0, 0.0), f"a{id}": (0.2, -0.1, 0.6, -0.8)}
    person.send("/agents", agent_states(**agents)).run(0.5)

    assert place(person) == pytest.approx((0.2 + 0.3, -0.1 - 0.4), abs=1e-3)


def test_without_pedsim_msgs_it_walks_by_itself_after_a_warning(files, caplog):
    walker(files, f"agent_topic: /agents, {CALM}").run(0.1)

    [warning] = warnings(caplog)
    assert warning.startswith("walker7/walk: agent_topic has no effect: there is no message type")


# Its gait


def test_steps_and_sizes_of_legs_are_those_of_the_phase(files):
    gait = "leg_offset: 0.3, step_time: 0.5, leg_radius: 0.12, swing_radius: 0.08, speed: 1"
    person = walker(files, f"goals: [[100, 0], [0, 0]], {gait}, update_rate: inf, {CALM}").run(6.0)
    legs = [person.model("walker7").bodies[name] for name in ("left_leg", "right_leg")]

    seen = []
    for _ in range(200):
        x, _ = place(person.run())
        seen += [
            (leg.pose.x - x, leg.physics_body.fixture(0).seen_radius, side)
            for side, leg in zip((1, -1), legs)
        ]
        assert [leg.pose.y for leg in legs] == pytest.approx([0.15, -0.15], abs=1e-3)

    # A step is 0.5 m: a foot is at most 0.25 m ahead, and back there after two steps of 0.5 s.
    assert max(ahead for ahead, _, _ in seen) == pytest.approx(0.25, abs=0.01)
    assert min(ahead for ahead, _, _ in seen) == pytest.approx(-0.25, abs=0.01)
    assert seen[0][0] == pytest.approx(seen[-2][0], abs=0.03)
    for before, after in zip(seen, seen[2:]):
        swings = after[0] > before[0]
        # On its way ahead, a foot is lifted as cos(pi ahead / (4 * 0.125)).
        lift = math.cos(math.pi * after[0] / 0.5) if swings else 0.0
        assert after[1] == pytest.approx(0.12 - 0.04 * max(0.0, lift), abs=2e-3)


def test_a_laser_sees_legs_but_not_body_or_safety_circle(files):
    circle = "  - {name: circle, footprints: [{type: circle, radius: 2, density: 0}]}\n"
    laser = (
        "type: Laser, name: laser, body: base, range: 9, "
        "angle: {min: -0.2, max: 0.2, increment: 0.001}"
    )
    keys = "safety_dist_body: circle, safety_dist: 0.7, leg_radius: 0.05, leg_offset: 0.4"
    robot = f"model: {files.model('robot', laser)}, pose: [-3, 0, 0]"
    person = walker(files, f"{keys}, {CALM}", LEGS + circle, robot=robot).run()

    scan = person.last("/scan")

    for index, distance in enumerate(scan.ranges):
        angle = scan.angle_min + index * scan.angle_increment
        nearest = math.inf
        for y in (0.2, -0.2):
            across = 3.0 * math.sin(angle) - y * math.cos(angle)
            if abs(across) < 0.05:
                along = 3.0 * math.cos(angle) + y * math.sin(angle)
                nearest = min(nearest, along - math.sqrt(0.05**2 - across**2))
            elif abs(abs(across) - 0.05) < 1e-4:
                nearest = distance  # it grazes the leg
        assert distance == pytest.approx(nearest, abs=2e-3)
    config = {body.name: body for body in person.model("walker7").config.bodies}
    assert config["circle"].footprints[0].shape.radius == 0.7  # in markers and pictures


def test_deviations_are_those_of_the_name_in_every_run(files):
    keys = f"leg_radius: 0.1, var_leg_radius: 0.02, {CALM}"
    radii = []
    for seed in (1, 2):
        walker(files, keys)
        others = dict.fromkeys(("walker7", "walker8"), "model: walker.yaml")
        simulation = files.load_models(others, seed=seed)
        for name in others:
            leg = simulation.model(name).bodies["left_leg"]
            radii.append(leg.physics_body.fixture(0).seen_radius)

    assert radii[:2] == radii[2:]
    assert radii[0] != radii[1]
    assert all(abs(radius - 0.1) < 0.1 for radius in radii)


def test_files_for_other_simulators_are_run_with_their_keys(files, agent_states):
    circle = "{type: circle, radius: 0.2, center: [-0.3, 0], density: 1, collision: false}"
    bodies = [f"{{name: {n}, footprints: [{circle}]}}" for n in ("base", "left", "right", "around")]
    plugin = """
        type: PedsimMovement, name: movement, agent_topic: /pedsim_simulator/simulated_agents,
        base_body: base, left_leg_body: left, right_leg_body: right, safety_dist_body: around,
        update_rate: 10, toggle_leg_movement: false, leg_offset: 0.38, var_leg_offset: 0.0,
        step_time: 0.6, var_step_time: 0.0, leg_radius: 0.13, var_leg_radius: 0.0, safety_dist: 0.7
    """
    files.write("walker.yaml", f"bodies: [{', '.join(bodies)}]\nplugins: [{{{plugin}}}]\n")
    person = files.load_models({"walker7": "model: walker.yaml"})
    agents = agent_states(a7=(2.0, 1.0, 1.0, 0.0))

    person.send("/pedsim_simulator/simulated_agents", agents).run(1.0)

    for name, y in (("base", 1.0), ("around", 1.0), ("left", 1.19), ("right", 0.81)):
        assert place(person, name) == pytest.approx((3.0, y), abs=1e-3)


@pytest.mark.parametrize(
    ("keys", "bodies", "message"),
    [
        ("body: body, base_body: body", "", 'base_body: "body" and "base_body" are one key'),
        ("left_leg_body: leg", f"  - {{name: leg, footprints: [{LEG}]}}", '"right_leg_body" is mi'),
        ("body: post", "  - {name: post, type: static, footprints: []}", '"post", a static one'),
        ("", LEGS.replace(LEG, f"{LEG}, {LEG}"), 'expected one footprint of "left_leg", found 2'),
    ],
)
def test_bodies_that_a_pedestrian_cannot_move_are_refused(files, keys, bodies, message):
    with pytest.raises(Exception, match=r"walker.yaml:\d+: plugins") as caught:
        walker(files, keys, bodies)

    assert message in str(caught.value)
