"""Reads maps into wall segments: images and lists of line segments."""
