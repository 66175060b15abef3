"""Crowd: people on their way to their goals, with and without random motion."""

import math
from typing import List

import numpy as np
import pytest
from townspeople import CALM, TAU, UPDATE, position, velocity, walk

# On the way


def test_speed_reaches_the_desired_one_by_the_relaxation_time(town):
    people = town("pose: [0, 0, 0], goals: [[100, 0], [0, 0]], speed: 1.2", keys=CALM)

    for update in range(1, 60):
        people.run(UPDATE)
        expected = 1.2 * (1.0 - math.exp(-update * UPDATE / TAU))
        assert velocity(people) == pytest.approx((expected, 0.0), abs=1e-5)
    # Box2D moves on at the velocity that each update ends with: 1.2 t less what is left over.
    updates = np.arange(1, 60)
    way = (1.2 * (1.0 - np.exp(-updates * UPDATE / TAU)) * UPDATE).sum()
    assert position(people) == pytest.approx((way, 0.0), abs=1e-3)


def test_goals_are_visited_in_turn_and_again(town):
    goals = [(3.0, 0.0), (3.0, 2.0), (0.0, 2.0)]
    people = town(
        f"pose: [0, 0, 0], goals: {[list(goal) for goal in goals]}", keys="goal_radius: 0.2"
    )

    path = walk(people, 25.0)[:, 0]

    visited: List[int] = []
    for point in path:
        near = [i for i, goal in enumerate(goals) if math.dist(point, goal) <= 0.2]
        if near and visited[-1:] != near:
            visited += near
    assert visited[:7] == [0, 1, 2, 0, 1, 2, 0]


def test_a_person_with_one_goal_stays_there(town):
    people = town("pose: [0, 0, 0], goals: [[3, 1]]")

    for seconds in (12.0, 5.0):
        assert position(people.run(seconds)) == pytest.approx((3.0, 1.0), abs=0.03)


def test_people_face_where_they_go_and_turn_slowly(town):
    people = town("pose: [0, 0, -1.5], goals: [[-9, 0], [9, 0]]", keys=CALM)
    headings = []

    for _ in range(100):
        headings.append(people.run(0.02).model("people_0").pose.yaw)

    turns = [math.remainder(b - a, math.tau) for a, b in zip(headings, headings[1:])]
    assert max(map(abs, turns)) == pytest.approx(math.pi * 0.02, rel=1e-3)
    assert math.remainder(headings[-1] - math.pi, math.tau) == pytest.approx(0.0, abs=1e-3)


def test_people_have_their_own_speeds_and_those_of_their_crowd(town):
    people = town(
        "pose: [0, 0, 0], goals: [[100, 0]]",
        "pose: [0, 3, 0], goals: [[100, 3]], speed: 2",
        keys="speed: 0.8, force: {noise: 0}",
    ).run(5.0)

    assert velocity(people, "people_0") == pytest.approx((0.8, 0.0), abs=1e-3)
    assert velocity(people, "people_1") == pytest.approx((2.0, 0.0), abs=1e-3)


@pytest.mark.slow
def test_noise_makes_people_sway_on_their_way(town):
    people = town("pose: [0, 0, 0], goals: [[1000, 0], [0, 0]]", keys="force: {noise: 0.1}")
    people.run(5.0)

    sideways = np.array([velocity(people.run(UPDATE))[1] for _ in range(4000)])

    # Values correlate over tau: some 4000 * 0.05 / (2 * 0.5) are independent, 5 % each way.
    assert sideways.std() == pytest.approx(0.1, rel=0.2)
    assert abs(sideways.mean()) < 0.03
