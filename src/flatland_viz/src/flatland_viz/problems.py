"""The problems reported to the window, each once, with a count."""

from typing import Dict, Iterable, List, NamedTuple, Sequence, Set, Tuple

from flatland_viz.model_list import Model


class Problem(NamedTuple):
    """A warning or an error."""

    source: str
    """The source of the report, such as the name of a node."""
    text: str
    is_error: bool
    times: int
    """Number of reports; 1 for a lasting state."""
    time: float
    """Simulated time of the last report [s]."""


Key = Tuple[str, str]  # source and text


class Problems:
    """Collects the problems of groups.

    Clearing removes all; one is shown again when it has ended and begun again, or when it was
    reported more often.
    """

    def __init__(self) -> None:
        self._problems: Dict[Key, Problem] = {}  # the latest last
        self._reported: Dict[str, Dict[Key, Problem]] = {}  # by group

    def report(self, group: str, problems: Iterable[Problem]) -> None:
        """Reports all problems of a group that there are now, the latest last.

        Args:
            group: name of an independent reporter.
            problems: the group's problems.
        """
        present = {(problem.source, problem.text): problem for problem in problems}
        former = self._reported.get(group, {})
        for key in former.keys() - present.keys():
            self._problems.pop(key, None)
        for key, problem in present.items():
            if key not in former or problem.times != former[key].times:
                self._problems.pop(key, None)
                self._problems[key] = problem
        self._reported[group] = present

    def clear(self) -> None:
        """Removes all problems."""
        self._problems.clear()

    @property
    def latest_first(self) -> List[Problem]:
        """All problems."""
        return list(reversed(self._problems.values()))

    @property
    def has_errors(self) -> bool:
        """True if one of them is an error."""
        return any(problem.is_error for problem in self._problems.values())


def summary(text: str) -> str:
    """A text on one line; a traceback is reduced to its first line and the exception."""
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    has_traceback = any(line.startswith("Traceback (") for line in lines)
    return f"{lines[0]}: {lines[-1]}" if has_traceback else " ".join(lines)


def shared_commands(models: Iterable[Model]) -> List[str]:
    """Warnings about robots that share a topic of commands."""
    names: Dict[str, List[str]] = {}
    for model in models:
        names.setdefault(model.command_topic, []).append(model.name)
    return [
        f"{listed(sharing)} subscribe to {topic}: one command drives them all; "
        "give each a namespace"
        for topic, sharing in names.items()
        if topic and len(sharing) > 1
    ]


def listed(names: Sequence[str]) -> str:
    """Names as a list in a sentence, four items at most."""
    few = [*names[:3], f"{len(names) - 3} others"] if len(names) > 4 else names
    return f"{', '.join(few[:-1])} and {few[-1]}"


def frames_published_twice(seen: Iterable[Tuple[str, str, str]]) -> List[str]:
    """Warnings about frames that several nodes publish.

    Args:
        seen: parent, child and the node that publishes it, of transforms.
    """
    nodes: Dict[str, Set[str]] = {}
    parents: Dict[str, Set[str]] = {}
    for parent, child, node in seen:
        nodes.setdefault(child, set()).add(node)
        parents.setdefault(child, set()).add(parent)
    texts = []
    for child in sorted(nodes):
        if len(nodes[child]) > 1:
            names = " and ".join(sorted(nodes[child]))
            frames = " and ".join(f'"{parent}"' for parent in sorted(parents[child]))
            texts.append(f'{names} publish the frame "{child}" from {frames}; switch one off')
    return texts
