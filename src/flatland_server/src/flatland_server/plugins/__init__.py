"""Plugins: their base classes, how they are found, started, scheduled and called."""
