"""`pip install .`: the module is built by CMake, in build/release if that is of this Python, else in a folder of its own."""

import pathlib
import re
import shutil
import subprocess
import sys

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

here = pathlib.Path(__file__).parent.resolve()
wheel = here / "build" / "wheel"
wheel.mkdir(parents=True, exist_ok=True)
version = re.search(r"project\(ardent VERSION ([0-9.]+)", (here / "CMakeLists.txt").read_text()).group(1)


class BuildByCMake(build_ext):
    def build_extension(self, extension):
        file = pathlib.Path(self.get_ext_fullpath(extension.name)).resolve()
        build = here / "build" / "release"
        if not (build / "python" / "ardent" / file.name).exists():
            build = here / "build" / f"python-{sys.implementation.cache_tag}"
            subprocess.run(["cmake", "--preset", "release", "-B", build, "-DARDENT_TESTS=OFF",
                            f"-DPython3_EXECUTABLE={sys.executable}"], cwd=here, check=True)
        try:
            subprocess.run(["cmake", "--build", build, "--target", "ardent_python"], cwd=here, check=True)
        except subprocess.CalledProcessError:
            sys.exit("ardent: the module could not be built. It needs pybind11-dev and python3-dev beside the packages of apt.txt")
        file.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(build / "python" / "ardent" / file.name, file)


setup(version=version, packages=["ardent"], package_dir={"ardent": "apps/python/ardent"},
      package_data={"ardent": ["py.typed", "*.pyi"]}, ext_modules=[Extension("ardent._ardent", [])],
      cmdclass={"build_ext": BuildByCMake},
      options={"egg_info": {"egg_base": str(wheel)}, "build": {"build_base": str(wheel)}})
