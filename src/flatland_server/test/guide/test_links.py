"""No dead link: in docs, between docs, code and README, to files and to headings."""

import os
import re
import subprocess
from fnmatch import fnmatch
from pathlib import Path

import pytest
from blocks import blocks_of
from page_run import ROOT
from pypi_readme import absolute

LINK = re.compile(r"!?\[[^\]]*\]\(([^)\s]+)\)")
FENCE = re.compile(r"^ *```.*?^ *```$", re.DOTALL | re.MULTILINE)
CODE = re.compile(r"`([\w/]+\.(?:py|cpp|hpp|js))`")
MENTION = re.compile(r"\bdocs/[\w/]+\.(?:md|png|svg)\b")


def files_of_the_repository():
    """Their paths. Git is not asked: an archive of the repository has no .git."""
    ignored = [line.strip("/") for line in (ROOT / ".gitignore").read_text().split()] + [".git"]
    found = []
    for folder, folders, names in os.walk(ROOT):
        for some in (folders, names):
            some[:] = [name for name in some if not any(fnmatch(name, each) for each in ignored)]
        found += [str(Path(folder, name).relative_to(ROOT)) for name in names]
    return sorted(found)


FILES = files_of_the_repository()
PAGES = [ROOT / name for name in FILES if name.endswith(".md")]


def anchors_of(page):
    """The headings of a page, as forges name them."""
    text = FENCE.sub("", page.read_text(encoding="utf-8"))
    found = []
    for heading in re.findall(r"^#+ (.+)$", text, re.MULTILINE):
        plain = re.sub(r"[`*]|\[([^\]]+)\]\([^)]*\)", r"\1", heading).strip().lower()
        found.append(re.sub(r"[^\w\- ]", "", plain).replace(" ", "-"))
    return found


def dead_links(page):
    text = FENCE.sub("", page.read_text(encoding="utf-8"))
    dead = []
    for target in LINK.findall(text):
        if re.match(r"[a-z]+:", target):
            continue
        name, _, anchor = target.partition("#")
        path = (page.parent / name).resolve() if name else page
        if not path.exists() or (anchor and anchor not in anchors_of(path)):
            dead.append(target)
    return dead


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_each_link_leads_somewhere(page):
    assert dead_links(page) == []


@pytest.mark.parametrize(
    "page", sorted((ROOT / "docs/how_it_works").glob("*.md")), ids=lambda page: page.stem
)
def test_each_file_of_code_that_a_page_names_exists(page):
    named = CODE.findall(page.read_text(encoding="utf-8"))

    assert [
        name for name in named if not any(f"/{each}".endswith(f"/{name}") for each in FILES)
    ] == []


def test_readme_has_no_relative_link_on_pypi():
    text = absolute((ROOT / "README.md").read_text(encoding="utf-8"), "git@host.org:a/b.git", "v1")
    relative = [link for link in LINK.findall(text) if not re.match(r"https://|#", link)]

    assert relative == []
    assert "](https://host.org/a/b/raw/v1/docs/images/office.png)" in text
    assert "](https://host.org/a/b/blob/v1/docs/index.md)" in text


def test_each_page_that_code_and_scripts_name_exists():
    kinds = (".py", ".launch", ".xml", ".yaml", ".cpp", ".hpp", ".txt", ".toml")
    dead = []
    for name in FILES:
        path = ROOT / name
        if path.is_file() and (path.suffix in kinds or name.startswith("scripts/")):
            text = path.read_text(encoding="utf-8", errors="replace")
            dead += [
                f"{name}: {word}" for word in MENTION.findall(text) if not (ROOT / word).exists()
            ]

    assert dead == []


def test_each_picture_is_on_a_page():
    text = "".join(page.read_text(encoding="utf-8") for page in PAGES)
    pictures = [path.name for path in (ROOT / "docs" / "images").iterdir()]

    assert [name for name in pictures if name not in text] == []


def test_each_picture_can_be_made_again():
    """One script names all of them; drawings are written by hand."""
    command = [ROOT / "scripts" / "pictures", "--list"]
    listed = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True).stdout
    folders = ("docs/", "examples/", "README")
    kinds = (".png", ".gif", ".jpg", ".webp")
    pictures = [name for name in FILES if name.startswith(folders) and name.endswith(kinds)]

    assert sorted(listed.split()) == sorted(pictures)


def test_no_two_tutorials_have_different_files_of_one_name():
    """They are done in one folder, and some use files of earlier ones."""
    files = {}
    for page in sorted((ROOT / "docs" / "tutorials").glob("*.md")):
        for block in blocks_of(page):
            if block.file:
                files.setdefault(block.file, set()).add((page.name, block.text))

    assert {name: pages for name, pages in files.items() if len(pages) > 1} == {}


def test_a_page_is_read_in_five_minutes():
    """At 300 words a minute, code and tables left out: those are looked at."""
    long = {}
    for page in sorted((ROOT / "docs").rglob("*.md")):
        text = FENCE.sub("", page.read_text(encoding="utf-8"))
        text = re.sub(r"^(?:\||\*\*Needs).*$", "", text, flags=re.M)
        if "reference" not in page.parts and len(text.split()) > 1500:
            long[page.name] = len(text.split())

    assert long == {}


@pytest.mark.parametrize(
    "question",
    [
        "second lidar",
        "robot does not move",
        "initial pose",
        "headless",
        "random free place",
        "ground truth",
        "own map",
        "docker",
        "moving obstacle",
        "teleport",
        "rotate map",
        "two lidars",
        "ackermann",
        "slow",
        "namespace",
        "gazebo",
        "stage",
        "noise",
        "tf tree",
        "odom drift",
        "save map",
        "ros2 nav2",
    ],
)
def test_common_questions_are_found_by_a_heading(question):
    """The site's search prefers headings with words that begin so."""
    pages = [ROOT / "docs" / name for name in ("how_do_i.md", "coming_from.md")]
    text = FENCE.sub("", "\n".join(page.read_text(encoding="utf-8") for page in pages))
    headings = [re.findall(r"\w+", line.lower()) for line in re.findall(r"^## (.+)$", text, re.M)]

    assert any(
        all(any(each.startswith(word) for each in heading) for word in question.split())
        for heading in headings
    )
