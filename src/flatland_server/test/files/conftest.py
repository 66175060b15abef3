"""Fixtures of the tests of files."""

from good_world import files, good_files

__all__ = ["files", "good_files"]
