"""The topics of a simulation: messages that are computed, their times, and sent messages."""

import pytest
from library.parts import LOADER, Float

from flatland2d import PluginError, Simulation, TopicError, messages


@pytest.fixture
def published(monkeypatch):
    """The messages that plugins publish in any simulation."""
    made = []
    init = Float.__init__

    def note(self, *arguments, **fields):
        init(self, *arguments, **fields)
        made.append(self)

    monkeypatch.setattr(Float, "__init__", note)
    return made


def test_topics_and_their_types(sim):
    assert sim.topics == {"/command": "std_msgs/Float64", "/speed": "std_msgs/Float64"}
    sim.delete("robot")
    assert sim.topics == {}


def test_nothing_is_computed_until_it_is_asked_for(sim, published):
    sim.models["robot"].command(0.5)
    sim.step(10)
    assert published == []

    assert sim.last("/speed").data == 0.5
    assert len(published) == 1
    sim.step(10)
    assert len(published) == 11


def test_last_gives_the_present_first_and_then_the_last_step(sim):
    robot = sim.models["robot"]
    robot.command(0.5)
    assert sim.last("speed").data == 0.5
    robot.command(0.7)
    assert sim.last("speed").data == 0.5
    assert sim.step().last("speed").data == 0.7


def test_topics_can_be_subscribed_to_from_the_beginning(world):
    sim = Simulation(world, loader=LOADER, topics=["speed", "/later/speed"]).step()
    assert sim.last("/speed").data == 0.0

    assert Simulation(world, loader=LOADER, topics="speed").step().last("/speed").data == 0.0
    sim.spawn(world["models"][0]["model"], "later", [-1, 0, 0], namespace="later")
    sim.step()
    assert sim.last("/later/speed").data == 0.0


def test_subscriptions_outlive_a_reset(sim):
    sim.subscribe("/speed")
    sim.step().reset()
    assert sim.last("/speed") is None
    assert sim.step().last("/speed").data == 0.0


def test_a_message_acts_in_the_next_step_and_the_last_command_counts(sim):
    robot = sim.models["robot"]
    sim.publish("/command", Float(0.75))
    assert robot.velocity.vx == 0.0
    robot.command(0.25)
    sim.step()
    assert robot.velocity.vx == 0.25
    sim.publish("/command", Float(0.5))
    sim.step()
    assert robot.velocity.vx == 0.5


def test_publish_raises_the_exception_of_a_callback(sim):
    with pytest.raises(PluginError, match="failed in its callback of command: ValueError: too fas"):
        sim.publish("/command", Float(10.0))


@pytest.mark.parametrize(
    ("topic", "message", "error"),
    [
        ("/comand", 0.5, r'no plugin subscribes to "/comand" \(did you mean "/command"\?\)'),
        ("/speed", 0.5, 'no plugin subscribes to "/speed"; there are: /command'),
        ("/command", messages.get("std_msgs/Bool")(), "expects std_msgs/Float64, found std_msgs/B"),
        ("/command", 0.5, "expects std_msgs/Float64, found float"),
    ],
)
def test_a_message_that_cannot_be_received_is_refused(sim, topic, message, error):
    with pytest.raises(TopicError, match=error):
        sim.publish(topic, message)
    assert sim.models["robot"].plugin("pusher").received == []


def test_a_topic_that_no_plugin_publishes_is_refused(sim):
    with pytest.raises(TopicError, match=r'publishes to "/sped" \(did you mean "/speed"\?\)'):
        sim.last("sped")


def test_transforms_are_computed_if_they_are_subscribed_to():
    sim = Simulation("office").step(20)
    with pytest.raises(TopicError, match=r'expected subscribe\("/tf"\) before the steps'):
        _ = sim.transforms

    sim.subscribe("/tf")
    sim.step(20)

    assert sim.transforms["base_link"].parent == "odom"
    assert sim.transforms["laser"].pose.x == 0.05


def test_a_recording_subscribes_while_it_is_open(sim, tmp_path, published):
    with sim.record(tmp_path / "run.bag", topics=["/speed"]):
        sim.step(5)
    assert len(published) == 5
    sim.step(5)
    assert len(published) == 5
    assert (tmp_path / "run.bag").exists()
    recorder = sim.record(tmp_path / "other.bag")
    sim.close()
    assert not recorder.is_open
