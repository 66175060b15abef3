"""The guide does what it says: each page's blocks are run in order, in a folder of its own."""

import os
import re
import subprocess
import time
import xmlrpc.client

import pytest
from blocks import blocks_of
from page_run import ROOT, PageError, PageRun
from ros_processes import free_port

DOCS = ROOT / "docs"
PAGES = [page for page in sorted(DOCS.rglob("*.md")) if blocks_of(page)]
ROS = re.compile(r"^\$ .*\b(?:ros\w+|python3 \w+\.py)\b", re.MULTILINE)
MODULES = {"learning.md": "gymnasium", "tutorials/training.md": "gymnasium"}
"""What pages need as a whole."""


def name_of(page):
    return str(page.relative_to(DOCS))


def needs_master(page):
    return any(
        block.language == "console" and not block.note("not run:") and ROS.search(block.text)
        for block in blocks_of(page)
    )


@pytest.fixture(scope="module")
def master():
    """A ROS master that the pages share, one after the other."""
    port = free_port()
    process = subprocess.Popen(
        ["rosmaster", "--core", "-p", str(port)],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    proxy = xmlrpc.client.ServerProxy(f"http://127.0.0.1:{port}")
    deadline = time.monotonic() + 30.0
    while True:
        try:
            proxy.getPid("/guide")
            break
        except OSError:
            assert time.monotonic() < deadline, "waited for the ROS master"
            time.sleep(0.02)
    yield proxy, f"http://127.0.0.1:{port}"
    process.terminate()
    process.wait(10)


@pytest.fixture
def environment(tmp_path_factory):
    """That of a reader: a home, the workspace, and the command `flatland` of the tutorials."""
    home = tmp_path_factory.mktemp("home")
    command = home / "flatland"
    command.write_text('#!/bin/sh\nexec /usr/bin/python3 -m flatland_server "$@"\n')
    command.chmod(0o755)
    path = f"{home}:{os.environ['PATH']}"
    return {**os.environ, "HOME": str(home), "ROS_HOME": str(home / "ros"), "PATH": path}


def run(page, folder, environment, request):
    if name_of(page) in MODULES:
        pytest.importorskip(MODULES[name_of(page)])
    if needs_master(page):
        proxy, uri = request.getfixturevalue("master")
        environment["ROS_MASTER_URI"] = uri
        for parameter in proxy.getParamNames("/guide")[2]:  # of the page before
            if parameter not in ("/run_id", "/rosdistro", "/rosversion"):
                proxy.deleteParam("/guide", parameter)
    PageRun(page, folder, environment).run()


@pytest.mark.slow
@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_the_page_does_what_it_says(page, tmp_path, environment, request):
    run(page, tmp_path, environment, request)


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
        ("```bash\nls\n```\n", 'a reason to leave a "bash" block out'),
        ("```yaml\n# file: a.model.yaml\nbodies: []\n```\n", "a.model.yaml: .*bodies"),
        ("<!-- part of: README.md -->\n```python\nno_such_thing\n```\n", "has no such part"),
    ],
    ids=["output", "exit code", "python", "language", "yaml", "excerpt"],
)
def test_a_block_that_does_otherwise_is_an_error(text, message, tmp_path):
    page = tmp_path / "page.md"
    page.write_text(text)
    folder = tmp_path / "folder"
    folder.mkdir()

    with pytest.raises(PageError, match=f"(?s){message}"):
        PageRun(page, folder, os.environ).run()
