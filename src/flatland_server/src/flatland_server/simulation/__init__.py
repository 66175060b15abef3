"""The world, and stepping it at a rate of real time."""
