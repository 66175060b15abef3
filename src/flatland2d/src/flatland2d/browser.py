"""Opens pages in the user's browser."""

import os
import sys
import threading
import webbrowser


def open_in_browser(url: str) -> None:
    """Prints the address of a page, and opens it in the user's browser.

    Without a screen, a line says so: the browsers that Python knows there would take the terminal.

    Args:
        url: of a page that is served already.
    """
    print(f"page: {url}", flush=True)
    screens = ("BROWSER", "DISPLAY", "WAYLAND_DISPLAY")
    if sys.platform == "linux" and not any(map(os.environ.get, screens)):
        _say_that_none_opens()
    else:
        threading.Thread(target=_open, args=(url,), daemon=True).start()


def _open(url: str) -> None:
    if not webbrowser.open(url):
        _say_that_none_opens()


def _say_that_none_opens() -> None:
    print("no browser can be opened here: open the address in one", file=sys.stderr, flush=True)
