"""The plugins that do nothing: found by both forms of their names, with any keys."""

import pytest

from flatland_server.testing import Harness, WorldFiles

KEYS = "name: dummy, dummy_param_string: dummy_test_123456, dummy_param_float: 0.1, a: [{b: c}]"
DISC = "bodies: [{name: base, footprints: [{type: circle, radius: 0.1, density: 1}]}]"


@pytest.mark.parametrize("package", ["", "flatland_plugins::"])
def test_they_take_any_keys_and_do_nothing(package, tmp_path):
    files = WorldFiles(tmp_path)
    files.write("disc.yaml", f"{DISC}\nplugins: [{{type: {package}DummyModelPlugin, {KEYS}}}]")
    simulation: Harness = files.load(
        f"""
        properties: {{}}
        layers: []
        models: [{{name: disc, model: disc.yaml}}]
        plugins: [{{type: {package}DummyWorldPlugin, {KEYS}}}]
        """
    )

    simulation.run(0.1)

    assert simulation.world.plugin_count == 2
    assert not simulation.world.transport.topics
    simulation.world.close()
