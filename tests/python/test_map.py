"""cairn.Map: queries, batches, and what is in a map."""

import gc
import os
import resource
import signal
import subprocess
import sys
import threading
import unittest
import weakref

import numpy as np

import cairn
import street
from street import expect_error


def setUpModule():
    global MAP, FIRST
    MAP = cairn.Map(street.map_path(), cache_mb=64)
    FIRST = street.FirstQuery()


def localize(map_, **changes):
    arguments = {"prior": FIRST.prior, "gravity": FIRST.gravity, **changes}
    return map_.localize(FIRST.features(), FIRST.camera, **arguments)


class Localize(unittest.TestCase):
    def test_finds_the_camera(self):
        result = localize(MAP)
        self.assertTrue(result.localized, result)
        self.assertIsNone(result.reason)
        np.testing.assert_allclose(result.ecef_from_cam[:3, 3], FIRST.center, atol=0.1)
        self.assertGreater(result.confidence, 0.9)
        self.assertEqual(result.map_version, MAP.version)
        self.assertIn("matching", result.stages)

    def test_the_forms_of_the_pose_agree(self):
        result = localize(MAP)
        enu_from_cam = result.enu_from_cam
        np.testing.assert_allclose(enu_from_cam[:3, 3], 0.0, atol=1e-6)
        np.testing.assert_allclose(enu_from_cam[:3, :3] @ enu_from_cam[:3, :3].T, np.eye(3),
                                   atol=1e-9)
        x, y, z, w = result.geopose.quaternion
        forward = np.array([1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)])
        np.testing.assert_allclose(enu_from_cam[:3, 2], forward, atol=1e-6)
        self.assertEqual(result.geopose.to_dict()["position"]["lat"], result.geopose.lat_deg)
        self.assertEqual(result.covariance.shape, (6, 6))
        self.assertGreater(np.linalg.eigvalsh(result.covariance).min(), 0.0)

    def test_inliers_are_landmarks_that_the_pose_explains(self):
        result = localize(MAP)
        inliers = result.inliers
        self.assertGreater(len(inliers), 20)
        cam_from_ecef = np.linalg.inv(result.ecef_from_cam)
        x_in_cam = inliers.ecef @ cam_from_ecef[:3, :3].T + cam_from_ecef[:3, 3]
        fx, fy, cx, cy = FIRST.camera.params
        pixels = x_in_cam[:, :2] / x_in_cam[:, 2:] * [fx, fy] + [cx, cy]
        errors = np.linalg.norm(pixels - inliers.pixel, axis=1)
        np.testing.assert_allclose(errors, inliers.error_px, atol=0.02)
        np.testing.assert_allclose(inliers.pixel, FIRST.keypoints[inliers.keypoint, :2], atol=1e-4)
        in_tiles = np.concatenate([MAP.landmarks(name)["id"] for name in result.tiles])
        self.assertTrue(set(inliers.landmark_id) <= set(in_tiles))

    def test_a_miss_has_a_reason_in_words(self):
        result = localize(MAP, prior=(10.0, 10.0))
        self.assertFalse(result.localized)
        self.assertEqual(result.reason, "NO_COVERAGE")
        self.assertIn("km", result.reason_text)
        for name in ("geopose", "ecef_from_cam", "enu_from_cam", "covariance", "inliers"):
            self.assertIsNone(getattr(result, name))

    def test_features_serve_several_queries_at_once(self):
        features = FIRST.features()
        before = features.descriptors.copy()
        queries = [cairn.Query(features, FIRST.camera, prior=FIRST.prior, gravity=FIRST.gravity)
                   for _ in range(8)]
        scores = {result.score for result in MAP.localize_many(queries, threads=2)}
        self.assertEqual(len(scores), 1)
        np.testing.assert_array_equal(features.descriptors, before)
        self.assertEqual(len(features), len(before))

    def test_projected_features_need_the_codec_of_the_map(self):
        self.assertRegex(MAP.codec, r"^sift-128-\d+-\d+$")
        features = cairn.Features(FIRST.keypoints, FIRST.descriptors, type="surf")
        with expect_error(self, "invalid_argument", "surf", "sift"):
            MAP.localize(features, FIRST.camera)

    def test_a_rig_is_one_query(self):
        result = localize(MAP, rig=[(FIRST.features(), FIRST.camera, np.eye(4))])
        self.assertTrue(result.localized)
        self.assertEqual(set(result.inliers.camera), {0, 1})

    def test_a_rig_keeps_its_images(self):
        pixels = np.zeros((FIRST.size[1], FIRST.size[0]), np.uint8)
        kept = weakref.ref(pixels)
        item = [pixels, FIRST.camera, np.eye(4)]
        query = cairn.Query(FIRST.features(), FIRST.camera, prior=FIRST.prior,
                            gravity=FIRST.gravity, rig=[item])
        item[0] = None
        del pixels
        self.assertIsNotNone(kept())
        MAP.localize(query)

    def test_a_time_limit_ends_the_search(self):
        self.assertIsNotNone(localize(MAP, timeout_ms=10_000))

    def test_other_options_answer_otherwise(self):
        with cairn.Map(street.map_path(), options={"answer": {"min_score": 1e6}}) as strict:
            self.assertFalse(localize(strict).localized)

    def test_many_calls_keep_no_memory(self):
        query = cairn.Query(cairn.Features(FIRST.keypoints[:2].copy(), FIRST.descriptors[:2].copy(),
                                           size=FIRST.size), FIRST.camera, prior=FIRST.prior)

        def megabytes():
            gc.collect()
            with open("/proc/self/statm") as pages:
                return int(pages.read().split()[1]) * resource.getpagesize() / 1e6

        def ask(times):
            for _ in range(times):
                result = MAP.localize(query)
                self.assertFalse(result.localized)
                result.inliers, result.stages, result.tiles

        ask(500)
        before = megabytes()
        ask(2000)
        self.assertLess(megabytes() - before, 1.0)


class LocalizeMany(unittest.TestCase):
    def test_results_come_in_order(self):
        elsewhere = cairn.Query(FIRST.features(), FIRST.camera, prior=(10.0, 10.0))
        queries = [FIRST.query() if i % 3 else elsewhere for i in range(9)]
        localized = [result.localized for result in MAP.localize_many(iter(queries), threads=2)]
        self.assertEqual(localized, [bool(i % 3) for i in range(9)])

    def test_a_bad_item_fails_in_its_turn(self):
        results = MAP.localize_many([FIRST.query(), 7, "/nowhere.jpg", FIRST.query()], threads=2)
        self.assertTrue(next(results).localized)
        with expect_error(self, "invalid_argument", "queries", "int"):
            next(results)
        with expect_error(self, "not_found", "/nowhere.jpg"):
            next(results)
        self.assertTrue(next(results).localized)
        self.assertEqual(list(results), [])

    def test_takes_queries_as_the_work_goes_on(self):
        taken = []

        def queries():
            for i in range(1000):
                taken.append(i)
                yield FIRST.query()

        next(MAP.localize_many(queries(), threads=2))
        self.assertLess(len(taken), 10)

    def test_an_iterable_that_raises_ends_it_after_the_results_before(self):
        def queries():
            yield FIRST.query()
            raise KeyError("mine")

        results = MAP.localize_many(queries(), threads=1)
        self.assertTrue(next(results).localized)
        with self.assertRaises(KeyError):
            next(results)
        self.assertEqual(list(results), [])

    def test_a_generator_cannot_wait_for_itself(self):
        def queries():
            yield next(results)

        results = MAP.localize_many(queries(), threads=1)
        with expect_error(self, "invalid_argument", "queries"):
            next(results)

    def test_threads_may_share_an_iterator(self):
        elsewhere = cairn.Query(FIRST.features(), FIRST.camera, prior=(10.0, 10.0))
        results = MAP.localize_many([FIRST.query(), elsewhere] * 12, threads=2)
        taken = []
        threads = [threading.Thread(target=lambda: taken.extend(results)) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(sorted(result.localized for result in taken), [False] * 12 + [True] * 12)

    def test_threads_may_share_an_iterator_over_a_generator(self):
        def queries():
            for _ in range(24):
                threading.Event().wait(1e-3)  # Lets the other threads come meanwhile.
                yield FIRST.query()

        results = MAP.localize_many(queries(), threads=2)
        taken = []
        threads = [threading.Thread(target=lambda: taken.extend(results)) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual([result.localized for result in taken], [True] * 24)

    def test_other_threads_of_python_run_meanwhile(self):
        ticks = []
        done = threading.Event()

        def tick():
            while not done.is_set():
                ticks.append(1)
                done.wait(1e-3)

        thread = threading.Thread(target=tick)
        thread.start()
        list(MAP.localize_many([FIRST.query()] * 8, threads=1))
        done.set()
        thread.join()
        self.assertGreater(len(ticks), 1)


class Content(unittest.TestCase):
    def test_landmarks_of_a_box_and_of_its_tiles(self):
        landmarks = MAP.landmarks(MAP.bounds)
        by_tile = [MAP.landmarks(tile["name"]) for tile in MAP.tiles()]
        self.assertEqual(sum(len(rows) for rows in by_tile), MAP.tiles()["num_landmarks"].sum())
        self.assertGreater(len(landmarks), 100)
        self.assertEqual(len(MAP.landmarks(int(MAP.tiles()["id"][0]))), len(by_tile[0]))
        north = landmarks["lat_deg"] > np.median(landmarks["lat_deg"])
        west, south, east, top = MAP.bounds
        half = MAP.landmarks((west, float(np.median(landmarks["lat_deg"])), east, top))
        self.assertLessEqual(abs(len(half) - north.sum()), 2)
        self.assertEqual(len(MAP.landmarks(np.array(MAP.bounds))), len(landmarks))
        self.assertTrue((np.linalg.norm(landmarks["ecef"], axis=1) > 6.3e6).all())
        self.assertTrue((landmarks["sigma_m"] > 0).all())

    def test_keyframes_sessions_versions(self):
        (session,) = MAP.sessions
        keyframes = MAP.keyframes()
        self.assertEqual(session.name, "monday")
        self.assertEqual(len(keyframes), session.num_images)
        self.assertTrue((keyframes["session"] == session.id).all())
        self.assertIn("0003.jpg", keyframes["image"])
        rotations = keyframes["ecef_from_cam"][:, :3, :3]
        np.testing.assert_allclose(rotations @ rotations.transpose(0, 2, 1),
                                   np.broadcast_to(np.eye(3), rotations.shape), atol=1e-9)
        self.assertGreaterEqual(MAP.version, 2)

    def test_sql_has_columns_and_numbers(self):
        rows = MAP.sql("SELECT name, num_images, NULL AS empty, 0.5 AS half FROM v_sessions")
        self.assertEqual(rows.columns, ("name", "num_images", "empty", "half"))
        self.assertEqual(rows, [("monday", len(MAP.keyframes()), None, 0.5)])
        with expect_error(self, "bad_input", "v_sessions"):
            MAP.sql("DELETE FROM v_sessions")


class Lifetime(unittest.TestCase):
    def test_a_closed_map_says_so(self):
        map_ = cairn.Map(street.map_path())
        with map_:
            self.assertFalse(map_.closed)
        self.assertTrue(map_.closed)
        for use in (lambda: localize(map_), lambda: map_.version, map_.keyframes, map_.tiles,
                    lambda: map_.sql("SELECT 1"), lambda: map_.localize_many([])):
            with expect_error(self, "conflict", "map", "closed"):
                use()
        map_.close()

    def test_a_fork_must_open_a_map_of_its_own(self):
        read, write = os.pipe()
        child = os.fork()
        if child == 0:
            try:
                localize(MAP)
                said = "answered"
            except cairn.Error as error:
                said = f"{error.code} {error}"
            with cairn.Map(street.map_path()) as own:
                said += f" {localize(own).localized}"
            os.write(write, said.encode())
            os._exit(0)
        os.waitpid(child, 0)
        os.close(write)
        with os.fdopen(read) as pipe:
            said = pipe.read()
        self.assertIn("conflict map", said)
        self.assertIn("fork", said)
        self.assertIn("True", said)

    def test_a_fork_that_drops_the_map_does_not_wait_for_its_threads(self):
        program = ("import cairn, os, sys\n"
                   "m = cairn.Map(sys.argv[1], options={'num_threads': 2})\n"
                   "many = m.localize_many([])\n"
                   "child = os.fork()\n"
                   "if child == 0:\n    del m, many\n    sys.exit(0)\n"
                   "sys.exit(os.waitpid(child, 0)[1])\n")
        subprocess.run([sys.executable, "-c", program, street.map_path()], check=True, timeout=60)

    def test_ctrl_c_stops_a_batch(self):
        def queries():
            yield FIRST.query()
            os.kill(os.getpid(), signal.SIGINT)
            while True:
                yield FIRST.query()

        with self.assertRaises(KeyboardInterrupt):
            for _ in MAP.localize_many(queries(), threads=1):
                pass


if __name__ == "__main__":
    unittest.main()
