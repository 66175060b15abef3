"""Flatland's window, built on rviz."""
