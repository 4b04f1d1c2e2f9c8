"""`pip install .`: the module is built by CMake, in build/release if that is of this Python, else in a folder of its
own."""

import pathlib
import re
import shutil
import subprocess
import sys

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

here = pathlib.Path(__file__).parent.resolve()
wheel = here / "build" / "wheel"
shutil.rmtree(wheel, ignore_errors=True)  # or what is gone from the sources would stay
wheel.mkdir(parents=True)
version = re.search(r"project\(ardent VERSION ([0-9.]+)", (here / "CMakeLists.txt").read_text()).group(1)


class BuildByCMake(build_ext):
    def build_extension(self, extension):
        file = pathlib.Path(self.get_ext_fullpath(extension.name)).resolve()
        build = here / "build" / "release"
        try:
            if not (build / "python" / "ardent" / file.name).exists():
                build = here / "build" / f"python-{sys.implementation.cache_tag}"
                subprocess.run(["cmake", "--preset", "release", "-B", build, "-DARDENT_TESTS=OFF",
                                f"-DPython3_EXECUTABLE={sys.executable}", *pybind11_folder()], cwd=here, check=True)
            subprocess.run(["cmake", "--build", build, "--target", "ardent_python"], cwd=here, check=True)
        except (OSError, subprocess.CalledProcessError) as error:
            sys.exit(f"ardent: {error}. The lines above say why; ./run build installs what the program needs, and the "
                     "module needs pybind11 and the headers of Python beside it")
        file.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(build / "python" / "ardent" / file.name, file)


def pybind11_folder():
    """Of the package of Python, where there is one; else the system's is found."""
    try:
        import pybind11
    except ImportError:
        return []
    return [f"-Dpybind11_DIR={pybind11.get_cmake_dir()}"]


setup(version=version, packages=["ardent"], package_dir={"ardent": "apps/python/ardent"},
      package_data={"ardent": ["py.typed", "*.pyi"]}, ext_modules=[Extension("ardent._ardent", [])],
      cmdclass={"build_ext": BuildByCMake},
      options={"egg_info": {"egg_base": str(wheel)}, "build": {"build_base": str(wheel)}})
