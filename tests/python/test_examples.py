"""The examples of examples/python run as they stand."""

import csv
import importlib.util
import json
import math
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

import street

EXAMPLES = pathlib.Path(os.environ["CAIRN_SOURCE_DIR"]) / "examples" / "python"


def run(name, *arguments):
    done = subprocess.run([sys.executable, EXAMPLES / name, *arguments], stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True)
    assert done.returncode == 0, done.stdout
    return done.stdout


def write_queries(folder, scratch):
    """A query list of the photos. The true positions are near those of the receiver; all photos
    look the same way (make_street.cc)."""
    azimuth = 0.35 + 0.5 * math.pi - 0.1
    half = 0.5 * (azimuth - 0.5 * math.pi)  # A turn about up of the camera that looks north.
    s = math.sqrt(0.5)
    north = {"x": -s * math.cos(half), "y": -s * math.sin(half), "z": s * math.sin(half),
             "w": s * math.cos(half)}
    with open(folder / "positions.csv") as positions:
        queries = [{"name": row["image"], "image": str(folder / "photos" / row["image"]),
                    "camera": {"model": "PINHOLE", "size": [480, 360],
                               "modelParams": [320, 320, 240, 180]},
                    "reference": {"position": {"lat": float(row["lat_deg"]),
                                               "lon": float(row["lon_deg"]),
                                               "h": float(row["h_m"])}, "quaternion": north}}
                   for row in csv.DictReader(positions)]
    path = scratch / "queries.json"
    path.write_text(json.dumps({"format": "cairn query list", "version": 1, "queries": queries}))
    return path


class Examples(unittest.TestCase):
    def test_map_and_evaluate(self):
        folder = street.files(with_photos=True)
        with tempfile.TemporaryDirectory() as scratch:
            out = run("map_and_evaluate.py", pathlib.Path(scratch) / "town.gpkg",
                      folder / "photos", "--gps", folder / "positions.csv")
        self.assertIn("session photos is in version", out)
        errors = [float(error) for error in re.findall(r"walk_\d+\.png\s+([0-9.]+) m", out)]
        self.assertGreaterEqual(len(errors), 8)
        self.assertLess(sorted(errors)[len(errors) // 2], 0.1)

    def test_map_and_evaluate_with_true_poses(self):
        folder = street.files(with_photos=True)
        with tempfile.TemporaryDirectory() as scratch:
            plot = pathlib.Path(scratch) / "errors.png"
            out = run("map_and_evaluate.py", pathlib.Path(scratch) / "town.gpkg",
                      folder / "photos", "--gps", folder / "positions.csv",
                      "--queries", write_queries(folder, pathlib.Path(scratch)),
                      *(["--plot", plot] if importlib.util.find_spec("matplotlib") else []))
            self.assertEqual(plot.exists(), importlib.util.find_spec("matplotlib") is not None)
        localized = int(re.search(r"(\d+) of 10 queries localized", out)[1])
        self.assertGreaterEqual(localized, 8)

    def test_ask_server_takes_20_lines(self):
        lines = (EXAMPLES / "ask_server.py").read_text().splitlines()
        code = [line for line in lines if line.strip() and not line.startswith(("#", '"""'))]
        self.assertLessEqual(len(code), 20)

    def test_ask_server(self):
        folder = street.files(with_photos=True)
        server = subprocess.Popen(
            [os.environ["CAIRN_BINARY"], "serve", street.map_path(), "--port", "0",
             "--host", "127.0.0.1"], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        try:
            for line in server.stdout:
                found = re.search(r"http://[^ ]*:(\d+)", line)
                if found:
                    break
            out = run("ask_server.py", f"http://127.0.0.1:{found[1]}",
                      folder / "photos" / "walk_000.png")
            self.assertRegex(out, r"walk_000\.png: [A-Z_]+: ")
            import cairn

            first = street.FirstQuery()
            client = cairn.Client(f"http://127.0.0.1:{found[1]}")
            answer = client.localize(first.query())
            with cairn.Map(street.map_path()) as map_:
                here = map_.localize(first.query())
            self.assertTrue(answer.localized)
            self.assertLess(abs(answer.ecef_from_cam - here.ecef_from_cam).max(), 1e-3)
            self.assertLess(abs(answer.covariance - here.covariance).max(), 1e-6)
            self.assertEqual(len(answer.inliers), len(here.inliers))
        finally:
            server.terminate()
            server.communicate()

    def test_fuse_walk(self):
        import walk

        with tempfile.TemporaryDirectory() as scratch:
            truth = walk.record(pathlib.Path(scratch))
            out = run("fuse_walk.py", scratch, street.map_path())
        rows = [line.split() for line in out.splitlines()]
        fused = {int(row[0]): [float(x) for x in row[2:]] for row in rows if len(row) == 5}
        self.assertGreater(len(fused), len(rows) // 3, out)
        last = max(fused)
        error_m = sum((a - b) ** 2 for a, b in zip(fused[last], truth[last])) ** 0.5
        self.assertLess(error_m, 0.3)


if __name__ == "__main__":
    unittest.main()
