"""Flatland's view on the world."""
