"""Services of time and state that are refused."""

import pytest
from direct_transport import DirectTransport

from flatland_server.exceptions import FlatlandError
from flatland_server.hub.client_files import ClientFiles
from flatland_server.hub.hub import Hub
from flatland_server.hub.state_services import StateServices
from flatland_server.simulation.simulation_manager import SimulationManager
from flatland_server.simulation.world import World
from flatland_server.simulation.world_config import WorldConfig
from flatland_server.timekeeper import Timekeeper


class RunsSteps(DirectTransport):
    """Makes the steps that calls ask for, too."""

    manager = None

    def wait(self, future):
        self.manager.run(lambda: not future.done())
        return super().wait(future)


@pytest.fixture
def serve(files):
    """Returns the manager and the services of a world without models."""

    def serve_with(step_size, *settings):
        transport = RunsSteps()
        path = files.write("a.yaml", "properties: {}\nlayers: []\n")
        world = World(WorldConfig.from_file(path), transport)
        transport.manager = manager = SimulationManager(world, Timekeeper(step_size))
        hub = Hub(manager, ClientFiles(world, None))
        StateServices(hub, *settings)
        return manager, {name: service.action for name, service in hub.services.items()}

    return serve_with


def test_a_control_period_that_is_no_whole_steps_is_refused(serve):
    expected = "expected ~control_period to be a multiple of the step_size of 0.03 s, found 0.1 s"
    with pytest.raises(FlatlandError, match=expected):
        serve(0.03, 0.1)


@pytest.mark.parametrize(
    ("step_size", "advance"), [(0.005, 0.1), (0.1, 0.1), (0.2, 0.2), (0.03, 0.03)]
)
def test_step_world_makes_one_step_if_0_1_s_is_no_multiple(serve, step_size, advance):
    manager, actions = serve(step_size)
    manager.pause()

    actions["step_world"](None)

    assert manager.timekeeper.seconds == pytest.approx(advance)


def test_step_world_keeps_the_pause_state_except_in_train_mode(serve):
    manager, actions = serve(0.2)
    actions["step_world"](None)
    assert not manager.is_paused

    manager, actions = serve(0.2, None, True)
    assert manager.is_paused
    actions["step_world"](None)
    assert manager.is_paused
    manager.resume()  # by another client
    actions["step_world"](None)
    assert manager.is_paused


def test_a_pause_while_step_world_makes_its_steps_stays(serve):
    manager, actions = serve(0.01)
    manager.after_step.append(manager.pause)

    with pytest.raises(FlatlandError, match="paused before the steps were made"):
        actions["step_world"](None)

    assert manager.is_paused
    assert manager.timekeeper.seconds == pytest.approx(0.01)


def test_a_slow_reload_does_not_replace_a_newer_world(serve, files, monkeypatch):
    """A request for the first world is still reading its file when the second one is there."""
    manager, actions = serve(0.005)
    first = manager.world.config
    second = WorldConfig.from_file(files.write("b.yaml", "properties: {}\nlayers: []\n"))
    monkeypatch.setattr(manager.world, "read_config", lambda: manager.reload(second) or first)

    with pytest.raises(FlatlandError, match="another world was loaded while the file was read"):
        actions["reload_world"](None)

    assert manager.world.config is second
