"""Topics within the process: what one plugin publishes, another one gets."""

import pytest

from flatland_server import LocalTransport


@pytest.fixture
def transport():
    return LocalTransport(subscribed_topics=())


def advertise(transport, topic, latch=False):
    return transport.advertise(topic, str, latch=latch, queue_size=1)


def test_a_message_is_delivered_at_the_end_of_the_step(transport):
    received = []
    publisher = advertise(transport, "door")
    subscription = transport.subscribe("/door", str, received.append)
    assert publisher.has_subscribers

    publisher.publish("open")
    assert received == []
    transport.flush()
    assert received == ["open"]
    transport.flush()
    assert received == ["open"]

    publisher.publish("close")
    subscription.close()
    transport.flush()
    assert received == ["open"]
    assert not publisher.has_subscribers


def test_a_subscription_makes_publishers_look_again(transport):
    before = transport.subscriber_revision
    subscription = transport.subscribe("door", str, print)
    between = transport.subscriber_revision
    subscription.close()
    assert before != between != transport.subscriber_revision


def test_a_later_subscriber_gets_the_last_latched_message(transport):
    received = []
    advertise(transport, "map", latch=True).publish("walls")
    advertise(transport, "scan").publish("ranges")
    transport.subscribe("map", str, received.append)
    transport.subscribe("scan", str, received.append)
    transport.flush()
    assert received == ["walls"]


def test_plugins_that_answer_each_other_do_not_hold_up_the_step(transport):
    publisher = advertise(transport, "echo")
    transport.subscribe("echo", int, lambda number: publisher.publish(number + 1))
    publisher.publish(0)
    transport.flush()
    transport.flush()
    assert transport.last("echo") == 2


def test_without_delivery_messages_are_kept_but_not_delivered(transport):
    received = []
    publisher = advertise(transport, "door")
    transport.subscribe("door", str, received.append)
    with transport.without_delivery():
        publisher.publish("open")
    transport.flush()
    assert (received, transport.last("door")) == ([], "open")


def test_messages_from_before_a_reset_are_discarded(transport):
    received = []
    publisher = advertise(transport, "door")
    transport.subscribe("door", str, received.append)
    publisher.publish("open")
    transport.discard()
    transport.flush()
    assert received == []
