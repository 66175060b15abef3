"""Which plugin publishes which frame."""

import logging
from typing import Dict, List, Set, Tuple

from flatland_server.config.ros_names import FRAME, is_frame
from flatland_server.exceptions import TopicError, shortened

logger = logging.getLogger(__name__)


class FrameRegistry:
    """Finds frames with several publishers. TF is a tree: such a frame would jump between them."""

    def __init__(self) -> None:
        self._publishers: Dict[str, str] = {}  # by frame
        self._parents: Dict[str, str] = {}
        self._frames: Dict[str, List[str]] = {}  # by publisher
        self._warned: Set[Tuple[str, str]] = set()  # a frame and its second publisher

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

    def release(self, publisher: str) -> None:
        """Removes the frames of a publisher."""
        children = self._frames.pop(publisher, [])
        for child in children:
            del self._publishers[child]
            del self._parents[child]
        if children and self._warned:
            self._warned = {pair for pair in self._warned if pair[0] in self._publishers}
