"""Each tutorial arrives at what it shows."""

import pytest
from blocks import blocks_of
from page_run import ROOT

PAGES = [page for page in sorted((ROOT / "docs/tutorials").glob("*.md")) if blocks_of(page)]


@pytest.mark.slow
@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_the_tutorial_arrives(page, run_page):
    run_page(page)
