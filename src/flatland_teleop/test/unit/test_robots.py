"""Topics of commands, from the master's state."""

from flatland_teleop.robots import RobotTopic, next_topic, robot_topics

STATE = (
    [["/r2/cmd_vel", ["/move_base", "/teleop"]], ["/cmd_vel", ["/teleop"]]],
    [
        ["/r10/cmd_vel", ["/flatland_server"]],
        ["/r2/cmd_vel", ["/flatland_server"]],
        ["/scan", ["/rviz"]],
    ],
    [],
)
TYPES = [
    ["/r2/cmd_vel", "geometry_msgs/Twist"],
    ["/r10/cmd_vel", "geometry_msgs/Twist"],
    ["/cmd_vel", "geometry_msgs/Twist"],
    ["/scan", "sensor_msgs/LaserScan"],
]
TOPICS = [RobotTopic("/r2/cmd_vel", ("/move_base",)), RobotTopic("/r10/cmd_vel")]


def test_topics_with_subscribers_are_in_natural_order():
    assert robot_topics(STATE, TYPES, node="/teleop") == TOPICS


def test_the_next_topic_wraps_around_at_the_end():
    assert next_topic(TOPICS, "/r2/cmd_vel") == "/r10/cmd_vel"
    assert next_topic(TOPICS, "/r10/cmd_vel") == "/r2/cmd_vel"
    assert next_topic(TOPICS, "/cmd_vel") == "/r2/cmd_vel"
    assert next_topic([], "/cmd_vel") == "/cmd_vel"
