"""`flatland serve` for fleets of ROS 2: stamps of real time, and transforms by namespace."""

import time

import pytest
from bridge_clients import Client, running
from waiting import wait_until

from flatland2d.cli import main
from flatland_server.messages.conversions import stamp_offset

TOLERANCE = 5.0  # s of real time, on a busy machine


@pytest.fixture
def fleet(world):
    """A world with a robot in a namespace besides the one without."""
    content = world.read_text()
    world.write_text(
        f"{content}  - {{name: r1, namespace: r1, pose: [2, 0, 0], model: robot.model.yaml}}\n"
    )
    return world


def seconds(stamp):
    return stamp["secs"] + stamp["nsecs"] * 1e-9


def frames(message):
    return {(each["header"]["frame_id"], each["child_frame_id"]) for each in message["transforms"]}


def test_stamps_are_of_real_time_without_a_clock(fleet):
    with running(fleet, wall_clock_stamps=True) as server:
        client = Client(server)
        client.subscribed("/clock")
        topics = client.call("/rosapi/topics")["values"]["topics"]
        assert "/clock" not in topics
        assert "/tf" in topics
        for topic in ("/scan", "/odometry/filtered", "/flatland_server/model_states"):
            message = client.subscribed(topic).next_of(topic)
            stamp = message["header"]["stamp"] if "header" in message else message["stamp"]
            assert seconds(stamp) == pytest.approx(time.time(), abs=TOLERANCE)
        message = client.subscribed("/tf").next_of("/tf")["transforms"][0]
        assert seconds(message["header"]["stamp"]) == pytest.approx(time.time(), abs=TOLERANCE)
        now = client.call("/rosapi/get_time")["values"]["time"]
        assert seconds(now) == pytest.approx(time.time(), abs=TOLERANCE)
        assert not any(each.get("topic") == "/clock" for each in client.kept)

        answer = client.call("/change_rate", rate=2.0)
        assert answer["values"]["success"] is False
        assert "expected a rate of 1" in answer["values"]["message"]
    assert stamp_offset() == 0  # for other simulations of this process


def test_stamps_of_real_time_are_refused_with_another_rate(world, capsys):
    code = main(["serve", str(world), "--wall-clock-stamps", "--rate", "2", "--port", "0"])

    assert code == 1
    assert "expected a rate of 1, since messages are stamped with real time, found 2" in (
        capsys.readouterr().err
    )


def test_steps_of_another_length_have_stamps_of_real_time_too(world):
    with running(world, wall_clock_stamps=True, step_size=0.02) as server:
        assert server.manager.rate == 1.0


def test_each_namespace_has_transforms_of_its_own(fleet):
    with running(fleet, tf_by_namespace=True) as server:
        client = Client(server)
        for topic in ("/tf", "/r1/tf"):
            seen = set()
            client.subscribed(topic)
            while len(seen) < 2:
                seen |= frames(client.next_of(topic))
            assert seen == {("odom", "base"), ("base", "laser")}
        for topic in ("/tf_static", "/r1/tf_static"):
            assert frames(client.subscribed(topic).next_of(topic)) == {("map", "odom")}
        assert client.subscribed("/r1/scan").next_of("/r1/scan")["header"]["frame_id"] == "laser"

        client.call("/delete_model", name="r1")
        wait_until(
            lambda: "/r1/tf" not in client.call("/rosapi/topics")["values"]["topics"],
            "the topic to go",
        )
