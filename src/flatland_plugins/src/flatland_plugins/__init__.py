"""Flatland's own plugins, found by name through flatland_plugins.xml."""
