"""Flatland's server: worlds in YAML, moved by Box2D, with robots made of plugins.

Everything outside `flatland_server.ros` works without a ROS master.
"""
