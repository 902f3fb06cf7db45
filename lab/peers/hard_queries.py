#!/usr/bin/env python3
"""Asks maps of real photos what invites wrong answers, and compares the answers with their confidence.

Use this program to judge a change of scores, confidences or false alarm rates. Each --set is a COLMAP
model of a place. Its photos make maps of three kinds:
  every N      every N-th photo, from each offset (--sparse N ...)
  run of N     N photos in a row, so that the map knows a part of the place (--partial N ...)
  all but N    all photos except every N-th (--dense N ...)
All other photos of the set are queries of `cairn eval`, of these kinds:
  known        camera, prior and gravity are stated
  free         without gravity
  unknown      only the size of the photo is stated
  permuted     the descriptors are dealt out anew among the keypoints, so every answer is chance
  permuted-free, permuted-unknown: the same without gravity, without camera
A permuted query is asked once for each of --seeds and --prior-noise. The photos of the other sets are
queries as well (elsewhere): they are placed at a keyframe of the map. An answer is right within 3 m and
10 degrees of the model.

The program prints for each kind: queries, answers, right and wrong answers, wrong answers with a
confidence above 0.5 and above 0.9, the sum of the probabilities of being wrong that the answers state,
and the median time of the queries. For chance queries it also prints, for each of some rates, how many
answers state at most this false alarm rate, and how many are to be expected. --csv keeps all answers.
Maps and answers are kept in --work; maps are reused.

Needs `python3`. The exit code is 2 if a file is missing or a program fails.

Example:
  lab/peers/hard_queries.py --cairn build/release/cli/cairn --work /tmp/hard \\
      --set lund lund/colmap_model lund/database.db lund/gps.csv \\
      --set kitti kitti/colmap_model_seq1 kitti/database_seq1.db kitti/georef_seq1.csv \\
      --sparse 4 --partial 5 --seeds 1 2
"""

import argparse
import csv
import pathlib
import sqlite3
import statistics
import subprocess
import sys

RIGHT_M, RIGHT_DEG = 3.0, 10.0
RATES = (0.3, 0.1, 0.03, 0.01, 0.003)
OPTIONS_OF_KIND = {
    "known": (),
    "free": ("--no-gravity",),
    "unknown": ("--unknown-camera",),
    "permuted": ("--permute-descriptors",),
    "permuted-free": ("--permute-descriptors", "--no-gravity"),
    "permuted-unknown": ("--permute-descriptors", "--unknown-camera"),
    "elsewhere": ("--elsewhere",),
    "elsewhere-free": ("--elsewhere", "--no-gravity"),
}


class FailedError(Exception):
    """A program or a file is missing, or a program failed."""


def parse_arguments():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cairn", required=True, help="the cairn binary")
    parser.add_argument("--work", required=True, type=pathlib.Path, help="scratch folder")
    parser.add_argument("--set", required=True, nargs=4, action="append", dest="sets",
                        metavar=("NAME", "MODEL", "DATABASE", "POSITIONS"),
                        help="a COLMAP model, its database, and a CSV of its positions")
    parser.add_argument("--sparse", type=int, nargs="*", default=[4], help="map every n-th photo")
    parser.add_argument("--partial", type=int, nargs="*", default=[], help="map n photos in a row")
    parser.add_argument("--dense", type=int, nargs="*", default=[],
                        help="map all but every n-th photo, only from offset 0")
    parser.add_argument("--kinds", nargs="+", choices=OPTIONS_OF_KIND,
                        default=["known", "free", "unknown", "permuted"])
    parser.add_argument("--seeds", type=int, nargs="+", default=[1])
    parser.add_argument("--prior-noise", type=float, nargs="+", default=[10.0],
                        help="standard deviations of the prior, meters")
    parser.add_argument("--up", help="as in `cairn ingest`, for maps whose positions do not tell")
    parser.add_argument("--min-score", help="as in `cairn eval`")
    parser.add_argument("--leave-out", nargs="+", default=[], metavar="NAME",
                        help="photos that the model misplaces: mapped, but not queried")
    parser.add_argument("--csv", type=pathlib.Path, help="write all answers")
    return parser.parse_args()


def run(*command):
    try:
        result = subprocess.run([str(part) for part in command], stdout=subprocess.PIPE,
                                stderr=subprocess.STDOUT, text=True, check=False)
    except OSError as error:
        raise FailedError(f"{command[0]}: {error.strerror}") from error
    if result.returncode != 0:
        raise FailedError(f"{' '.join(map(str, command))}\n{result.stdout[-2000:]}")


def photo_names(database):
    if not pathlib.Path(database).is_file():
        raise FailedError(f"{database}: not a file")
    with sqlite3.connect(f"file:{database}?mode=ro&immutable=1", uri=True) as connection:
        return sorted(name for (name,) in connection.execute("SELECT name FROM images"))


def maps_to_make(arguments, names):
    """Yields the title and the photos of each map. Two photos make none."""
    for step in arguments.sparse:
        for offset in range(step):
            if len(names[offset::step]) > 2:
                yield f"every_{step}_from_{offset}", names[offset::step]
    for length in arguments.partial:
        for begin in range(0, len(names) - length + 1, length):
            yield f"run_of_{length}_from_{begin}", names[begin:begin + length]
    for step in arguments.dense:
        left_out = set(names[::step])
        yield f"all_but_{step}", [name for name in names if name not in left_out]


def make_map(arguments, photos, mapped, path):
    """Makes a map of the named photos unless the map exists."""
    if path.exists():
        return
    _, model, database, positions = photos
    listed, unfinished = path.with_suffix(".txt"), path.with_suffix(".part")
    listed.write_text("".join(name + "\n" for name in mapped))
    unfinished.unlink(missing_ok=True)
    run(arguments.cairn, "init", unfinished)
    run(arguments.cairn, "ingest", unfinished, "--images", listed, "--model", model,
        "--database", database, "--georef", positions, *(("--up", arguments.up) if arguments.up else ()))
    unfinished.rename(path)


def ask(arguments, path, photos, kind, seed, noise_m):
    """Returns the answers of a map to the photos of a set, as rows of `cairn eval`."""
    name, model, database, positions = photos
    answers = path.with_suffix(f".{name}.{kind}.{seed}.{noise_m:g}.csv")
    run(arguments.cairn, "eval", path, "--model", model, "--database", database, "--georef", positions,
        "--seed", seed, "--prior-noise", noise_m, "--csv", answers, *OPTIONS_OF_KIND[kind],
        *(("--min-score", arguments.min_score) if arguments.min_score else ()))
    with answers.open(newline="") as file:
        return [row for row in csv.DictReader(file) if row["name"] not in arguments.leave_out]


def is_right(row):
    return float(row["position_error_m"]) < RIGHT_M and float(row["rotation_error_deg"]) < RIGHT_DEG


def is_chance(kind):
    return not kind.startswith(("known", "free", "unknown"))


def ask_all(arguments):
    """Returns the answers of all maps, with columns that say which map and which query."""
    rows = []
    for photos in arguments.sets:
        for title, mapped in maps_to_make(arguments, photo_names(photos[2])):
            path = arguments.work / f"{photos[0]}_{title}.gpkg"
            make_map(arguments, photos, mapped, path)
            for kind in arguments.kinds:
                asked = ([other for other in arguments.sets if other is not photos]
                         if kind.startswith("elsewhere") else [photos])
                repeats = is_chance(kind)
                for seed in arguments.seeds if repeats else arguments.seeds[:1]:
                    for noise_m in arguments.prior_noise if repeats else arguments.prior_noise[:1]:
                        for of_set in asked:
                            rows += [{"map": path.stem, "asked": of_set[0], "kind": kind,
                                      "seed": seed, "noise_m": noise_m, **row}
                                     for row in ask(arguments, path, of_set, kind, seed, noise_m)]
            print(f"{path.stem}: {len(mapped)} photos mapped", file=sys.stderr, flush=True)
    return rows


def print_kinds(rows):
    columns = ("queries", "answers", "right", "wrong", "wrong>0.5", "wrong>0.9", "expected", "ms")
    print(f"{'kind':18}" + "".join(f"{column:>11}" for column in columns))
    for kind in dict.fromkeys(row["kind"] for row in rows):
        of_kind = [row for row in rows if row["kind"] == kind]
        answers = [row for row in of_kind if row["localized"] == "1"]
        wrong = [float(row["confidence"]) for row in answers if is_chance(kind) or not is_right(row)]
        counts = (len(of_kind), len(answers), len(answers) - len(wrong), len(wrong),
                  sum(confidence > 0.5 for confidence in wrong),
                  sum(confidence > 0.9 for confidence in wrong))
        doubt = sum(1.0 - float(row["confidence"]) for row in answers)
        time_ms = statistics.median(float(row["total_ms"]) for row in of_kind)
        print(f"{kind:18}" + "".join(f"{count:>11}" for count in counts) +
              f"{doubt:>11.1f}{time_ms:>11.1f}")


def print_false_alarms(rows):
    chance = [row for row in rows if is_chance(row["kind"])]
    if not chance:
        return
    print(f"\n{'false alarm rate':18}{'answers':>11}{'expected':>11}   of {len(chance)} chance queries")
    stated = [float(row["false_alarm_rate"]) for row in chance if row["localized"] == "1"]
    for rate in RATES:
        print(f"at most {rate:<10g}{sum(value <= rate for value in stated):>11}"
              f"{rate * len(chance):>11.1f}")


def main():
    arguments = parse_arguments()
    arguments.work.mkdir(parents=True, exist_ok=True)
    rows = ask_all(arguments)
    if not rows:
        raise FailedError("there are no queries: choose maps with --sparse, --partial or --dense")
    if arguments.csv:
        with arguments.csv.open("w", newline="") as file:
            writer = csv.DictWriter(file, rows[0].keys())
            writer.writeheader()
            writer.writerows(rows)
    print_kinds(rows)
    print_false_alarms(rows)


if __name__ == "__main__":
    try:
        main()
    except FailedError as error:
        print(error, file=sys.stderr)
        sys.exit(2)
