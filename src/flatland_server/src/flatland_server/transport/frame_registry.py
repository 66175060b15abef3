"""Which plugin publishes which frame."""

import logging
from typing import Dict, List, Set, Tuple

logger = logging.getLogger(__name__)


class FrameRegistry:
    """Finds frames with several publishers, and frames of odometry that several models share.

    TF is a tree: a frame with two publishers would jump between them. And where two robots have one
    frame of odometry, a localiser that corrects the odometry of one of them moves both.
    """

    def __init__(self) -> None:
        self._publishers: Dict[str, str] = {}  # by frame
        self._parents: Dict[str, str] = {}
        self._warned: Set[Tuple[str, str]] = set()  # a frame and its second publisher
        self._odometry: Dict[str, List[str]] = {}  # publishers by frame
        self._warned_odometry: Set[str] = set()

    def claim(self, parent: str, child: str, publisher: str) -> None:
        """Registers the publisher of a frame; warns once if there is another one already.

        Args:
            parent: the frame that the transform is from.
            child: the frame that it places.
            publisher: a plugin, as `model/plugin` or the name of a plugin of the world.
        """
        first = self._publishers.setdefault(child, publisher)
        if first == publisher:
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
        publishers = self._odometry.setdefault(frame_id, [])
        publishers.append(publisher)
        first = publishers[0]
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
        """Does not repeat what the registry of the same world before a reset has warned of."""
        self._warned |= former._warned
        self._warned_odometry |= former._warned_odometry

    @property
    def odometry_frames(self) -> Set[str]:
        """The frames of odometry in use."""
        return set(self._odometry)

    def release(self, publisher: str) -> None:
        """Removes the frames of a publisher."""
        for child in [child for child, each in self._publishers.items() if each == publisher]:
            del self._publishers[child]
        self._warned = {pair for pair in self._warned if pair[0] in self._publishers}
        for frame_id, publishers in list(self._odometry.items()):
            left = [each for each in publishers if each != publisher]
            self._odometry[frame_id] = left
            if not left:
                del self._odometry[frame_id]
        self._warned_odometry &= self._odometry.keys()


def _model_of(publisher: str) -> str:
    return publisher.rpartition("/")[0]
