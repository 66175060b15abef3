"""The argument --param, of commands that read files without a ROS master."""

import argparse
from typing import Any, Tuple

import yaml


def add_params(parser: argparse.ArgumentParser) -> None:
    """Adds `--param NAME=VALUE`, which may be repeated: `params` is a list of such pairs."""
    parser.add_argument(
        "--param",
        dest="params",
        type=_pair,
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="a parameter for expressions and plugins, with a value in YAML: --param robots=3",
    )


def _pair(text: str) -> Tuple[str, Any]:
    name, separator, value = text.partition("=")
    try:
        if name and separator:
            return name.rstrip(":"), yaml.safe_load(value)  # `:=` as for a node
    except yaml.YAMLError:
        pass
    raise argparse.ArgumentTypeError(f'expected NAME=VALUE with a value in YAML, found "{text}"')
