#!/usr/bin/env python3
"""Makes a model of the same photos by `cairn map` and by COLMAP, and compares both with the truth.

For each of the two, prints the photos in the model, the errors of the camera positions after the
similarity that fits best (mean, largest, and how many are above 1 m), the seconds, and the peak memory.
COLMAP runs on the processor, with as many features as `cairn map`, all pairs (or, with --sequential,
neighbors), and, with --camera, these intrinsics held. The truth is a CSV with the columns image and x_m,
y_m, z_m (meters in any frame), or image, lat_deg, lon_deg, h_m. Without --truth, no errors are printed.

Needs `python3-numpy`, and `colmap` unless --only cairn. The exit code is 2 if a file is missing or a
program fails.

Example:
  lab/peers/compare_mapping.py --cairn build/release/cli/cairn --photos fountain/images \\
      --gps fountain/gps_3m.csv --truth fountain/truth.csv --work /tmp/fountain \\
      --camera PINHOLE,1536,1024,1379.74,1382.08,760.595,503.655
"""

import argparse
import csv
import json
import math
import pathlib
import shlex
import shutil
import sqlite3
import subprocess
import sys
import time

import numpy as np

WRONG_M = 1.0


class FailedError(Exception):
    """A program or a file is missing, or a program failed."""


def parse_arguments():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cairn", required=True, help="the cairn binary")
    parser.add_argument("--photos", required=True, type=pathlib.Path, help="folder of photos")
    parser.add_argument("--truth", type=pathlib.Path, help="CSV of true positions")
    parser.add_argument("--work", required=True, type=pathlib.Path, help="scratch folder")
    parser.add_argument("--gps", type=pathlib.Path, help="positions for cairn; default: EXIF")
    parser.add_argument("--camera", help="intrinsics, as of cairn map --camera")
    parser.add_argument("--cairn-options", default="", metavar="TEXT",
                        help="more options of cairn map, e.g. --cairn-options='--work /tmp/w'")
    parser.add_argument("--features", type=int, default=4000, help="most features of a photo")
    parser.add_argument("--sequential", action="store_true", help="COLMAP matches neighbors only")
    parser.add_argument("--only", choices=["cairn", "colmap"], help="run only one of the two")
    return parser.parse_args()


def run(*command, refusal=None):
    """Runs a program. Returns its output, its seconds and its peak memory in megabytes.

    A program that fails with the words of `refusal` has found no answer, which is no error."""
    # GNU time measures the children of a shell, too.
    timed = ["/usr/bin/time", "-f", "PEAK %M"] if pathlib.Path("/usr/bin/time").exists() else []
    start = time.monotonic()
    try:
        result = subprocess.run([str(part) for part in timed + list(command)], text=True,
                                stdout=subprocess.PIPE, stderr=subprocess.PIPE, check=False)
    except OSError as error:
        raise FailedError(f"{command[0]}: {error.strerror}") from error
    seconds = time.monotonic() - start
    refused = refusal is not None and refusal in result.stdout + result.stderr
    if result.returncode != 0 and not refused:
        raise FailedError(f"{command[0]} failed:\n{result.stdout[-2000:]}{result.stderr[-2000:]}")
    peaks = [line for line in result.stderr.splitlines() if line.startswith("PEAK ")]
    return result.stdout, seconds, float(peaks[-1].split()[1]) / 1024 if peaks else math.nan


def ecef(lat_deg, lon_deg, h_m):
    lat, lon = math.radians(lat_deg), math.radians(lon_deg)
    a, e2 = 6378137.0, 6.69437999014e-3
    n = a / math.sqrt(1 - e2 * math.sin(lat) ** 2)
    return [(n + h_m) * math.cos(lat) * math.cos(lon), (n + h_m) * math.cos(lat) * math.sin(lon),
            (n * (1 - e2) + h_m) * math.sin(lat)]


def read_truth(path):
    with open(path, encoding="utf-8-sig") as file:
        rows = csv.DictReader(line for line in file if not line.startswith("#"))
        if "x_m" in rows.fieldnames:
            return {row["image"]: [float(row[k]) for k in ("x_m", "y_m", "z_m")] for row in rows}
        return {row["image"]: ecef(*(float(row[k]) for k in ("lat_deg", "lon_deg", "h_m")))
                for row in rows}


def centers_of_map(path):
    with sqlite3.connect(path) as database:
        rows = database.execute("SELECT image_name, qw, qx, qy, qz, tx_m, ty_m, tz_m FROM keyframes "
                                "JOIN cairn_keyframe_poses USING (keyframe_id)")
        return {row[0]: center(*row[1:]) for row in rows}


def center(qw, qx, qy, qz, tx, ty, tz):
    rotation = np.array([
        [1 - 2 * (qy * qy + qz * qz), 2 * (qx * qy - qw * qz), 2 * (qx * qz + qw * qy)],
        [2 * (qx * qy + qw * qz), 1 - 2 * (qx * qx + qz * qz), 2 * (qy * qz - qw * qx)],
        [2 * (qx * qz - qw * qy), 2 * (qy * qz + qw * qx), 1 - 2 * (qx * qx + qy * qy)]])
    return -rotation.T @ np.array([tx, ty, tz])


def centers_of_colmap(folder):
    """The largest of the models that COLMAP made."""
    best = {}
    for model in sorted(folder.iterdir()):
        run("colmap", "model_converter", "--input_path", model, "--output_path", model,
            "--output_type", "TXT")
        centers = {}
        lines = [line for line in (model / "images.txt").read_text().splitlines()
                 if not line.startswith("#")]
        for line in lines[::2]:
            parts = line.split(maxsplit=9)
            centers[parts[9]] = center(*map(float, parts[1:8]))
        if len(centers) > len(best):
            best = centers
    return best


def errors(found, truth):
    """The distances after the similarity that fits best (Umeyama 1991), by name."""
    names = sorted(set(found) & set(truth))
    if len(names) < 3:
        return {}
    x = np.array([found[name] for name in names])
    y = np.array([truth[name] for name in names])
    # A misplaced photo must not move the others: the fit drops what is far from it.
    use = np.ones(len(names), bool)
    for _ in range(10):
        mx, my = x[use].mean(0), y[use].mean(0)
        u, d, vt = np.linalg.svd((y[use] - my).T @ (x[use] - mx))
        s = np.diag([1, 1, np.sign(np.linalg.det(u @ vt))])
        rotation = u @ s @ vt
        scale = (d * np.diag(s)).sum() / ((x[use] - mx) ** 2).sum()
        distance = np.linalg.norm((x - mx) @ rotation.T * scale + my - y, axis=1)
        near = distance < max(WRONG_M, 4 * np.median(distance))
        if near.sum() < 3 or (near == use).all():
            break
        use = near
    return dict(zip(names, distance))


def map_by_cairn(arguments):
    path = arguments.work / "cairn.gpkg"
    path.unlink(missing_ok=True)
    options = arguments.work / "options.json"
    options.write_text(json.dumps({"mapping": {"sift": {"max_features": arguments.features}}}))
    command = [arguments.cairn, "map", path, arguments.photos, "--session", "photos",
               "--options", options, "--json", *shlex.split(arguments.cairn_options)]
    if arguments.gps:
        command += ["--gps", arguments.gps]
    if arguments.camera:
        command += ["--camera", arguments.camera]
    output, seconds, megabytes = run(*command)
    (arguments.work / "cairn.json").write_text(output)
    return centers_of_map(path), seconds, megabytes


def map_by_colmap(arguments):
    folder = arguments.work / "colmap"
    shutil.rmtree(folder, ignore_errors=True)
    (folder / "sparse").mkdir(parents=True)
    database = folder / "database.db"
    extract = ["colmap", "feature_extractor", "--database_path", database,
               "--image_path", arguments.photos, "--SiftExtraction.use_gpu", "0",
               "--SiftExtraction.max_num_features", arguments.features]
    mapper = ["colmap", "mapper", "--database_path", database, "--image_path", arguments.photos,
              "--output_path", folder / "sparse"]
    if arguments.camera:
        parts = arguments.camera.split(",")
        extract += ["--ImageReader.single_camera", "1", "--ImageReader.camera_model", parts[0],
                    "--ImageReader.camera_params", ",".join(parts[3:])]
        mapper += ["--Mapper.ba_refine_focal_length", "0", "--Mapper.ba_refine_extra_params", "0"]
    matcher = "sequential_matcher" if arguments.sequential else "exhaustive_matcher"
    steps = [run(*extract),
             run("colmap", matcher, "--database_path", database, "--SiftMatching.use_gpu", "0"),
             run(*mapper, refusal="failed to create sparse model")]
    return (centers_of_colmap(folder / "sparse"), sum(step[1] for step in steps),
            max(step[2] for step in steps))


def main():
    arguments = parse_arguments()
    arguments.work.mkdir(parents=True, exist_ok=True)
    truth = read_truth(arguments.truth) if arguments.truth else {}
    num_photos = len(truth) or sum(1 for _ in arguments.photos.iterdir())
    print(f"{'':8} {'photos':>8} {'mean m':>9} {'worst m':>9} {'> 1 m':>6} {'seconds':>8} {'MB':>7}")
    for name, program in (("cairn", map_by_cairn), ("colmap", map_by_colmap)):
        if arguments.only in (None, name):
            centers, seconds, megabytes = program(arguments)
            values = np.array(list(errors(centers, truth).values()) or [math.nan])
            print(f"{name:8} {len(centers):>3} of {num_photos:<3}{values.mean():>9.4f} "
                  f"{values.max():>9.4f} {(values > WRONG_M).sum():>6} {seconds:>8.1f} "
                  f"{megabytes:>7.0f}", flush=True)


if __name__ == "__main__":
    try:
        main()
    except (FailedError, OSError) as error:
        print(f"compare_mapping: {error}", file=sys.stderr)
        sys.exit(2)
