"""Reads YAML files into checked values: includes, Lua expressions, errors with file and line."""
