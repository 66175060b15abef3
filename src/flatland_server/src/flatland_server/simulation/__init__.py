"""The world, its steps, and running it at a rate of real time."""
