from pathlib import Path

from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import find_packages, setup

SOURCES = Path(__file__).resolve().parent / "src"

setup(
    **generate_distutils_setup(
        packages=find_packages(str(SOURCES)),
        package_dir={"": "src"},
        package_data={"flatland2d": ["py.typed"]},
    )
)
