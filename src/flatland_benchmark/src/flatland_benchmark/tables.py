"""The table of every benchmark, in Markdown."""

from typing import Union


def row(*cells: Union[str, float], names: int = 1) -> str:
    """A row; its first cells are names, the others are on the right. Numbers have four digits."""
    texts = (cell if isinstance(cell, str) else _digits(cell) for cell in cells)
    padded = (f"{text:<26}" if i < names else f"{text:>13}" for i, text in enumerate(texts))
    return f"| {' | '.join(padded)} |"


def _digits(number: float) -> str:
    return f"{number:,.0f}" if abs(number) >= 1000 else f"{number:.4g}"


def head(*cells: str, names: int = 1) -> str:
    """The row of headings, and the line below it."""
    return f"{row(*cells, names=names)}\n|{' --- |' * names}{' ---: |' * (len(cells) - names)}"
