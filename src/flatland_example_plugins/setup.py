from glob import glob

from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import setup

NAME = "flatland_example_plugins"

setup(
    **generate_distutils_setup(
        packages=[NAME],
        package_dir={"": "src"},
        # For pip. catkin installs them too, by CMakeLists.txt.
        data_files=[(f"share/{NAME}/worlds/conveyor", glob("worlds/conveyor/*"))],
    )
)
