"""Names of types that come over the network import no package but those of messages."""

import pytest
import rospy
from std_msgs.msg import Bool

from flatland_viz.model_list import Topic
from flatland_viz.plot import message_class_of
from flatland_viz.topic_monitor import TopicMonitor


@pytest.fixture
def trap(tmp_path, monkeypatch):
    """Packages that leave a mark when they are imported."""
    ran = "from pathlib import Path\nPath(__file__).with_name('ran').touch()\n"
    for name in ("boats", "carts"):
        (tmp_path / name / "msg").mkdir(parents=True)
        (tmp_path / name / "__init__.py").write_text(ran)
        (tmp_path / name / "msg" / "__init__.py").write_text("class Bool: pass\n")
    (tmp_path / "carts" / "msg" / "_Other.py").touch()
    (tmp_path / "plain" / "msg").mkdir(parents=True)  # not a package
    (tmp_path / "plain" / "msg" / "_Bool.py").write_text(ran)
    monkeypatch.syspath_prepend(tmp_path)
    yield
    assert list(tmp_path.rglob("ran")) == []


@pytest.mark.parametrize("kind", [
    *("boats/Bool", "carts/Bool", "plain/Bool", "boats", "boats/msg/Bool", "", "/", "a b/Bool"),
    *("__main__/Bool", "sys/Bool", "carts/../msg/Other", "*"),
])  # fmt: skip
def test_a_plot_imports_no_other_package(trap, kind):
    assert message_class_of(kind) is None


def test_a_plot_finds_types_of_messages(trap):
    assert message_class_of("std_msgs/Bool") is Bool


def test_the_panel_imports_only_classes_of_types_that_it_shows(trap, monkeypatch):
    subscribed = {}
    monkeypatch.setattr(
        rospy, "Subscriber", lambda name, kind, *args, **options: subscribed.update({name: kind})
    )
    types = {"/a": "boats/Bool", "/b": "std_msgs/Bool", "/c": "nope", "/d": "std_msgs/String"}

    TopicMonitor().watch([Topic(name, kind, True, "x") for name, kind in types.items()])

    assert subscribed == {
        **{"/a": rospy.AnyMsg, "/b": Bool},
        **{"/c": rospy.AnyMsg, "/d": rospy.AnyMsg},
    }
