"""Prints the Python examples of a page of docs as one program, for tests and type checks.

usage: doc_program.py PAGE [--without NEED]

Line numbers are those of the page. A block that begins with `# needs: NEED` is left out on request.
"""

import re
import sys
from pathlib import Path
from typing import Container

BLOCK = re.compile(r"^```python\n(.*?)^```$", re.DOTALL | re.MULTILINE)


def program_of(page: str, without: Container[str] = ()) -> str:
    """The blocks of a page, with empty lines in place of all else."""
    lines = [""] * (page.count("\n") + 1)
    for block in BLOCK.finditer(page):
        code = block.group(1).splitlines()
        need = re.match(r"# needs: (\w+)", code[0])
        if need is None or need.group(1) not in without:
            first = page.count("\n", 0, block.start(1))
            lines[first : first + len(code)] = code
    return "\n".join(lines).rstrip() + "\n"


if __name__ == "__main__":
    print(program_of(Path(sys.argv[1]).read_text(encoding="utf-8"), sys.argv[3:]), end="")
