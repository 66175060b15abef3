"""The command `flatland`: checks, draws, runs and shows worlds without ROS."""

from flatland2d.cli.command import main

__all__ = ["main"]
