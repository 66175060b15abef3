"""For tests of plugins: worlds out of a few lines, simulated time, and the contract of plugins.

Nothing here needs pytest or a ROS master. A robot with a plugin, and its messages:

    from flatland_server.testing import robot

    def test_the_wall_is_two_metres_away():
        simulation = robot(
            "type: Laser, name: laser, body: base, range: 9, angle: {min: 0, max: 0, increment: 1}",
            walls=[(2, -1, 2, 1)],
        )
        simulation.run(0.1)
        assert round(simulation.last("/scan").ranges[0], 3) == 2.0

A wrong configuration: `refusal("type: Laser, name: laser, bdoy: base")` is the message. A whole
world, from a dict or YAML: `load({"layers": [...], "models": [...]})`, and `WorldFiles` for the
files that it names. The contract of all plugins: `check_plugin`.
"""

from flatland_server.testing.contract import PluginContractError, check_plugin
from flatland_server.testing.files import WorldFiles, load, refusal, robot
from flatland_server.testing.harness import Harness

__all__ = [
    "Harness",
    "PluginContractError",
    "WorldFiles",
    "check_plugin",
    "load",
    "refusal",
    "robot",
]
