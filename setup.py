"""Builds the package cairn with CMake; see pyproject.toml.

CAIRN_BUILD_DIR names a build tree of CMake to use, such as build/release. Without it, the module is
built in a tree of its own, which takes as long as a build of Cairn.
"""

import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

ROOT = pathlib.Path(__file__).resolve().parent
OPTIONS = [
    "-DCMAKE_BUILD_TYPE=Release",
    "-DCMAKE_UNITY_BUILD=ON",
    "-DCMAKE_UNITY_BUILD_BATCH_SIZE=8",
    "-DCAIRN_BUILD_TESTS=OFF",
    "-DCAIRN_BUILD_BENCHMARKS=OFF",
    "-DCAIRN_BUILD_EXAMPLES=OFF",
    "-DCAIRN_WITH_PYTHON=ON",
    f"-DPython3_EXECUTABLE={sys.executable}",
]


def run(*command):
    print(" ".join(map(str, command)), flush=True)
    subprocess.run(command, check=True, stdout=sys.stderr)


class CMakeBuild(build_ext):
    def run(self):
        tree = os.environ.get("CAIRN_BUILD_DIR")
        if not tree:
            tree = str(pathlib.Path(self.build_temp).resolve())
            run("cmake", "-S", ROOT, "-B", tree, "-G", "Ninja", *OPTIONS)
        run("cmake", "--build", tree, "--target", "cairn_python")
        with tempfile.TemporaryDirectory() as prefix:
            run("cmake", "--install", tree, "--component", "python", "--prefix", prefix)
            (package,) = pathlib.Path(prefix).rglob("cairn")
            shutil.copytree(package, pathlib.Path(self.build_lib) / "cairn", dirs_exist_ok=True)

    def get_outputs(self):
        return [str(path) for path in (pathlib.Path(self.build_lib) / "cairn").rglob("*")]


setup(
    ext_modules=[Extension("cairn._cairn", [])],
    packages=[],
    cmdclass={"build_ext": CMakeBuild},
)
