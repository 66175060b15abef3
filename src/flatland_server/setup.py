from pathlib import Path

from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import find_packages, setup

SOURCES = Path(__file__).resolve().parent / "src"
PACKAGES = find_packages(str(SOURCES), include=["flatland_server", "flatland_server.*"])

setup(
    **generate_distutils_setup(
        packages=["flatland2d", *PACKAGES],
        # flatland2d has a folder of its own: in the devel space, importing a package puts the
        # folder around it first on sys.path, and there flatland_server has no extension module.
        package_dir={"": "src", "flatland2d": "src/short_name/flatland2d"},
        package_data={
            "flatland2d": ["py.typed"],
            "flatland_server": ["py.typed", "*.pyi", "messages/definitions/*/*.msg"],
        },
    )
)
