"""Plugins for Flatland in a package of their own."""
