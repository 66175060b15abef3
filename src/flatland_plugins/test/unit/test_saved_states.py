"""Runs that continue from a saved state, and runs after a reset: equal to the last bit."""

import os
import subprocess
import sys
from pathlib import Path
from typing import Callable, Optional

import pytest
from busy_town import Town

pytestmark = pytest.mark.slow

PROGRAM = Path(__file__).with_name("busy_town.py")


def digest_elsewhere(
    folder: Path, *arguments: str, hash_seed: str = "random", cores: Optional[int] = None
) -> str:
    """The output of `busy_town.py` in a process of its own."""

    def keep_to_cores() -> None:
        os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[:cores])

    result = subprocess.run(
        [sys.executable, str(PROGRAM), str(folder), *arguments],
        env={**os.environ, "PYTHONHASHSEED": hash_seed},
        preexec_fn=keep_to_cores,
        stdout=subprocess.PIPE,
        text=True,
        timeout=120,
        check=True,
    )
    return result.stdout.strip()


@pytest.fixture
def make_town(tmp_path: Path) -> Callable[..., Town]:
    return lambda **options: Town(tmp_path, **options)


@pytest.fixture(scope="module")
def first_run(tmp_path_factory: pytest.TempPathFactory) -> str:
    """The digest of the first two seconds."""
    return Town(tmp_path_factory.mktemp("town")).digest(2.0)


@pytest.mark.parametrize("seconds", [0.0, 0.305, 0.95, 3.0])
def test_a_run_goes_on_in_another_process_as_it_does_here(make_town, tmp_path, seconds):
    town = make_town().run(seconds)
    file = tmp_path / "state"
    file.write_bytes(town.simulation.save_state())

    assert digest_elsewhere(tmp_path, "1.2", str(file)) == town.digest(1.2)


@pytest.mark.parametrize(("hash_seed", "cores"), [("0", 1), ("1", None)], ids=str)
def test_a_run_is_the_same_in_every_process(first_run, make_town, tmp_path, hash_seed, cores):
    """This process has another hash seed. For a longer run: busy_town.py FOLDER 60."""
    make_town()  # writes its files

    assert digest_elsewhere(tmp_path, "2.0", hash_seed=hash_seed, cores=cores) == first_run


def test_subscribers_change_nothing_but_what_they_receive(make_town):
    everything, nothing = make_town().run(1.2), make_town(subscribed_topics=[]).run(1.2)
    scans = make_town(subscribed_topics=["/anna/scan"]).run(1.2)

    changing = make_town()
    for topics in (None, [], ["/anna/scan"], None) * 2:
        changing.transport.set_subscribed_topics(topics)
        changing.run(0.15)

    assert everything.motion() == nothing.motion() == scans.motion() == changing.motion()
    assert nothing.transport.count == 0
    assert str(scans.simulation.last("/anna/scan")) == str(everything.simulation.last("/anna/scan"))


def test_a_state_can_be_loaded_again_and_again(make_town):
    town = make_town().run(1.0)
    assert town.simulation.world.plugins_without_state_hooks == []
    state = town.simulation.save_state()
    first = town.digest(1.0)

    for _ in range(2):
        town.simulation.load_state(state)
        assert town.simulation.timekeeper.seconds == 1.0
        assert town.simulation.save_state() == state
        assert town.digest(1.0) == first


def test_after_a_reset_the_first_run_comes_again(first_run, make_town):
    town = make_town().run(1.3)
    for _ in range(2):
        town.simulation.reset()
        assert town.digest(2.0) == first_run

    town.simulation.reset(seed=5)
    with_another_seed = town.digest(1.2)
    assert with_another_seed != make_town().digest(1.2)
    assert make_town(seed=5).digest(1.2) == with_another_seed
    town.simulation.reset()
    assert town.digest(1.2) == with_another_seed
