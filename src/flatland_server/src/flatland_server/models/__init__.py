"""The parts of a world: layers, and models with their bodies, footprints and joints."""
