"""The services of ROS's node `rosapi`, by which clients of rosbridge look around."""

from contextlib import suppress
from typing import Any, Callable, Dict, List, Mapping

import orjson

from flatland_bridge.client_messages import decoded, field, name_of
from flatland_bridge.graph import BridgeError, Graph
from flatland_bridge.plain_form import parse_type, to_plain
from flatland_server.messages import NUMBERS, get, service_types

Arguments = Mapping[str, Any]


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
            "delete_param": self._delete_param,
            "get_param": self._get_param,
            "get_param_names": lambda _: {"names": graph.parameters.names()},
            "get_ros_version": lambda _: {"version": 1, "distro": "noetic"},
            "get_time": self._get_time,
            "has_param": lambda asked: {"exists": self._parameter(asked, None) is not None},
            "message_details": lambda asked: _details(get(_text(asked, "type"))),
            "node_details": self._node_details,
            "nodes": self._nodes,
            "publishers": lambda asked: {
                "publishers": graph.nodes.publishers.get(_text(asked, "topic"), [])
            },
            "search_param": self._search_param,
            "service_host": lambda asked: {"host": "localhost"},
            "service_node": lambda asked: {
                "node": graph.nodes.services.get(_text(asked, "service"), [""])[0]
            },
            "service_providers": self._service_providers,
            "service_request_details": lambda asked: _details(self._service(asked).request),
            "service_response_details": lambda asked: _details(self._service(asked).response),
            "service_type": self._service_type,
            "services": lambda _: {"services": list(graph.services)},
            "services_for_type": lambda asked: {"services": self._of_type(_text(asked, "type"))},
            "set_param": self._set_param,
            "subscribers": lambda asked: {
                "subscribers": graph.nodes.subscribers.get(_text(asked, "topic"), [])
            },
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

    def _nodes(self, asked: Arguments) -> Dict[str, Any]:
        of_all = (names for part in self._graph.nodes for names in part.values())
        return {"nodes": sorted({name for names in of_all for name in names})}

    def _node_details(self, asked: Arguments) -> Dict[str, Any]:
        node, keys = _text(asked, "node"), ("publishing", "subscribing", "services")
        return {
            key: [name for name, nodes in part.items() if node in nodes]
            for key, part in zip(keys, self._graph.nodes)
        }

    def _service_type(self, asked: Arguments) -> Dict[str, Any]:
        service = self._graph.services.get(_text(asked, "service"))
        return {"type": service.name if service else ""}

    def _of_type(self, kind: str) -> List[str]:
        return [name for name, each in self._graph.services.items() if each.name == kind]

    def _service_providers(self, asked: Arguments) -> Dict[str, Any]:
        """The nodes that offer services of a type, which rosapi calls "service"."""
        nodes = self._graph.nodes.services
        of_type = self._of_type(_text(asked, "service"))
        return {"providers": sorted({node for name in of_type for node in nodes.get(name, ())})}

    def _service(self, asked: Arguments) -> Any:
        return service_types.get(_text(asked, "type"))

    # Parameters: values are JSON in texts

    def _parameter(self, asked: Arguments, default: Any) -> Any:
        return self._graph.parameters.get(name_of(asked, "name"), default)

    def _get_param(self, asked: Arguments) -> Dict[str, Any]:
        default: Any = asked.get("default") or None
        with suppress(BridgeError):  # a text without quotes
            default = decoded(default) if isinstance(default, str) else default
        value = self._parameter(asked, default)
        return {"value": orjson.dumps(value, default=str, option=orjson.OPT_NON_STR_KEYS).decode()}

    def _search_param(self, asked: Arguments) -> Dict[str, Any]:
        name_of(asked, "name")  # checks it
        return {"global_name": self._graph.parameters.search(_text(asked, "name"))}

    def _set_param(self, asked: Arguments) -> Dict[str, Any]:
        self._graph.parameters.set(name_of(asked, "name"), decoded(_text(asked, "value")))
        return {}

    def _delete_param(self, asked: Arguments) -> Dict[str, Any]:
        self._graph.parameters.delete(name_of(asked, "name"))
        return {}


def _text(asked: Arguments, name: str) -> str:
    return field(asked, name, str)


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
