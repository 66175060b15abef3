from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import setup

setup(
    **generate_distutils_setup(
        packages=["flatland_navigation"],
        package_dir={"": "src"},
        package_data={"flatland_navigation": ["py.typed"]},
    )
)
