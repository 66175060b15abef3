"""The guide works as written: each page's blocks are run in order, in a folder of its own.

Tutorials have a file of their own, for another process to run.
"""

import os
import re
import subprocess

import pytest
from blocks import blocks_of, needs_of
from console import commands_of
from page_run import ROOT, PageError, PageRun

DOCS = ROOT / "docs"
PAGES = [page for page in sorted(DOCS.rglob("*.md")) if blocks_of(page)]


@pytest.mark.slow
@pytest.mark.parametrize(
    "page",
    [
        page
        for page in PAGES
        if page.parent.name != "tutorials" and getattr(needs_of(page), "ros", True)
    ],
    ids=lambda page: str(page.relative_to(DOCS)),
)
def test_the_page_does_what_it_says(page, run_page):
    """Pages that need only pip are run in test/pip."""
    run_page(page)


def test_each_page_and_example_says_what_it_needs():
    """Except for the pages that explain the installations."""
    explained = [DOCS / "install.md", DOCS / "tutorials" / "index.md"]
    pages = [*PAGES, *(ROOT / "examples").glob("*/README.md")]
    silent = [page for page in pages if page not in explained and needs_of(page) is None]

    assert silent == []


def test_each_command_pastes_into_an_interactive_shell():
    """Each is complete, and has no prompts, tabs or exclamation marks."""
    commands = [
        command
        for page in PAGES
        for block in blocks_of(page)
        if block.language == "bash"
        for command in commands_of(block.text)
    ]
    wrong = [each for each in commands if re.match(r"[$>] ", each) or "\t" in each or "!" in each]
    # An incomplete command would swallow the end of its function.
    functions = "".join(f"f() {{\n{each}\n}}\n" for each in commands)
    result = subprocess.run(["bash", "-n"], input=functions, stderr=subprocess.PIPE, text=True)

    assert len(commands) > 80
    assert wrong == []
    assert result.stderr == ""


def test_a_block_that_is_not_run_says_why():
    blocks = [block for page in PAGES for block in blocks_of(page)]
    reasons = [block.note("not run:") for block in blocks]

    assert "console" not in {block.language for block in blocks}  # prompts do not paste
    assert all(len(reason.split()) >= 2 for reason in reasons if reason)
    assert sum(map(bool, reasons)) < 0.12 * len(reasons)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("```bash\necho a\n```\n\n```output\nb\n```\n", "the page shows\nb"),
        ("```bash\necho a\n```\n", "the page shows\nnothing"),
        ("```bash\nfalse\n```\n", "ended with 1, not 0"),
        ("```console\n$ echo a\na\n```\n", 'expected commands as "bash"'),
        ("```python\nassert 1 == 2\n```\n", "AssertionError"),
        ("```cpp\nint a;\n```\n", 'a reason to leave this "cpp" block out'),
        ("```yaml\nbodies: []\n```\n", "expected the name of a file"),
        ("```yaml\n# file: a.model.yaml\nbodies: []\n```\n", "a.model.yaml: .*bodies"),
        ("<!-- part of: README.md -->\n```python\nno_such_thing\n```\n", "has no such part"),
    ],
    ids=[
        "output",
        "no output",
        "exit code",
        "console",
        "python",
        "language",
        "no file",
        "yaml",
        "excerpt",
    ],
)
def test_a_block_with_another_result_is_an_error(text, message, tmp_path):
    page = tmp_path / "page.md"
    page.write_text(text)
    folder = tmp_path / "folder"
    folder.mkdir()

    with pytest.raises(PageError, match=f"(?s){message}"):
        PageRun(page, folder, os.environ).run()
