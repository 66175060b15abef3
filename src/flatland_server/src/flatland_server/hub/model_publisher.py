"""Publishes the models and their states, for windows and tools.

`~models` (latched) describes the models: files, namespaces, bodies, plugins and their topics.
`~model_states` has their ground truth while it has subscribers: models that have moved at a rate of
real time, and all models once a second. A message without models means that all of them rest.
"""

import time
from typing import Any, Dict, List, Tuple

from flatland_server.messages import fill_twist, ros_time
from flatland_server.messages.message_types import get
from flatland_server.models.footprint import Circle
from flatland_server.models.model import Model
from flatland_server.models.model_body import BodyConfig
from flatland_server.plugins.plugin import Plugin
from flatland_server.real_time_timer import RealTimeTimer
from flatland_server.simulation.simulation_manager import SimulationManager

BodyInfo = get("flatland_msgs/BodyInfo")
ColorRGBA = get("std_msgs/ColorRGBA")
ModelInfo = get("flatland_msgs/ModelInfo")
ModelList = get("flatland_msgs/ModelList")
ModelState = get("flatland_msgs/ModelState")
ModelStates = get("flatland_msgs/ModelStates")
PluginInfo = get("flatland_msgs/PluginInfo")
Pose2D = get("geometry_msgs/Pose2D")
TopicInfo = get("flatland_msgs/TopicInfo")

_FULL_PERIOD = 1.0  # s of real time, after which models at rest are published again


class ModelPublisher:
    """Publishes flatland_msgs/ModelList and flatland_msgs/ModelStates.

    Args:
        manager: simulation with the models.
        rate: how often the states of moving models are published [Hz of real time].
    """

    def __init__(self, manager: SimulationManager, rate: float) -> None:
        self._manager = manager
        self._timer = RealTimeTimer(1.0 / rate)
        self._described: List[object] = [None]  # the content of the last list; none so far
        self._sent: Dict[Model, Tuple[Any, ...]] = {}  # motion of each model in the last message
        self._next_full = 0.0
        self._subscriber_revision: object = None
        self._stamp = -1  # simulated time of the last message [ns]
        node, advertise = manager.transport.node_name, manager.transport.advertise
        self._list = advertise(f"{node}/models", ModelList, latch=True, queue_size=1)
        self._states = advertise(f"{node}/model_states", ModelStates, latch=False, queue_size=1)
        self._publish_list()

    def update(self) -> None:
        """Publishes what is due. To be called often, on the simulation's thread."""
        if self._timer.check_update():
            self._publish_list()
            self._publish_states()

    def _publish_list(self) -> None:
        world = self._manager.world
        models = world.models.values()
        described: List[object] = [
            *models,
            *(model.footprint_revision for model in models),
            *world.plugin_failures,
        ]
        if len(described) == len(self._described) and all(
            one is other or one == other for one, other in zip(described, self._described)
        ):
            return
        self._described = described
        self._list.publish(
            ModelList([_model_info(model, world.all_plugins_of(model.name)) for model in models])
        )

    def _publish_states(self) -> None:
        if not self._states.has_subscribers:
            return
        revision, before = self._manager.transport.subscriber_revision, self._subscriber_revision
        self._subscriber_revision = revision
        now = time.monotonic()
        if revision != before or now >= self._next_full:
            self._next_full = now + _FULL_PERIOD
            self._sent.clear()
        motions = {model: _motion(model) for model in self._manager.world.models.values()}
        moved = [model for model in motions if self._sent.get(model) != motions[model]]
        self._sent = motions
        now_simulated = self._manager.timekeeper.nanoseconds
        if moved or now_simulated != self._stamp:
            self._stamp = now_simulated
            stamp = ros_time(now_simulated)
            self._states.publish(ModelStates(stamp, [_model_state(model) for model in moved]))


def _motion(model: Model) -> Tuple[Any, ...]:
    """The poses of a model's bodies, and the velocity of its base."""
    poses = [body.pose for body in model.physics_bodies]
    return (*poses, model.base.physics_body.local_velocity)


def _model_state(model: Model) -> Any:
    state = ModelState(name=model.name, pose=Pose2D(*model.pose))
    fill_twist(state.twist, *model.base.physics_body.local_velocity)
    state.bodies = [Pose2D(*body.pose) for body in model.bodies.values()]
    return state


def _model_info(model: Model, plugins: List[Tuple[Plugin, bool]]) -> Any:
    config = model.config
    is_of_file = config.is_read and config.content is None
    return ModelInfo(
        name=model.name,
        ns=model.namespace,
        yaml_path=str(config.path.resolve()) if is_of_file else "",
        bodies=[
            _body_info(body, "" if model.has_own_tf else model.name_space_tf(body.name))
            for body in config.bodies
        ],
        plugins=[_plugin_info(plugin, has_failed) for plugin, has_failed in plugins],
    )


def _body_info(config: BodyConfig, frame_id: str) -> Any:
    corners = []
    for footprint in config.footprints:
        shape = footprint.shape
        if isinstance(shape, Circle):
            (x, y), radius = shape.center, shape.radius
            corners += [(x - radius, y - radius), (x + radius, y + radius)]
        else:
            corners += shape.vertices
    xs, ys = zip(*(corners or [(0.0, 0.0)]))
    box = (min(xs), min(ys), max(xs), max(ys))
    return BodyInfo(config.name, frame_id, *box, ColorRGBA(*config.color))


def _plugin_info(plugin: Plugin, has_failed: bool) -> Any:
    topics = [TopicInfo(*topic) for topic in plugin.node.topics]
    return PluginInfo(plugin.name, plugin.type, has_failed, topics)
