"""The controller that avoids collisions by ORCA, in the canonical scenes."""

import pytest

from flatland2d.sweep.runner import ScenarioRunner
from flatland2d.sweep.settings import scenarios_of

CALL = '[{name: a, call: "flatland2d.sweep.orca:orca"}]'


@pytest.mark.parametrize(
    ("world", "goal"),
    [("corridor_frontal", "[6, 0]"), ("overtaking", "[6, 0]"), ("circle_crossing", "[-4, 0]")],
)
def test_it_reaches_the_goal_among_people_who_do_not_give_way(settings_of, world, goal):
    settings = settings_of(
        worlds=f"[{world}]", controllers=CALL, seeds=2, start=None, goal=goal, time_limit=60
    )
    runner = ScenarioRunner(settings)
    results = [runner.run(each) for each in scenarios_of(settings)]

    assert [each.error for each in results] == ["", ""]
    assert [each.row["outcome"] for each in results] == ["goal", "goal"]
