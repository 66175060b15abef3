"""The services of ROS's node `rosapi`, by which clients of rosbridge look around."""

from typing import Any, Callable, Dict, List, Mapping

from flatland_bridge.graph import BridgeError, Graph
from flatland_bridge.plain_form import parse_type, to_plain
from flatland_server.messages.definition import NUMBERS
from flatland_server.messages.message_types import get
from flatland_server.messages.service_types import get as get_service

Arguments = Mapping[str, Any]

NODE = "/flatland_server"


class RosApi:
    """Answers the services `/rosapi/...` about a graph.

    Attributes:
        services: what each answers, by its name: from the fields of a request to those of a
            response.
    """

    def __init__(self, graph: Graph) -> None:
        self._graph = graph
        actions: Dict[str, Callable[[Arguments], Dict[str, Any]]] = {
            "action_servers": lambda _: {"action_servers": []},
            "get_param_names": lambda _: {"names": []},
            "get_ros_version": lambda _: {"version": 1, "distro": "noetic"},
            "get_time": self._get_time,
            "has_param": lambda _: {"exists": False},
            "get_param": lambda asked: {"value": asked.get("default", "") or "null"},
            "message_details": lambda asked: _details(get(_text(asked, "type"))),
            "node_details": self._node_details,
            "nodes": lambda _: {"nodes": [NODE]},
            "publishers": lambda asked: {"publishers": _nodes(asked, graph.topics.published)},
            "service_host": lambda asked: {"host": "localhost"},
            "service_node": lambda asked: {"node": NODE},
            "service_request_details": lambda asked: _details(self._service(asked).request),
            "service_response_details": lambda asked: _details(self._service(asked).response),
            "service_type": self._service_type,
            "services": lambda _: {"services": list(graph.services)},
            "services_for_type": self._services_for_type,
            "subscribers": lambda asked: {"subscribers": _nodes(asked, graph.topics.subscribed)},
            "topic_type": lambda asked: {"type": graph.topics.types.get(_text(asked, "topic"), "")},
            "topics": self._topics,
            "topics_and_raw_types": self._topics_and_raw_types,
            "topics_for_type": self._topics_for_type,
        }
        self.services = {f"/rosapi/{name}": action for name, action in actions.items()}

    def _get_time(self, asked: Arguments) -> Dict[str, Any]:
        seconds, nanoseconds = divmod(self._graph.nanoseconds, 1_000_000_000)
        return {"time": {"secs": seconds, "nsecs": nanoseconds}}

    def _topics(self, asked: Arguments) -> Dict[str, Any]:
        types = self._graph.topics.types
        return {"topics": list(types), "types": list(types.values())}

    def _topics_and_raw_types(self, asked: Arguments) -> Dict[str, Any]:
        texts = [get(kind)._full_text for kind in self._graph.topics.types.values()]
        return {**self._topics(asked), "typedefs_full_text": texts}

    def _topics_for_type(self, asked: Arguments) -> Dict[str, Any]:
        kind, types = _text(asked, "type"), self._graph.topics.types
        return {"topics": [topic for topic, each in types.items() if each == kind]}

    def _node_details(self, asked: Arguments) -> Dict[str, Any]:
        topics, services = self._graph.topics, self._graph.services
        if _text(asked, "node") != NODE:
            return {"subscribing": [], "publishing": [], "services": []}
        return {
            "subscribing": list(topics.subscribed),
            "publishing": list(topics.published),
            "services": list(services),
        }

    def _service_type(self, asked: Arguments) -> Dict[str, Any]:
        service = self._graph.services.get(_text(asked, "service"))
        return {"type": service.name if service else ""}

    def _services_for_type(self, asked: Arguments) -> Dict[str, Any]:
        kind, services = _text(asked, "type"), self._graph.services
        return {"services": [name for name, each in services.items() if each.name == kind]}

    def _service(self, asked: Arguments) -> Any:
        return get_service(_text(asked, "type"))


def _text(asked: Arguments, name: str) -> str:
    value = asked.get(name)
    if not isinstance(value, str):
        raise BridgeError(f'expected the argument "{name}" as a string')
    return value


def _nodes(asked: Arguments, topics: Mapping[str, str]) -> List[str]:
    return [NODE] if _text(asked, "topic") in topics else []


def _details(message_type: Any) -> Dict[str, Any]:
    """The fields of a message type, and of those that it uses."""
    typedefs: List[Dict[str, Any]] = []
    waiting, seen = [message_type], {message_type._type}
    while waiting:
        kind = waiting.pop(0)
        fields = [parse_type(each) for each in kind._slot_types]
        lengths = [each.length or 0 if each.is_array else -1 for each in fields]
        typedefs.append(
            {
                "type": kind._type,
                "fieldnames": list(kind.__slots__),
                "fieldtypes": [each.base for each in fields],
                "fieldarraylen": lengths,
                "examples": [
                    "[]" if each.is_array else _example(each.base, kind(), name)
                    for name, each in zip(kind.__slots__, fields)
                ],
                "constnames": [],
                "constvalues": [],
            }
        )
        for each in fields:
            if "/" in each.base and each.base not in seen:
                seen.add(each.base)
                waiting.append(get(each.base))
    return {"typedefs": typedefs}


def _example(base: str, message: Any, name: str) -> str:
    if "/" in base:
        return "{}"
    return str(to_plain(message)[name]) if base in NUMBERS or base == "string" else "{}"
