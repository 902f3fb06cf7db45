"""cairn.FusionClient: arguments, the start at rest, and queries."""

import threading
import unittest

import numpy as np

import cairn
import walk
from street import expect_error

CAMERA = cairn.Camera("PINHOLE", (640, 480), [400, 400, 320, 240])


def new_client(**options):
    return cairn.FusionClient(CAMERA, walk.CAM_FROM_IMU, walk.ORIGIN, options=options or None)


class Arguments(unittest.TestCase):
    def test_of_the_client(self):
        with expect_error(self, "invalid_argument", "camera"):
            cairn.FusionClient(None, np.eye(4), walk.ORIGIN)
        with expect_error(self, "invalid_argument", "cam_from_imu"):
            cairn.FusionClient(CAMERA, 2 * np.eye(4), walk.ORIGIN)
        with expect_error(self, "invalid_argument", "origin"):
            cairn.FusionClient(CAMERA, np.eye(4), (100, 0, 0))
        with expect_error(self, "invalid_argument", "max_clones"):
            new_client(max_clones=1000)
        with expect_error(self, "invalid_argument", "imu_noise.gyro_density"):
            new_client(imu_noise={"gyro_densities": 1.0})

    def test_of_samples(self):
        client = new_client()
        times, rows = np.arange(3), np.zeros((3, 3))
        for name, arguments in (("timestamps_ns", (times.astype(float), rows, rows)),
                                ("timestamps_ns", (times.astype(">i8"), rows, rows)),
                                ("gyro_rad_s", (times, rows[:2].copy(), rows)),
                                ("gyro_rad_s", (times, rows.astype(np.float32), rows)),
                                ("accel_m_s2", (times, rows, np.asfortranarray(rows))),
                                ("accel_m_s2", (times, rows, [[0, 0, 9.81]] * 3))):
            with expect_error(self, "invalid_argument", name):
                client.add_imu(*arguments)
        self.assertEqual(client.add_imu(times, rows, rows), "accepted")
        self.assertEqual(client.add_imu(times, rows, rows), "out_of_order")

    def test_of_frames(self):
        client = new_client()
        ids, pixels = np.arange(2, dtype=np.uint64), np.zeros((2, 2))
        for name, arguments in (("timestamp_ns", (0.5, ids, pixels)),
                                ("track_ids", (5, ids.astype(np.int32), pixels)),
                                ("pixels", (5, ids, pixels[:1].copy())),
                                ("pixels", (5, ids, np.zeros((2, 4))[:, ::2]))):
            with expect_error(self, "invalid_argument", name):
                client.add_frame(*arguments)
        self.assertEqual(client.add_frame(5, ids, pixels), "accepted")


class Tracking(unittest.TestCase):
    def test_starts_at_rest_and_asks(self):
        client = new_client()
        imu = walk.inertial_samples()
        imu = imu[imu[:, 0] < 1.9e9]
        ids = np.arange(60, dtype=np.uint64)
        pixels = np.random.default_rng(1).uniform(20, 460, (60, 2))
        begin, query = 0, None
        for time_ns in range(100_000_000, 1_800_000_000, 100_000_000):
            end = int(np.searchsorted(imu[:, 0], time_ns, side="right"))
            client.add_imu(imu[begin:end, 0].astype(np.int64), imu[begin:end, 1:4].copy(),
                           imu[begin:end, 4:7].copy())
            begin = end
            self.assertEqual(client.add_frame(time_ns, ids, pixels), "accepted")
            query = client.poll_query() or query
        estimate = client.latest()
        self.assertEqual(estimate.mode, "tracking")
        np.testing.assert_allclose(estimate.velocity_in_local, 0.0, atol=0.05)
        self.assertEqual(estimate.covariance.shape, (15, 15))
        self.assertIsNone(estimate.global_from_imu)
        np.testing.assert_allclose(query.gravity, [0, 1, 0], atol=0.02)
        np.testing.assert_array_equal(query.track_ids, ids)
        np.testing.assert_array_equal(query.pixels, pixels)
        status, predicted = client.predict(estimate.timestamp_ns + 10_000_000)
        self.assertEqual((status, predicted.mode), ("ok", "tracking"))
        self.assertEqual(client.predict(10**12), ("too_far_ahead", None))

    def test_a_second_thread_at_once_is_refused_or_waits(self):
        client = new_client()
        imu = walk.inertial_samples()
        refused = []

        def feed():
            for _ in range(200):
                try:
                    client.add_imu(imu[:, 0].astype(np.int64), imu[:, 1:4].copy(),
                                   imu[:, 4:7].copy())
                except cairn.Error as error:
                    refused.append((error.code, str(error)))

        threads = [threading.Thread(target=feed) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        for code, message in refused:
            self.assertEqual(code, "conflict")
            self.assertIn("client", message)


if __name__ == "__main__":
    unittest.main()
