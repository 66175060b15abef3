"""The table of every benchmark, in Markdown."""

from typing import Union


def row(*cells: Union[str, float]) -> str:
    """A row: texts on the left, and numbers of four digits on the right."""
    texts = [f"{cell:<26}" if isinstance(cell, str) else f"{cell:>10,.4g}" for cell in cells]
    return f"| {' | '.join(texts)} |"


def head(*cells: str) -> str:
    """The row of headings, and the line below it."""
    return f"{row(*cells)}\n|{' --- |' * len(cells)}"
