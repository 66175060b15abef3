from setuptools import setup

setup(
    name="flatland_server",
    version="0.1.0",
    # Not flatland_server: that is a package of flatland2d.
    packages=["flatland_server_node"],
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/flatland_server"]),
        ("share/flatland_server", ["package.xml"]),
        ("share/flatland_server/launch", ["launch/server.launch.py"]),
        ("share/flatland_server/rviz", ["rviz/flatland.rviz"]),
    ],
    install_requires=["setuptools"],
    extras_require={"test": ["pytest"]},  # by which colcon runs the tests
    entry_points={"console_scripts": ["flatland_server = flatland_server_node.main:main"]},
)
