"""All cases: importing the modules registers them."""

from flatland_benchmark import (  # noqa: F401
    batch_cases,
    gate_case,
    gym_cases,
    plugin_cases,
    ray_cases,
    server_cases,
    start_case,
    state_cases,
    sweep_cases,
)
from flatland_benchmark.case import CASES

__all__ = ["CASES"]
