"""Measures Flatland: rosrun flatland_benchmark flatland_benchmark, or scripts/bench.

docs/speed.md describes the cases, and how to read and compare the figures.
"""
