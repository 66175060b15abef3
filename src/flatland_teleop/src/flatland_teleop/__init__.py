"""Drives robots by hand."""
