"""YAML files into checked values: includes, Lua expressions, and errors with file and line."""
