#!/usr/bin/env python3
"""Makes a map of a walk, asks it where some of the photos were taken, and draws the errors.

    map_and_evaluate.py MAP.gpkg PHOTOS --gps positions.csv --queries queries.json --plot errors.png

Without --gps, the positions are those of the photos' EXIF. Without --queries, the photos
themselves are the queries, which a map knows better than others. matplotlib draws the plot.
"""

import argparse
import pathlib

import numpy as np

import cairn


def ask_with_own_photos(path: pathlib.Path, photos: pathlib.Path) -> None:
    with cairn.Map(path) as town:
        keyframes = town.keyframes()
        results = town.localize_many(photos / name for name in keyframes["image"])
        for keyframe, result in zip(keyframes, results):
            error_m = (float(np.linalg.norm(result.ecef_from_cam[:3, 3]
                                            - keyframe["ecef_from_cam"][:3, 3]))
                       if result.ecef_from_cam is not None else np.inf)
            print(f"{keyframe['image']:20} {error_m:8.3f} m  confidence {result.confidence:.3f}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("map", type=pathlib.Path)
    parser.add_argument("photos", type=pathlib.Path)
    parser.add_argument("--gps", type=pathlib.Path)
    parser.add_argument("--queries", type=pathlib.Path)
    parser.add_argument("--plot", type=pathlib.Path)
    arguments = parser.parse_args()
    summary = cairn.map(arguments.map, arguments.photos, gps=arguments.gps,
                        progress=lambda phase, done, total: print(f"{phase} {done}/{total}"))
    print(f"session {summary.session} is in version {summary.map_version}")
    if arguments.queries is None:
        ask_with_own_photos(arguments.map, arguments.photos)
        return
    report = cairn.evaluate(arguments.map, arguments.queries)
    print(report)
    if arguments.plot is not None:
        report.plot().figure.savefig(arguments.plot)


if __name__ == "__main__":
    main()
