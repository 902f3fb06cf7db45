"""cairn.init, ingest, map and evaluate."""

import json
import os
import pathlib
import shutil
import signal
import tempfile
import unittest

import numpy as np

import cairn
import street
from street import expect_error


class Building(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.path = self.folder / "new.gpkg"


class Ingest(Building):
    def test_adds_a_session_and_reports_progress(self):
        steps = []
        summary = street.ingest(self.path, progress=lambda *step: steps.append(step))
        self.assertEqual(summary.session, "monday")
        self.assertFalse(summary.unchanged)
        with cairn.Map(self.path) as map_:
            self.assertEqual(map_.version, summary.map_version)
        self.assertGreater(len({phase for phase, _, _ in steps}), 1)
        self.assertTrue(all(isinstance(done, int) for _, done, _ in steps))
        self.assertIn("session", json.dumps(summary.details))

    def test_the_same_session_again_changes_nothing(self):
        street.ingest(self.path)
        model = street.files() / "colmap"
        again = cairn.ingest(self.path, model=model, database=model / "database.db", gps=True,
                             height="ellipsoid", session="monday")
        self.assertTrue(again.unchanged)

    def test_a_model_that_stands_on_earth_needs_no_positions(self):
        cairn.init(self.path)
        model = street.files() / "colmap"
        summary = cairn.ingest(self.path, model=model, database=model / "database.db",
                               frame="enu", origin=(47.3769, 8.5417, 408.0))
        self.assertIn("frame", json.dumps(summary.details))
        with cairn.Map(self.path) as map_:
            west, south, east, north = map_.bounds
        self.assertTrue(8.53 < west < east < 8.55, map_)
        self.assertTrue(47.37 < south < north < 47.385, map_)

    def test_a_callback_that_raises_ends_the_work_without_a_change(self):
        cairn.init(self.path)

        def stop(phase, done, total):
            raise LookupError(phase)

        model = street.files() / "colmap"
        with self.assertRaises(LookupError):
            cairn.ingest(self.path, model=model, database=model / "database.db", gps=True,
                         progress=stop)
        with cairn.Map(self.path) as map_:
            self.assertEqual((map_.version, map_.sessions, map_.bounds, map_.codec),
                             (1, [], None, None))

    def test_ctrl_c_ends_the_work(self):
        cairn.init(self.path)
        model = street.files() / "colmap"
        with self.assertRaises(KeyboardInterrupt):
            cairn.ingest(self.path, model=model, database=model / "database.db", gps=True,
                         progress=lambda *step: os.kill(os.getpid(), signal.SIGINT))

    def test_names_what_is_missing(self):
        cairn.init(self.path)
        with expect_error(self, "conflict", str(self.path)):
            cairn.init(self.path)
        with expect_error(self, "invalid_argument", "georef", "gps"):
            cairn.ingest(self.path, model="m", database="d")
        with expect_error(self, "invalid_argument", "frame", "gps"):
            cairn.ingest(self.path, model="m", database="d", gps=True, frame="ecef")
        with expect_error(self, "invalid_argument", "control", "georef"):
            cairn.ingest(self.path, model="m", database="d", georef="g", control="c")
        with expect_error(self, "invalid_argument", "frame", "'enu'"):
            cairn.ingest(self.path, model="m", database="d", frame="utm")
        with expect_error(self, "invalid_argument", "origin"):
            cairn.ingest(self.path, model="m", database="d", frame="enu")
        with expect_error(self, "invalid_argument", "origin"):
            cairn.ingest(self.path, model="m", database="d", frame="ecef", origin=(1, 2, 3))
        with expect_error(self, "invalid_argument", "origin", "height"):
            cairn.ingest(self.path, model="m", database="d", frame="enu", origin=(47.0, 8.0))
        with expect_error(self, "invalid_argument", "progress"):
            cairn.ingest(self.path, model="m", database="d", gps=True, progress=5)
        with expect_error(self, "invalid_argument", "height"):
            cairn.ingest(self.path, model="m", database="d", gps=True, height="sea")


class MapPhotos(Building):
    def test_photos_become_a_map_that_knows_them(self):
        folder = street.files(with_photos=True)
        phases = set()
        summary = cairn.map(self.path, folder / "photos", gps=folder / "positions.csv",
                            cameras=[cairn.Camera("PINHOLE", (480, 360), [320, 320, 240, 180])],
                            options={"mapping": {"sift": {"max_features": 1500}}},
                            progress=lambda phase, done, total: phases.add(phase))
        self.assertEqual(summary.session, "photos")
        self.assertEqual([session.map_version for session in summary.sessions], [summary.map_version])
        self.assertGreater(len(phases), 3)
        photo = folder / "photos" / "walk_004.png"
        camera = cairn.Camera("PINHOLE", (480, 360), [320, 320, 240, 180])
        with cairn.Map(self.path) as map_:
            keyframes = map_.keyframes()
            self.assertGreaterEqual(len(keyframes), 8)
            result = map_.localize(photo, camera)
            self.assertTrue(result.localized, result)
            truth = keyframes["ecef_from_cam"][keyframes["image"] == "walk_004.png"][0]
            np.testing.assert_allclose(result.ecef_from_cam[:3, 3], truth[:3, 3], atol=0.1)
            self.assertEqual(map_.localize(photo.read_bytes(), camera).score, result.score)
            self.assertGreater(result.stages["extract"], 0.0)

    def test_folders_become_sessions_that_join(self):
        source = street.files(with_photos=True)
        for day, numbers in (("monday", range(0, 10, 2)), ("tuesday", range(1, 10, 2)), ("short", ())):
            (self.folder / day).mkdir()
            for i in numbers:
                shutil.copy(source / "photos" / f"walk_{i:03}.png", self.folder / day)
        shutil.copy(source / "photos" / "walk_000.png", self.folder / "short" / "alone.png")
        summary = cairn.map(self.path, [self.folder / day for day in ("tuesday", "short", "monday")],
                            gps=source / "positions.csv",
                            cameras=[cairn.Camera("PINHOLE", (480, 360), [320, 320, 240, 180])],
                            options={"mapping": {"sift": {"max_features": 1500}}})
        monday, tuesday, short = summary.sessions
        self.assertEqual((monday.session, tuesday.session, short.session), ("monday", "tuesday", "short"))
        self.assertEqual((monday.problem, tuesday.problem), (None, None))
        self.assertIn("1 of 1 photos", short.problem)
        self.assertIsNone(short.map_version)
        self.assertLess(monday.map_version, tuesday.map_version)
        self.assertEqual((summary.session, summary.map_version), ("tuesday", tuesday.map_version))
        self.assertEqual(len(summary.details["sessions"]), 3)
        self.assertIn("notInMap", short.details)
        with cairn.Map(self.path) as map_:
            self.assertEqual([session.name for session in map_.sessions], ["monday", "tuesday"])

    def test_refuses_what_is_no_folder(self):
        with expect_error(self, "invalid_argument", "photos"):
            cairn.map(self.path, [])
        with expect_error(self, "invalid_argument", "cameras"):
            cairn.map(self.path, "x", cameras=["PINHOLE"])


class Evaluate(Building):
    def test_measures_the_queries(self):
        report = cairn.evaluate(street.map_path(), street.files() / "queries.json", threads=2)
        self.assertEqual((report.num_queries, report.num_localized), (4, 4))
        self.assertEqual(report.names, [f"query{i}" for i in range(4)])
        self.assertTrue(report.localized.all())
        self.assertLess(report.position_error_m.max(), 0.3)
        value, low, high = report.median_position_error_m
        self.assertTrue(low <= value <= high)
        self.assertEqual(report.recalls[-1].value, 1.0)
        self.assertEqual(report.precision_recall.shape[1], 3)
        self.assertEqual(json.loads(report.to_json())["num_queries"], 4)
        self.assertEqual(len(report.to_csv().splitlines()), 5)
        self.assertIn("4", str(report))

    def test_draws_itself_on_any_axes(self):
        calls = {}

        class Axes:
            def __getattr__(self, name):
                return lambda *arguments, **keywords: calls.setdefault(name, arguments)

        axes = Axes()
        report = cairn.evaluate(street.map_path(), street.files() / "queries.json")
        self.assertIs(report.plot(axes), axes)
        errors, shares = calls["step"]
        np.testing.assert_array_equal(errors, np.sort(report.position_error_m))
        np.testing.assert_allclose(shares, [0.25, 0.5, 0.75, 1.0])
        self.assertIn("4 of 4", calls["set_title"][0])

    def test_names_what_is_missing(self):
        with expect_error(self, "invalid_argument", "queries"):
            cairn.evaluate(street.map_path())


if __name__ == "__main__":
    unittest.main()
