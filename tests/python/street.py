"""The street that the tests share: files of make_street, and a map of its model."""

import functools
import os
import pathlib
import subprocess
import tempfile

import numpy as np

import cairn

_folder = tempfile.TemporaryDirectory(prefix="cairn_python_")


@functools.lru_cache(maxsize=None)
def files(with_photos=False):
    """The folder of make_street."""
    folder = pathlib.Path(_folder.name) / ("photos" if with_photos else "plain")
    folder.mkdir()
    subprocess.run([os.environ["CAIRN_MAKE_STREET"], folder]
                   + (["--photos"] if with_photos else []), check=True)
    return folder


def ingest(path, **keywords):
    """Makes a map of the street's model."""
    cairn.init(path)
    model = files() / "colmap"
    return cairn.ingest(path, model=model, database=model / "database.db", gps=True,
                        height="ellipsoid", session="monday", **keywords)


@functools.lru_cache(maxsize=None)
def map_path():
    """A map that no test changes."""
    path = pathlib.Path(_folder.name) / "street.gpkg"
    ingest(path)
    return path


class FirstQuery:
    """The first query of the street as arrays."""

    def __init__(self):
        folder = files()
        rows = [[float(word) for word in line.split()]
                for line in (folder / "query.txt").read_text().splitlines()]
        self.keypoints = np.fromfile(folder / "keypoints.f32", np.float32).reshape(-1, 4)
        self.descriptors = np.fromfile(folder / "descriptors.f32",
                                       np.float32).reshape(len(self.keypoints), -1)
        self.size = (int(rows[0][0]), int(rows[0][1]))
        self.camera = cairn.Camera("PINHOLE", self.size, rows[1])
        self.prior, self.gravity, self.center = rows[2], rows[3], np.array(rows[4])

    def features(self):
        return cairn.Features(self.keypoints, self.descriptors, size=self.size)

    def query(self):
        return cairn.Query(self.features(), self.camera, prior=self.prior, gravity=self.gravity)


def expect_error(test, code, *parts):
    """A context in which a cairn.Error of this code, with these words, must be raised."""

    class Expect:
        def __enter__(self):
            return self

        def __exit__(self, kind, error, trace):
            test.assertIsInstance(error, cairn.Error)
            test.assertEqual(error.code, code, error)
            for part in parts:
                test.assertIn(part, str(error))
            return True

    return Expect()
