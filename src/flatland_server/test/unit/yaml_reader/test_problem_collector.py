"""ProblemCollector: problems of a document, of its sections and of the entries of its lists."""

from pathlib import Path

import pytest

from flatland_server.config.problem_collector import MutedCollector, ProblemCollector
from flatland_server.exceptions import YamlError


def error(message: str) -> YamlError:
    return YamlError(Path("file.yaml"), message)


def messages(collector: ProblemCollector) -> list:
    """The messages of the error that the collector would raise; empties it."""
    return [problem.message for problem in collector.take().problems]


def test_a_new_collector_is_empty():
    assert ProblemCollector().is_empty


def test_problems_are_taken_once_and_in_the_order_in_which_they_were_noted():
    collector = ProblemCollector()
    for message in ("second key", "first key", "second key"):
        collector.note(error(message))

    assert messages(collector) == ["second key", "first key"]
    assert collector.is_empty


def test_an_error_of_several_problems_is_noted_with_all_of_them():
    collector = ProblemCollector()

    collector.note(YamlError.of([*error("a").problems, *error("b").problems]))

    assert messages(collector) == ["a", "b"]


def test_a_part_knows_only_its_own_problems():
    collector = ProblemCollector()
    collector.note(error("before"))

    with collector.part() as part:
        assert part.is_empty
        part.note(error("within"))
        assert not part.is_empty


def test_the_problems_of_a_part_are_added_when_it_ends():
    collector = ProblemCollector()
    collector.note(error("before"))

    with collector.part() as part:
        part.note(error("noted"))
        raise error("raised")

    collector.note(error("after"))
    assert messages(collector) == ["before", "noted", "raised", "after"]


def test_a_part_that_raises_what_it_noted_is_added_once():
    collector = ProblemCollector()

    with collector.part() as part:
        part.note(error("noted"))
        raise part.take()

    assert messages(collector) == ["noted"]


def test_a_cleared_part_adds_nothing():
    collector = ProblemCollector()

    with collector.part() as part:
        part.note(error("noted"))
        part.clear()

    assert collector.is_empty


def test_a_problem_that_a_part_notes_after_its_end_is_its_own():
    collector = ProblemCollector()
    with collector.part() as part:
        pass

    part.note(error("later"))

    assert collector.is_empty
    assert messages(part) == ["later"]


def test_another_exception_than_a_yaml_error_passes_through():
    with pytest.raises(KeyError), ProblemCollector().part():
        raise KeyError("key")


def test_a_muted_collector_raises_the_documents_problems_and_adds_none():
    collector = ProblemCollector()
    collector.note(error("the section is missing"))
    muted = MutedCollector(collector)

    muted.note(error("its key is missing"))

    assert not muted.is_empty
    assert messages(muted) == ["the section is missing"]
