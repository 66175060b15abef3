"""The type of a case of a wrong file, and names that all cases use."""

from typing import Optional, Tuple, Union

WORLD, MAP, LINES, DATA = "world.yaml", "map.yaml", "lines.yaml", "lines.dat"
MODEL = "robot.model.yaml"

PLUGINS = (
    "AckermannDrive, BoolSensor, Bumper, Crowd, DiffDrive, DummyModelPlugin, DummyWorldPlugin, "
    "Gps, Imu, JointMotor, JointStatePublisher, Laser, ModelTfPublisher, OmniDrive, Pedestrian, "
    "PosePublisher, RandomWall, TricycleDrive, Tween"
)

# A mistake: the file, the text in it that is replaced (None is all of it), its replacement, and the
# whole message.
Case = Tuple[str, Optional[str], Union[str, bytes], str]
