"""The world, its steps, and the loop that runs it in real time."""
