"""The joints of a drive's wheels, which tell where these are."""

import math
from typing import Any, Optional, Tuple

from flatland_server import REQUIRED, Joint, ModelBody, ModelPlugin, Point, YamlReader

TOLERANCE = 1e-3
"""Tolerance of positions [m], and of right angles [rad]."""


def get_wheel(
    drive: ModelPlugin,
    config: YamlReader,
    key: str,
    body: ModelBody,
    kind: str,
    default: Any = REQUIRED,
) -> Optional[Tuple[Joint, Point]]:
    """A wheel's joint, and its anchor on the driven body.

    Args:
        drive: the drive of the model.
        config: the drive's entry in the model file, for problems.
        key: key with the name of the joint.
        body: body that the drive moves.
        kind: type of the joint: revolute or weld.
        default: see `ModelPlugin.get_joint`.
    """
    joint = drive.get_joint(config, key, default)
    if joint is None:
        return None
    if joint.config.type != kind:
        config.problem(f"expected a {kind} joint, found a {joint.config.type} joint", key)
    if body.name not in joint.config.bodies:
        names = " and ".join(joint.config.bodies)
        config.problem(f'expected a joint of "{body.name}", found one of {names}', key)
        return None
    on_body = joint.config.bodies.index(body.name)
    x, y = joint.config.anchors[1 - on_body]
    if math.hypot(x, y) > TOLERANCE:
        config.problem(
            f"expected the anchor on the wheel at its origin, found it at [{x:g}, {y:g}]", key
        )
    return joint, joint.config.anchors[on_body]
