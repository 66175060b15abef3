"""Steps in few calls of the core: equal to single steps, to the last bit."""

import random
import re

import busy_town
import pytest
from busy_town import Town

pytestmark = pytest.mark.slow

SOME_TOPICS = ("/anna/scan", "/bert/odometry/filtered", "/late/imu/filtered", "/box1/collisions")


BUMPERS = re.compile(r"  - {type: Bumper, .*}\n")
"""Bumpers are called at every step, so that no steps can be combined."""


def advance(town: Town, steps: int, at_once: bool) -> int:
    """Makes steps, up to the next event of the town. Returns the number of calls of the world."""
    town.act()
    run = town.simulation
    calls = 0
    while steps > 0:
        calls += 1
        run.transport.process()
        if at_once:
            steps -= run._step_up_to(steps)
        else:
            run._step_with_hooks()
            steps -= 1
    return calls


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("topics", [None, (), SOME_TOPICS], ids=["all", "none", "some"])
def test_steps_at_once_are_those_that_are_made_one_by_one(tmp_path, monkeypatch, topics, seed):
    for model in ("ROBOT", "BOX"):
        text = BUMPERS.sub("", getattr(busy_town, model))
        text = text.replace("name: touch}", "name: touch, update_rate: 36}")
        slower = re.sub(r"_rate: (\d+)", lambda rate: f"_rate: {int(rate[1]) / 4}", text)
        monkeypatch.setattr(busy_town, model, slower)
    rng = random.Random(seed)
    single, many = (Town(tmp_path, seed, subscribed_topics=topics) for _ in range(2))
    calls = steps = 0
    for _ in range(30):
        count = rng.choice([10, 10, 10, 20, 30])
        if rng.random() < 0.3:
            some = rng.choice([topics, (), rng.sample(SOME_TOPICS, 2)])
            for town in (single, many):
                town.transport.set_subscribed_topics(some)
        while count > 0:
            advance(single, 10, at_once=False)
            calls += advance(many, 10, at_once=True)
            steps, count = steps + 10, count - 10
            assert many.motion() == single.motion()
        assert many.transport.digest.digest() == single.transport.digest.digest()
        if rng.random() < 0.2:
            assert many.simulation.save_state() == single.simulation.save_state()

    assert many.simulation.save_state() == single.simulation.save_state()
    assert calls < 0.8 * steps
