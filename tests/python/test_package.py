"""The stubs agree with the module, everything has a docstring, and pip installs the package."""

import inspect
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import cairn

SOURCE = pathlib.Path(os.environ["CAIRN_SOURCE_DIR"])


def has_mypy():
    return subprocess.run([sys.executable, "-m", "mypy", "--version"],
                          capture_output=True).returncode == 0


class Package(unittest.TestCase):
    def test_everything_is_described(self):
        for name in cairn.__all__:
            member = getattr(cairn, name)
            if not callable(member):
                continue
            self.assertTrue(inspect.getdoc(member), name)
            if inspect.isclass(member) and member.__module__ == "cairn":
                for part, value in vars(member).items():
                    if not part.startswith("_"):
                        self.assertTrue(inspect.getdoc(value), f"{name}.{part}")

    @unittest.skipUnless(has_mypy(), "mypy is not installed")
    def test_mypy_accepts_the_package_and_the_examples(self):
        examples = sorted((SOURCE / "examples" / "python").glob("*.py"))
        with tempfile.TemporaryDirectory() as cache:
            done = subprocess.run(
                [sys.executable, "-m", "mypy", "--cache-dir", cache, "--ignore-missing-imports",
                 "--check-untyped-defs", SOURCE / "python" / "cairn", *examples],
                capture_output=True, text=True,
                env={**os.environ, "MYPYPATH": str(SOURCE / "python")})
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_the_stubs_name_what_the_module_has(self):
        import ast

        from cairn import _cairn

        tree = ast.parse((SOURCE / "python" / "cairn" / "_cairn.pyi").read_text())
        members = {}
        for node in tree.body:
            if isinstance(node, ast.ClassDef):
                members[node.name] = {
                    part.name if isinstance(part, ast.FunctionDef) else part.target.id
                    for part in node.body}
            elif isinstance(node, ast.FunctionDef):
                members[node.name] = set()
        public = {name for name, value in vars(_cairn).items()
                  if callable(value) and not name.startswith("__")}
        self.assertEqual(public, set(members))
        for name, parts in members.items():
            kind = getattr(_cairn, name)
            if inspect.isclass(kind) and name != "Error":
                has = {part for part in vars(kind) if not part.startswith("_")}
                self.assertEqual(has, {part for part in parts if not part.startswith("_")}, name)

    def test_another_numpy_than_it_was_built_for_is_an_import_error(self):
        with tempfile.TemporaryDirectory() as folder:
            (pathlib.Path(folder) / "numpy").mkdir()
            (pathlib.Path(folder) / "numpy" / "__init__.py").write_text("__version__ = '2.1.0'\n")
            path = os.pathsep.join([folder, str(pathlib.Path(cairn.__file__).parent.parent)])
            done = subprocess.run([sys.executable, "-c", "import cairn._cairn"],
                                  capture_output=True, text=True,
                                  env={**os.environ, "PYTHONPATH": path})
        self.assertNotEqual(done.returncode, 0)
        version = os.environ["CAIRN_PYBIND11_VERSION"].split(".")
        if (int(version[0]), int(version[1])) < (2, 12):  # Later ones know both; this one is empty.
            self.assertIn("numpy 2.1.0", done.stderr)
            self.assertIn("numpy<2", done.stderr)

    def test_pip_installs_it(self):
        with tempfile.TemporaryDirectory() as scratch:
            tree = pathlib.Path(scratch) / "source"
            tree.mkdir()
            for name in ("pyproject.toml", "setup.py"):
                (tree / name).write_text((SOURCE / name).read_text())
            (tree / "docs").mkdir()
            (tree / "docs" / "python.md").write_text((SOURCE / "docs" / "python.md").read_text())
            target = pathlib.Path(scratch) / "target"
            done = subprocess.run(
                [sys.executable, "-m", "pip", "install", "--no-build-isolation", "--no-deps",
                 "--no-index", "--target", target, tree], capture_output=True, text=True,
                env={**os.environ, "CAIRN_BUILD_DIR": os.environ["CAIRN_BUILD_DIR"]})
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            out = subprocess.run(
                [sys.executable, "-c", "import cairn; print(cairn.__file__, cairn.__version__)"],
                check=True, capture_output=True, text=True, cwd=scratch,
                env={**os.environ, "PYTHONPATH": str(target)}).stdout
            self.assertIn(str(target), out)
            self.assertIn(cairn.__version__, out)


if __name__ == "__main__":
    unittest.main()
