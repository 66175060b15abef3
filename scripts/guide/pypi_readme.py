"""Makes README's links absolute: PyPI shows the page, and has no other file of the repository.

usage: pypi_readme.py README REPOSITORY TAG    REPOSITORY as `git remote get-url` prints it
"""

import re
import sys
from pathlib import Path

LINK = re.compile(r"(!?)(\[[^\]]*\])\((?!\w+:|#)([^)]+)\)")


def absolute(text: str, repository: str, tag: str) -> str:
    """The page with links to a repository's web pages, and to its pictures, at a tag."""
    url = re.sub(r"^(?:ssh://)?git@([^:/]+)[:/]", r"https://\1/", repository)
    url = re.sub(r"(?:\.git)?/?$", "", url)

    def rewrite(match: "re.Match[str]") -> str:
        kind = "raw" if match[1] else "blob"
        return f"{match[1]}{match[2]}({url}/{kind}/{tag}/{match[3]})"

    return LINK.sub(rewrite, text)


if __name__ == "__main__":
    readme = Path(sys.argv[1])
    readme.write_text(absolute(readme.read_text(encoding="utf-8"), *sys.argv[2:]), encoding="utf-8")
