"""What MkDocs does to a page besides: links that lead out of docs/ become the names of files.

On a forge, such a link opens the file. The site has only docs/.
"""

import os
import re
from typing import Any

LINK = re.compile(r"\[([^\]]+)\]\(((?:\.\./)+[^)#]+)(?:#[^)]*)?\)")
COMMENT = re.compile(r"^<!-- (?!file: ).*?-->\n", re.MULTILINE)  # but not in a file's block


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:
    """Rewrites the links of a page that lead out of docs/."""
    folder = os.path.dirname(page.file.src_uri)

    def rewrite(match: "re.Match[str]") -> str:
        path = os.path.normpath(os.path.join("docs", folder, match[2]))
        if path.startswith("docs/"):
            return match[0]
        return match[1] if match[1].strip("`") == path else f"{match[1]} (`{path}`)"

    return LINK.sub(rewrite, COMMENT.sub("", markdown))
