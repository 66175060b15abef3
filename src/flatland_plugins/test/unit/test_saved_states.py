"""Runs that continue from a saved state, and runs after a reset: equal to the last bit."""

import subprocess
import sys
from pathlib import Path
from typing import Callable

import pytest
from busy_town import Town

PROGRAM = Path(__file__).with_name("busy_town.py")


@pytest.fixture
def make_town(tmp_path: Path) -> Callable[..., Town]:
    return lambda **options: Town(tmp_path, **options)


@pytest.mark.parametrize("seconds", [0.0, 0.305, 0.95, 3.0])
def test_a_run_goes_on_in_another_process_as_it_does_here(make_town, tmp_path, seconds):
    town = make_town().run(seconds)
    file = tmp_path / "state"
    file.write_bytes(town.simulation.save_state())

    arguments = [sys.executable, str(PROGRAM), str(tmp_path), str(file), "2.0"]
    there = subprocess.run(arguments, stdout=subprocess.PIPE, text=True, timeout=60, check=True)

    assert there.stdout.strip() == town.digest(2.0)


def test_a_state_can_be_loaded_again_and_again(make_town):
    town = make_town().run(1.0)
    state = town.simulation.save_state()
    first = town.digest(1.5)

    for _ in range(2):
        town.simulation.load_state(state)
        assert town.simulation.timekeeper.seconds == 1.0
        assert town.simulation.save_state() == state
        assert town.digest(1.5) == first


def test_after_a_reset_the_first_run_comes_again(make_town):
    town = make_town()
    first = town.digest(2.0)
    for _ in range(2):
        town.simulation.reset()
        assert town.digest(2.0) == first

    town.simulation.reset(seed=5)
    with_another_seed = town.digest(2.0)
    assert with_another_seed != first
    assert make_town(seed=5).digest(2.0) == with_another_seed
    town.simulation.reset()
    assert town.digest(2.0) == with_another_seed


def test_the_built_in_plugins_keep_their_state(make_town):
    assert make_town().simulation.world.plugins_without_state_hooks == []
