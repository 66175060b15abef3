"""Pictures of a world: arrays, PNG and SVG files, and the notebook's inline pictures."""
