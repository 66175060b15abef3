"""The guide does what it says: each page's blocks are run in order, in a folder of its own.

Tutorials have a file of their own, for another process to run.
"""

import os

import pytest
from blocks import blocks_of
from page_run import ROOT, PageError, PageRun

DOCS = ROOT / "docs"
PAGES = [page for page in sorted(DOCS.rglob("*.md")) if blocks_of(page)]


@pytest.mark.slow
@pytest.mark.parametrize(
    "page",
    [page for page in PAGES if page.parent.name != "tutorials"],
    ids=lambda page: str(page.relative_to(DOCS)),
)
def test_the_page_does_what_it_says(page, run_page):
    run_page(page)


def test_what_is_not_run_says_why():
    reasons = [block.note("not run:") for page in PAGES for block in blocks_of(page)]

    assert all(len(reason.split()) >= 2 for reason in reasons if reason)
    assert sum(map(bool, reasons)) < 0.1 * len(reasons)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("```console\n$ echo a\nb\n```\n", "the page shows\nb"),
        ("```console\n$ false\n```\n", "ended with 1, not 0"),
        ("```python\nassert 1 == 2\n```\n", "AssertionError"),
        ("```bash\nls\n```\n", 'a reason to leave this "bash" block out'),
        ("```yaml\nbodies: []\n```\n", "expected the name of a file"),
        ("```yaml\n# file: a.model.yaml\nbodies: []\n```\n", "a.model.yaml: .*bodies"),
        ("<!-- part of: README.md -->\n```python\nno_such_thing\n```\n", "has no such part"),
    ],
    ids=["output", "exit code", "python", "language", "no file", "yaml", "excerpt"],
)
def test_a_block_that_does_otherwise_is_an_error(text, message, tmp_path):
    page = tmp_path / "page.md"
    page.write_text(text)
    folder = tmp_path / "folder"
    folder.mkdir()

    with pytest.raises(PageError, match=f"(?s){message}"):
        PageRun(page, folder, os.environ).run()
