"""The examples of docs/batches.md run, one after the other."""

import re
from pathlib import Path

DOC = Path(__file__).resolve().parents[4] / "docs" / "batches.md"


def test_the_examples_run():
    text = DOC.read_text(encoding="utf-8")
    examples = list(re.finditer(r"```python\n(.*?)```", text, re.DOTALL))
    names = {}

    for example in examples:
        line = text[: example.start(1)].count("\n")
        code = compile("\n" * line + example[1], str(DOC), "exec")  # with the page's line numbers
        exec(code, names)

    assert len(examples) >= 6
