#!/usr/bin/env python3
"""Asks sparse maps of real photos for the photos they lack: what a change of the engine is judged by
beside simulated cities, whose lenient matches are wrong too rarely.

For each step n of --steps and each offset below n, every n-th photo of the model is mapped and all
others are queries of `cairn eval`, with its prior (10 m) and gravity (1 degree off); for each step of
--dense it is the other way round. Right is an answer within 3 m and 10 degrees of the model. Maps are
kept in --work and used again. Below the counts stands what the confidence of the answers says, in five
parts from the least confident on, and how many of them were right.

With `--features both` each map is asked twice, with the model's features and with those that Cairn
extracts from the photos, and the difference of the shares is printed, in the mean over the maps, with
its 95 % bootstrap interval over maps and photos.

Needs `python3`. Ends with 2 if something is missing or fails.

Example:
  lab/peers/sparse_maps.py --cairn build/release/cli/cairn --images lund/images \\
      --model lund/colmap_model --database lund/database.db --work /tmp/sparse --leave-out 20.jpg
"""

import argparse
import csv
import pathlib
import random
import subprocess
import sys

RIGHT_M, RIGHT_DEG = 3.0, 10.0
NEAR_M, NEAR_DEG = 0.5, 5.0
NUM_PARTS = 5  # Of the answers by confidence.
NUM_RESAMPLES = 2000
COLUMNS = ("queries", "localized", "right", "near", "ambiguous")


class FailedError(Exception):
    """A program or a file is missing, or a program failed."""


def parse_arguments():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cairn", required=True, help="the cairn binary")
    parser.add_argument("--images", required=True, type=pathlib.Path,
                        help="folder of the model's photos, with GPS positions")
    parser.add_argument("--model", required=True, type=pathlib.Path, help="COLMAP model")
    parser.add_argument("--database", required=True, type=pathlib.Path, help="its database")
    parser.add_argument("--work", required=True, type=pathlib.Path, help="scratch folder")
    parser.add_argument("--steps", type=int, nargs="+", default=[3, 4, 5],
                        help="every n-th photo is mapped")
    parser.add_argument("--dense", type=int, nargs="+", default=[],
                        help="all photos but every n-th are mapped")
    parser.add_argument("--features", choices=["model", "extract", "both"], default="model",
                        help="what is asked with: the model's features, or fresh ones of the photos")
    parser.add_argument("--georef", type=pathlib.Path,
                        help="camera positions, instead of the GPS of the photos")
    parser.add_argument("--leave-out", nargs="+", default=[], metavar="NAME",
                        help="photos that the model misplaces: mapped, but not asked for")
    parser.add_argument("--index", default="random_grids", help="as `cairn eval` has it")
    arguments = parser.parse_args()
    if min(arguments.steps + arguments.dense, default=2) < 2:
        parser.error("steps begin at 2, or no photo is left to map or to ask for")
    return arguments


def run(*command):
    try:
        result = subprocess.run([str(part) for part in command], stdout=subprocess.PIPE,
                                stderr=subprocess.STDOUT, text=True, check=False)
    except OSError as error:
        raise FailedError(f"{command[0]}: {error.strerror}") from error
    if result.returncode != 0:
        raise FailedError(f"{' '.join(map(str, command))}\n{result.stdout[-2000:]}")


def photo_names(folder):
    if not folder.is_dir():
        raise FailedError(f"{folder}: not a folder")
    return sorted(path.name for path in folder.iterdir()
                  if path.suffix.lower() in (".jpg", ".jpeg", ".png"))


def model_options(arguments):
    positions = ("--georef", arguments.georef) if arguments.georef else ("--gps",)
    return ("--model", arguments.model, "--database", arguments.database, *positions)


def make_map(arguments, names, path):
    """A map of some photos, unless it is there."""
    if path.exists():
        return
    listed, unfinished = path.with_suffix(".txt"), path.with_suffix(".part")
    listed.write_text("".join(name + "\n" for name in names))
    unfinished.unlink(missing_ok=True)
    run(arguments.cairn, "init", unfinished)
    run(arguments.cairn, "ingest", unfinished, "--images", listed, *model_options(arguments))
    unfinished.rename(path)


def ask(arguments, path, features, judged, outcomes):
    """How many queries ended how, by COLUMNS; appends (confidence, whether right) of answers, and of
    every query whether it was answered and whether rightly."""
    answers = path.with_suffix(f".{features}.csv")
    run(arguments.cairn, "eval", path, *model_options(arguments), "--image-dir", arguments.images,
        "--features", features, "--index", arguments.index, "--csv", answers)
    counts = dict.fromkeys(COLUMNS, 0)
    with answers.open(newline="") as file:
        for row in csv.DictReader(file):
            if row["name"] in arguments.leave_out:
                continue
            counts["queries"] += 1
            counts["ambiguous"] += row["reason"] == "AMBIGUOUS"
            is_right = False
            if row["localized"] == "1":
                error_m = float(row["position_error_m"])
                error_deg = float(row["rotation_error_deg"])
                is_right = error_m < RIGHT_M and error_deg < RIGHT_DEG
                judged.append((float(row["confidence"]), is_right))
                counts["localized"] += 1
                counts["right"] += is_right
                counts["near"] += error_m < NEAR_M and error_deg < NEAR_DEG
            outcomes.append((row["localized"] == "1", is_right))
    return counts


def print_row(name, counts):
    print(f"{name:16}" + "".join(f"{counts[column]:>11}" for column in COLUMNS), flush=True)


def print_confidence(judged):
    print(f"\n{'confidence':16}{'mean':>11}{'right':>11}{'answers':>11}")
    judged = sorted(judged)
    parts = [judged[len(judged) * i // NUM_PARTS:len(judged) * (i + 1) // NUM_PARTS]
             for i in range(NUM_PARTS)]
    for part in [part for part in parts if part] + [judged]:
        mean, right = (sum(values) / len(part) for values in zip(*part))
        print(f"{part[0][0]:.3f} to {part[-1][0]:.3f}  {mean:>11.3f}{right:>11.3f}{len(part):>11}")


def mean_over_maps(maps):
    """Of the differences (answered, right) of each map's queries."""
    means = [[sum(values) / len(queries) for values in zip(*queries)] for queries in maps]
    return [sum(values) / len(means) for values in zip(*means)]


def print_difference(outcomes):
    """Extracted features against the model's; outcomes[features][map] are lists of what ask gives."""
    maps = [[(int(ours[0]) - int(theirs[0]), int(ours[1]) - int(theirs[1]))
             for ours, theirs in zip(*pair, strict=True)]
            for pair in zip(outcomes["extract"], outcomes["model"], strict=True)]
    maps = [queries for queries in maps if queries]
    rng = random.Random(1)
    resampled = [mean_over_maps([rng.choices(queries, k=len(queries))
                                 for queries in rng.choices(maps, k=len(maps))])
                 for _ in range(NUM_RESAMPLES)]
    print("\nextracted minus model's, mean over maps:")
    for i, (name, mean) in enumerate(zip(("answered", "right"), mean_over_maps(maps))):
        ordered = sorted(sample[i] for sample in resampled)
        low, high = ordered[int(0.025 * NUM_RESAMPLES)], ordered[int(0.975 * NUM_RESAMPLES)]
        print(f"{name:16}{mean:>+11.3f} [{low:+.3f}, {high:+.3f}]")


def maps_to_make(arguments, names):
    """Of each map its title, file and photos."""
    for step in arguments.steps:
        for offset in range(step):
            yield (f"every {step} from {offset}",
                   arguments.work / f"every_{step}_from_{offset}.gpkg", names[offset::step])
    for step in arguments.dense:
        for offset in range(step):
            left_out = set(names[offset::step])
            yield (f"without {step} from {offset}",
                   arguments.work / f"without_{step}_from_{offset}.gpkg",
                   [name for name in names if name not in left_out])


def ask_all(arguments, features, judged):
    """Makes and asks all maps; of each, the outcomes of its queries."""
    print(f"{'mapped':16}" + "".join(f"{column:>11}" for column in COLUMNS))
    total = dict.fromkeys(COLUMNS, 0)
    outcomes = []
    for title, path, mapped in maps_to_make(arguments, photo_names(arguments.images)):
        make_map(arguments, mapped, path)
        outcomes.append([])
        counts = ask(arguments, path, features, judged, outcomes[-1])
        print_row(title, counts)
        total = {column: total[column] + counts[column] for column in COLUMNS}
    print_row("all", total)
    return outcomes


def main():
    arguments = parse_arguments()
    arguments.work.mkdir(parents=True, exist_ok=True)
    both = arguments.features == "both"
    outcomes = {}
    for features in ("model", "extract") if both else (arguments.features,):
        if both:
            print(f"\nfeatures: {features}")
        judged = []
        outcomes[features] = ask_all(arguments, features, judged)
        if judged:
            print_confidence(judged)
    if both:
        print_difference(outcomes)


if __name__ == "__main__":
    try:
        main()
    except FailedError as error:
        print(error, file=sys.stderr)
        sys.exit(2)
