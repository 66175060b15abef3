"""A transport within the process that serves other threads' calls at once."""

from flatland_server.transport.local_transport import LocalTransport
from flatland_server.transport.served_transport import ServedTransport


class DirectTransport(LocalTransport, ServedTransport):
    """Makes calls for the simulation's thread on the caller's."""

    can_forget = True

    def post(self, action):
        action()

    def end_error(self):
        return RuntimeError("the simulation has ended")

    def forget(self, publisher):
        self._last.pop(publisher._topic, None)
