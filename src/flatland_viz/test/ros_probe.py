#!/usr/bin/python3
"""A ROS node on a pipe: reads requests from stdin and writes answers to stdout, as lines of JSON.

pytest itself cannot be a node: a process can be one only once, with one master.
"""

import json
import sys

import genpy
import roslib.message
import rospy
import rosservice


def to_plain(value):
    """Converts messages into dicts and times into seconds."""
    if isinstance(value, genpy.TVal):
        return value.to_sec()
    if isinstance(value, genpy.Message):
        return {name: to_plain(getattr(value, name)) for name in value.__slots__}
    if isinstance(value, (list, tuple)):
        return [to_plain(item) for item in value]
    return value


def message(topic, kind, timeout):
    """The next message of a topic, or the latched one; None if none comes in time."""
    message_class = roslib.message.get_message_class(kind)
    try:
        return to_plain(rospy.wait_for_message(topic, message_class, timeout))
    except rospy.ROSException:
        return None


def call(service, arguments):
    """The answer of a service; None if it is not available."""
    service_class = rosservice.get_service_class_by_name(service)
    request = service_class._request_class()
    genpy.message.fill_message_args(request, arguments)
    try:
        return to_plain(rospy.ServiceProxy(service, service_class)(request))
    except rospy.ServiceException:
        return None


def main():
    rospy.init_node("gui_test", anonymous=True, disable_rostime=True, disable_signals=True)
    answers = {"message": message, "call": call}
    sys.stdout.write("ready\n")
    sys.stdout.flush()
    for line in sys.stdin:
        what, *arguments = json.loads(line)
        sys.stdout.write(json.dumps(answers[what](*arguments)) + "\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main()
