#!/usr/bin/env python3
"""Makes sessions of one map from two walks by `cairn map`, and measures how well the walks fit each other.

The walks are mapped by one command, and by two commands in both orders. The cameras of the first walk
are moved onto the truth by the similarity that fits best; printed are the distances of the cameras of
the second walk from the truth (mean and largest), and those of the first. A walk is a folder with images/,
gps_3m.csv and truth.csv (the columns of compare_mapping.py), and both truths have one frame.

Needs `python3-numpy`. An order that fails is a line of the table; the exit code is 2 if a file is missing.

Example:
  lab/peers/compare_walks.py --cairn build/release/cli/cairn --work /tmp/walks \\
      --camera PINHOLE,1536,1024,1379.74,1382.08,760.595,503.655 Herz-Jesus-P25 Herz-Jesus-P8
"""

import argparse
import csv
import pathlib
import sys

import numpy as np

from compare_mapping import FailedError, centers_of_map, read_truth, run


def parse_arguments():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("walks", nargs=2, type=pathlib.Path, help="the walk that is aligned, the other")
    parser.add_argument("--cairn", required=True, help="the cairn binary")
    parser.add_argument("--work", required=True, type=pathlib.Path, help="scratch folder")
    parser.add_argument("--camera", help="intrinsics, as of cairn map --camera")
    return parser.parse_args()


def gather(walks, work):
    """A folder of photos for each walk, under names that tell the walks apart, and one table of positions.
    Returns the true centers by walk."""
    truths = []
    with open(work / "gps.csv", "w", newline="", encoding="utf-8") as table:
        writer = csv.writer(table)
        for walk in walks:
            folder = work / walk.name
            folder.mkdir(parents=True, exist_ok=True)
            for photo in sorted((walk / "images").iterdir()):
                link = folder / f"{walk.name}_{photo.name}"
                link.unlink(missing_ok=True)
                link.symlink_to(photo.resolve())
            with open(walk / "gps_3m.csv", newline="", encoding="utf-8") as gps:
                header, *rows = csv.reader(gps)
            if walk == walks[0]:
                writer.writerow(header)
            writer.writerows([f"{walk.name}_{row[0]}", *row[1:]] for row in rows)
            truth = read_truth(walk / "truth.csv")
            truths.append({f"{walk.name}_{name}": x for name, x in truth.items()})
    return truths


def similarity(found, wanted):
    """Scale, rotation and translation from the rows of `found` to those of `wanted` (Umeyama 1991)."""
    x, y = found - found.mean(0), wanted - wanted.mean(0)
    u, d, vt = np.linalg.svd(y.T @ x)
    signs = np.diag([1, 1, np.sign(np.linalg.det(u @ vt))])
    rotation = u @ signs @ vt
    scale = (d * np.diag(signs)).sum() / (x ** 2).sum()
    return scale, rotation, wanted.mean(0) - scale * rotation @ found.mean(0)


def misfits(centers, truths):
    """Errors of the cameras of both walks in meters, once the first walk is on its truth."""
    arrays = []
    for truth in truths:
        names = sorted(set(truth) & set(centers))
        if len(names) < 3:
            raise FailedError(f"the map has {len(names)} photos of a walk")
        arrays.append((np.array([centers[name] for name in names]),
                       np.array([truth[name] for name in names])))
    scale, rotation, translation = similarity(*arrays[0])
    return [np.linalg.norm(scale * found @ rotation.T + translation - wanted, axis=1)
            for found, wanted in arrays]


def map_walks(arguments, commands, name):
    path = arguments.work / f"{name}.gpkg"
    path.unlink(missing_ok=True)
    for walks in commands:
        # Stages of a walk are the same whatever the order.
        stages = arguments.work / "w" if len(walks) > 1 else arguments.work / "w" / walks[0].name
        command = [arguments.cairn, "map", path, *[arguments.work / walk.name for walk in walks],
                   "--gps", arguments.work / "gps.csv", "--work", stages, "--json"]
        run(*command, *(["--camera", arguments.camera] if arguments.camera else []))
    return centers_of_map(path)


def main():
    arguments = parse_arguments()
    arguments.work.mkdir(parents=True, exist_ok=True)
    first, second = arguments.walks
    truths = gather(arguments.walks, arguments.work)
    print(f"{'':34} {'second walk, mean and worst mm':>32} {'first walk':>16}")
    for name, commands in ((f"{first.name} and {second.name}", [[first, second]]),
                           (f"{second.name} and {first.name}", [[second, first]]),
                           (f"{first.name}, then {second.name}", [[first], [second]]),
                           (f"{second.name}, then {first.name}", [[second], [first]])):
        try:
            of_first, of_second = misfits(map_walks(arguments, commands, "town"), truths)
        except FailedError as error:
            print(f"{name:34} {error}", flush=True)
            continue
        print(f"{name:34} {1e3 * of_second.mean():>22.1f} {1e3 * of_second.max():>9.1f} "
              f"{1e3 * of_first.mean():>8.1f} {1e3 * of_first.max():>7.1f}", flush=True)


if __name__ == "__main__":
    try:
        main()
    except (FailedError, OSError) as error:
        print(error, file=sys.stderr)
        sys.exit(2)
