"""Topics and services of a simulation for other programs: rosbridge, Foxglove, a page."""
