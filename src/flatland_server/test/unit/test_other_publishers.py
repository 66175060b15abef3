"""Warnings of other nodes that publish on a plugin's topic."""

from typing import Any, Dict, List

import pytest
import rospy
from logged import warnings

from flatland_server.ros.other_publishers import OtherPublishers


class Master:
    """A fake of the master: its publishers by topic, or None while it does not answer."""

    state: Any

    def publishers(self) -> List[Any]:
        if self.state is None:
            raise ConnectionError
        return [[topic, nodes] for topic, nodes in self.state.items()]


@pytest.fixture
def check(monkeypatch, caplog):
    """Looks at the publishers of two topics, and returns the warnings."""
    master = Master()
    monkeypatch.setattr(rospy, "get_name", lambda: "/server")
    others = OtherPublishers({"/odometry/filtered": 1, "/deleted": 0, "/r1/tf": 1}, master)

    def look(state: Dict[str, List[str]]) -> List[str]:
        caplog.clear()
        master.state = state
        others.check()
        return warnings(caplog)

    return look


def test_a_second_publisher_is_named_once(check):
    both = {"/odometry/filtered": ["/server", "/ekf"]}

    [warning] = check(both)

    assert warning.startswith("/odometry/filtered is also published by /ekf: ")
    assert check(both) == []
    assert check({"/odometry/filtered": ["/server"]}) == []
    assert len(check(both)) == 1  # once more for one that comes back


def test_topics_that_only_others_publish_cause_no_warning(check):
    assert check({"/map": ["/map_server"], "/deleted": ["/ekf"], "/tf": ["/server", "/amcl"]}) == []


def test_transforms_have_several_publishers(check):
    assert check({"/r1/tf": ["/server", "/r1/amcl"]}) == []


def test_a_master_that_does_not_answer_is_asked_again(check):
    assert check(None) == []
    assert len(check({"/odometry/filtered": ["/ekf"]})) == 1
