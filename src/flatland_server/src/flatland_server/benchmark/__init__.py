"""Measures Flatland: rosrun flatland_server flatland_benchmark, or scripts/bench.

docs/speed.md says what each case is, and how to read and compare the figures.
"""
