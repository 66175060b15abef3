"""The plugins that publish each frame."""

import logging
from typing import Dict, List, Set, Tuple

from flatland_server.config.ros_names import FRAME, is_frame
from flatland_server.exceptions import TopicError, shortened

logger = logging.getLogger(__name__)


class FrameRegistry:
    """Finds frames with several publishers, and frames of odometry that several models share.

    TF is a tree: a frame with two publishers would jump between their poses. And if two robots
    share a frame of odometry, a localiser that corrects the odometry of one of them moves both.
    """

    def __init__(self) -> None:
        self._publishers: Dict[str, str] = {}  # by frame
        self._parents: Dict[str, str] = {}
        self._frames: Dict[str, List[str]] = {}  # by publisher
        self._warned: Set[Tuple[str, str]] = set()  # a frame and its second publisher
        self._odometry: Dict[str, Dict[str, None]] = {}  # publishers by frame, in their order
        self._odometry_of: Dict[str, List[str]] = {}  # the same frames by publisher
        self._warned_odometry: Set[str] = set()

    def claim(self, parent: str, child: str, publisher: str) -> None:
        """Registers the publisher of a frame; warns once if there is another one already.

        Args:
            parent: the frame that the transform is from.
            child: the frame that it places.
            publisher: a plugin, as `model/plugin` or the name of a plugin of the world.

        Raises:
            TopicError: TF cannot have a frame of one of these names.
        """
        if child not in self._publishers:
            for frame in (parent, child):
                if not is_frame(frame):
                    raise TopicError(f'expected {FRAME}, found "{shortened(frame)}"', frame)
        first = self._publishers.setdefault(child, publisher)
        if first == publisher:
            if child not in self._parents:
                self._frames.setdefault(publisher, []).append(child)
            self._parents[child] = parent
        elif (child, publisher) not in self._warned:
            self._warned.add((child, publisher))
            other = self._parents[child]
            conflict = f'from "{parent}"'
            if parent != other:
                conflict += f' and from "{other}", though a frame can have only one parent'
            logger.warning(
                'two plugins publish the frame "%s" %s: %s and %s; switch one of them off',
                child,
                conflict,
                first,
                publisher,
            )

    def claim_odometry(self, frame_id: str, publisher: str) -> None:
        """Registers the publisher of a transform from a frame of odometry to a model.

        Warns once for each frame if a plugin of another model has registered it already.

        Args:
            frame_id: the frame that odometry starts from, such as "odom".
            publisher: a plugin, as `model/plugin`.
        """
        publishers = self._odometry.setdefault(frame_id, {})
        if publisher not in publishers:
            publishers[publisher] = None
            self._odometry_of.setdefault(publisher, []).append(frame_id)
        first = next(iter(publishers))
        if _model_of(first) == _model_of(publisher) or frame_id in self._warned_odometry:
            return
        self._warned_odometry.add(frame_id)
        logger.warning(
            'two models share the odometry frame "%s": %s and %s publish transforms from it; '
            'write "odom_frame_id: ~odom" in the model file and give each model a namespace, '
            "so that each has a frame <namespace>_odom",
            frame_id,
            first,
            publisher,
        )

    def take_over_warnings(self, former: "FrameRegistry") -> None:
        """Suppresses warnings that the registry of the same world has given before a reset."""
        self._warned |= former._warned
        self._warned_odometry |= former._warned_odometry

    @property
    def odometry_frames(self) -> Set[str]:
        """The frames of odometry in use."""
        return set(self._odometry)

    def release(self, publisher: str) -> None:
        """Removes the frames of a publisher."""
        children = self._frames.pop(publisher, [])
        for child in children:
            del self._publishers[child]
            del self._parents[child]
        if children and self._warned:
            self._warned = {pair for pair in self._warned if pair[0] in self._publishers}
        for frame_id in self._odometry_of.pop(publisher, []):
            publishers = self._odometry[frame_id]
            del publishers[publisher]
            if not publishers:
                del self._odometry[frame_id]
                self._warned_odometry.discard(frame_id)


def _model_of(publisher: str) -> str:
    return publisher.rpartition("/")[0]
