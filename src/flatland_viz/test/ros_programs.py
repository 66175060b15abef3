"""A ROS master, programs that use it, and their topics and services by sockets."""

import math
import os
import select
import signal
import subprocess
import time
from contextlib import suppress
from pathlib import Path

import genpy
import roslib.message
import tcpros_client
from flatland_msgs import srv
from gui_screen import wait_until
from ros_processes import executable
from running_server import Master
from rviz.srv import SendFilePath
from std_srvs.srv import Empty

SERVICES = {
    "/delete_model": srv.DeleteModel,
    "/move_model": srv.MoveModel,
    "/pause": Empty,
    "/reset": srv.Reset,
    "/resume": Empty,
    "/rviz/load_config_discarding_changes": SendFilePath,
    "/spawn_model": srv.SpawnModel,
}
SLOW = {"update_rate": 50, "step_size": 0.02, "viz_pub_rate": 10}
"""Parameters and arguments of the server that save processor time, of the window's too."""
LOOK_PERIOD = 0.2  # s: interval of requests to the master for the publishers of a topic


def to_plain(value):
    """Converts messages into dicts and times into seconds."""
    if isinstance(value, genpy.TVal):
        return value.to_sec()
    if isinstance(value, genpy.Message):
        return {name: to_plain(getattr(value, name)) for name in value.__slots__}
    if isinstance(value, (list, tuple)):
        return [to_plain(item) for item in value]
    return value


class Ros:
    """A ROS master, programs that use it, and their topics and services.

    Args:
        environment: the programs' environment.
        logs: folder for their output.

    Attributes:
        frame_rate: how often the window draws [Hz]. Without a graphics card each frame takes much
            of a core.
    """

    frame_rate = 5

    def __init__(self, environment, logs):
        self.master = Master()
        self._logs = logs
        self._programs = []
        self._log_files = {}  # by process
        self._publishers = {}  # by topic
        self.environment = {**environment, "ROS_MASTER_URI": self.master.uri, "ROS_IP": "127.0.0.1"}
        # Before any node starts: a node that finds it unset uses real time.
        self.set_parameter("/use_sim_time", True)
        self.set_parameter("/flatland_viz/frame_rate", self.frame_rate)

    def set_parameter(self, name, value):
        """Sets a parameter of the ROS master."""
        self.master.ask("setParam", name, value)

    def close(self):
        for program in reversed(self._programs):
            self.end(program)
        self.master.kill()

    def start(self, *command):
        """Start a program; its output goes to a file."""
        log = self._logs / f"{len(self._programs)}_{Path(command[0]).name}.log"
        with log.open("w") as file:
            program = subprocess.Popen(
                list(map(str, command)),
                env=self.environment,
                stdin=subprocess.DEVNULL,
                stdout=file,
                stderr=subprocess.STDOUT,
                start_new_session=True,
                # A shell that starts pytest in the background has SIGINT ignored; a user's has not.
                preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
            )
        self._programs.append(program)
        self._log_files[program.pid] = log
        return program

    def start_node(self, package, node, *arguments):
        """Start a node of a package."""
        return self.start(executable(package, node), *arguments)

    def publish_transform(self, parent, child, *arguments):
        """Start a node that publishes the identity between two frames."""
        pose = (0, 0, 0, 0, 0, 0)
        return self.start_node(
            "tf2_ros", "static_transform_publisher", *pose, parent, child, *arguments
        )

    def log(self, program):
        """The output of a program so far."""
        return self._log_files[program.pid].read_text()

    def start_server(self, world, **parameters):
        """Start the server alone; returns when the simulation runs."""
        values = {"show_viz": True, **SLOW, **parameters}
        program = self.start_node(
            *("flatland_server", "flatland_server", "__name:=flatland_server"),
            f"_world_path:={world}",
            *(f"_{name}:={str(value).lower()}" for name, value in values.items()),
        )
        self.wait_for_clock(program)
        return program

    def launch(self, run, *arguments):
        """Start scripts/run by a fixture, on this master; returns when the simulation runs."""
        slow = [f"{name}:={value}" for name, value in SLOW.items()]
        launch = run(
            *(*arguments, *slow),
            port=self.master.port,
            with_port=False,
            environment=self.environment,
        )
        launch.wait_for("running")
        return launch

    def start_window(self, *arguments):
        """Start the window alone."""
        return self.start(*self.window_command(), *arguments)

    def window_command(self):
        """The command that opens the window."""
        return [executable("flatland_viz", "flatland_viz")]

    def wait_for_clock(self, program):
        """Wait until the simulation started by a program runs."""

        def has_come():
            assert program.poll() is None, [log.read_text() for log in self._logs.glob("*.log")]
            return self.message("/clock", "rosgraph_msgs/Clock", timeout=1)

        wait_until(has_come, "the server to run")

    def end(self, program, number=signal.SIGINT):
        if program.poll() is None:
            os.killpg(program.pid, number)
            try:
                program.wait(15)
            except subprocess.TimeoutExpired:
                os.killpg(program.pid, signal.SIGKILL)
                program.wait()

    def message(self, topic, kind, timeout=5):
        """The next message of a topic, or its latched one; None if there is none."""
        return next(self.messages(topic, kind, timeout, self._known(topic)), None)

    def _known(self, topic):
        """The URIs of a topic's publishers, from the last answer of the master."""
        return self._publishers.get(topic, ())

    def messages(self, topic, kind, seconds, known=()):
        """Yields the messages of a topic that come within some time, from any of its publishers.

        The master is slow to answer. It is asked for publishers every `LOOK_PERIOD`, and at once
        unless a connection to a known one succeeds.

        Args:
            topic: name of the topic, with or without a leading "/".
            kind: the type of its messages.
            seconds: how long [s].
            known: URIs of nodes that may publish it.
        """
        message_type = roslib.message.get_message_class(kind)
        now = time.monotonic()
        end = now + seconds
        connections = {}  # by the URI of the publisher
        try:
            for uri in known:
                self._connect(connections, uri, topic, message_type)
            next_look = now + LOOK_PERIOD if connections else now
            while now < end:
                if now >= next_look:
                    self._publishers[topic] = self._find_publishers(topic)
                    for uri in self._publishers[topic]:
                        self._connect(connections, uri, topic, message_type)
                    next_look = now + LOOK_PERIOD
                ready, _, _ = select.select(list(connections.values()), [], [], 0.1)
                for connection in ready:
                    try:
                        message = tcpros_client.next_message(connection, message_type)
                    except OSError:  # the publisher has ended
                        connections = {u: c for u, c in connections.items() if c != connection}
                        connection.close()
                    else:
                        yield to_plain(message)
                now = time.monotonic()
        finally:
            for connection in connections.values():
                connection.close()

    def _find_publishers(self, topic):
        """The URIs of the nodes that publish a topic."""
        publishers = dict(self.master.ask("getSystemState")[0])
        uris = [self.master.ask("lookupNode", node) for node in publishers.get(topic, ())]
        return [uri for uri in uris if uri]

    def _connect(self, connections, uri, topic, message_type):
        """Connects to a publisher of a topic, unless that is done or it does not accept it."""
        if uri not in connections:
            with suppress(OSError, AssertionError):  # it has ended, or not yet begun
                connections[uri] = tcpros_client.subscribe(uri, topic, message_type)

    def call(self, service_name, **arguments):
        """The answer of a service; None if it is not available."""
        service = SERVICES[service_name]
        request = service._request_class()
        genpy.message.fill_message_args(request, [arguments] if arguments else [])
        fields = {field: getattr(request, field) for field in request.__slots__}
        uri = self.master.ask("lookupService", service_name)
        try:
            return to_plain(tcpros_client.call_service(uri, service_name, service, **fields))
        except OSError:
            return None

    def state(self):
        return self.message("/flatland_server/state", "flatland_msgs/SimulationState")

    def clock(self):
        """Simulated time [s]."""
        return self.message("/clock", "rosgraph_msgs/Clock")["clock"]

    def models(self):
        """The names of the models in the world."""
        topics = self.message("/flatland_server/debug/topics", "flatland_msgs/DebugTopicList")
        return [topic[6:] for topic in topics["topics"] if topic.startswith("model/")]

    def pose(self, model):
        """Position [m] and yaw [rad] of the model's first marker.

        A reset deletes markers first: a message may have none.
        """
        topic = f"/flatland_server/debug/model/{model}"
        known = self._known(topic)
        added = (
            marker["pose"]
            for message in self.messages(topic, "visualization_msgs/MarkerArray", 5, known)
            for marker in message["markers"]
            if marker["action"] == 0
        )
        pose = next(added, None)
        assert pose, f"no marker on {topic}"
        rotation = pose["orientation"]
        yaw = 2 * math.atan2(rotation["z"], rotation["w"])
        return pose["position"]["x"], pose["position"]["y"], yaw

    def spawn(self, file, name, x, y, theta=0.0):
        pose = {"x": x, "y": y, "theta": theta}
        answer = self.call("/spawn_model", yaml_path=str(file), name=name, ns="", pose=pose)
        assert answer["success"], answer["message"]
