"""Errors of the window itself: each is logged once and counted, by rospy's own log of callbacks."""

import logging

import pytest
import rospy
from rospy.topics import _SubscriberImpl
from std_msgs.msg import UInt8

from flatland_viz.own_errors import OwnErrors


@pytest.fixture
def errors():
    errors = OwnErrors()
    errors.start()
    yield errors
    logging.getLogger("rosout").removeFilter(errors)


def fail(message):
    raise ValueError(f"no {message.data}")


def fail_elsewhere(message):
    return message.pose


def test_a_failing_callback_is_logged_once_and_counted(errors, caplog):
    topic = _SubscriberImpl("/numbers", UInt8)
    topic.add_callback(fail, None)
    topic.add_callback(fail_elsewhere, None)
    topic.receive_callback([UInt8(number) for number in range(200)], None)

    logged = [r.getMessage().splitlines()[-1] for r in caplog.records if r.name == "rosout"]
    assert logged == ["ValueError: no 0", "AttributeError: 'UInt8' object has no attribute 'pose'"]
    counts = [(text.splitlines()[-1], times) for text, times in errors.take()]
    assert counts == [(text, 200) for text in logged]

    topic.receive_callback([UInt8(0)], None)
    assert [times for _, times in errors.take()] == [1, 1]
    assert errors.take() == []


def test_log_entries_without_a_traceback_are_logged_each_time(errors, caplog):
    for _ in range(2):
        rospy.logerr("the file cannot be read")
        rospy.logwarn("slow: %s", "Traceback (most recent call last):")

    assert len([r for r in caplog.records if r.name == "rosout"]) == 4
    assert errors.take() == []
