"""Plugins: their base classes, and how they are found, made, scheduled and called."""
