"""Makes a site of docs/ and examples/. Their pages are written for a forge.

The site has docs/ as its root, and examples/ in it. Links that lead out of both become the names
of files.
"""

import os
import re
from pathlib import Path
from typing import Any

from mkdocs.structure.files import File

ROOT = Path(__file__).resolve().parents[2]
LINK = re.compile(r"(!?)\[([^\]]+)\]\(((?!\w+:)[^)#\s]+)((?:#[^)]*)?)\)")
COMMENT = re.compile(r"^<!-- (?!file: ).*?-->\n", re.MULTILINE)  # but not in a file's block
BOOSTS = {
    "how_do_i": 4.0,
    "ros2": 6.0,
    "reference/python/": 0.1,
    "reference/messages": 0.3,
    "how_it_works/": 0.3,
}
"""Weights of pages in search, by the beginnings of their paths: answers first, details last."""


def on_files(files: Any, config: Any, **_: Any) -> Any:
    """Adds the examples: their pages, pictures and files."""
    for path in sorted((ROOT / "examples").rglob("*")):
        if path.suffix in (".md", ".png"):
            name = path.relative_to(ROOT).as_posix()
            files.append(File.generated(config, name, abs_src_path=str(path)))
    return files


def on_page_markdown(markdown: str, page: Any, files: Any, **_: Any) -> str:
    """Rewrites links between docs/ and the rest, and weighs the page for search."""
    source = page.file.src_uri
    for beginning, boost in BOOSTS.items():
        if source.startswith(beginning):
            page.meta["search"] = {"boost": boost}
    folder = os.path.dirname(source if source.startswith("examples/") else f"docs/{source}")

    def rewrite(match: "re.Match[str]") -> str:
        path = os.path.normpath(os.path.join(folder, match[3]))
        for name in (path, f"{path}/README.md"):
            target = name[len("docs/") :] if name.startswith("docs/") else name
            if files.get_file_from_path(target):
                link = os.path.relpath(target, os.path.dirname(source))
                return f"{match[1]}[{match[2]}]({link}{match[4]})"
        if path.startswith("docs/"):
            return match[0]  # dead: MkDocs reports it
        return match[2] if match[2].strip("`") == path else f"{match[2]} (`{path}`)"

    return LINK.sub(rewrite, COMMENT.sub("", markdown))
