"""Sweeps: worlds x controllers x parameters x seeds, run in processes or on Ray."""

from flatland2d.sweep.run import SweepRun

__all__ = ["SweepRun"]
