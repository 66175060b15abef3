from pathlib import Path

from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import find_packages, setup

SOURCES = Path(__file__).resolve().parent / "src"
PACKAGES = find_packages(str(SOURCES), include=["flatland_server", "flatland_server.*"])

setup(
    **generate_distutils_setup(
        packages=PACKAGES,
        package_dir={"": "src"},
        package_data={"flatland_server": ["py.typed", "*.pyi", "messages/definitions/*/*.msg"]},
    )
)
