#!/usr/bin/env python3
"""Makes sparse maps of real photos and queries them with the photos that are not in the map.

Use this program besides simulated cities to judge a change of the engine: the lenient matches of
simulated cities are wrong too rarely.

For each step n of --steps and each offset below n, every n-th photo of the model makes the map. All
other photos are queries of `cairn eval`, with its prior (10 m) and gravity (1 degree off). For each step
of --dense, the roles are exchanged. An answer is right within 3 m and 10 degrees of the model. Maps are
kept in --work and reused. Below the counts, the program divides the answers by confidence into five
parts, from the lowest on, and prints the mean confidence and the share of right answers of each part.

With `--features both`, each map is queried twice: with the model's features, and with features that
Cairn extracts from the photos. The program then prints the difference of the shares in the mean over
the maps, with its 95 % bootstrap interval over maps and photos.

Needs `python3`. The exit code is 2 if a file is missing or a program fails.

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
NUM_PARTS = 5  # Parts of the answers, by confidence.
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
                        help="every photo except each n-th is mapped")
    parser.add_argument("--features", choices=["model", "extract", "both"], default="model",
                        help="features of the queries: the model's, or extracted from the photos")
    parser.add_argument("--georef", type=pathlib.Path,
                        help="camera positions, instead of the GPS of the photos")
    parser.add_argument("--leave-out", nargs="+", default=[], metavar="NAME",
                        help="photos that the model misplaces: mapped, but not queried")
    parser.add_argument("--index", default="random_grids", help="kind of index, as in `cairn eval`")
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
    """Makes a map of the named photos unless the map exists."""
    if path.exists():
        return
    listed, unfinished = path.with_suffix(".txt"), path.with_suffix(".part")
    listed.write_text("".join(name + "\n" for name in names))
    unfinished.unlink(missing_ok=True)
    run(arguments.cairn, "init", unfinished)
    run(arguments.cairn, "ingest", unfinished, "--images", listed, *model_options(arguments))
    unfinished.rename(path)


def ask(arguments, path, features, judged, outcomes):
    """Returns the counts of COLUMNS. Appends (confidence, is right) of each answer to `judged`, and
    (is answered, is right) of each query to `outcomes`."""
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
    """Returns the mean over maps of the mean (answered, right) difference of a map's queries."""
    means = [[sum(values) / len(queries) for values in zip(*queries)] for queries in maps]
    return [sum(values) / len(means) for values in zip(*means)]


def print_difference(outcomes):
    """Compares extracted features with the model's. outcomes[features][map] lists outcomes of ask()."""
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
    """Yields the title, the file and the photos of each map."""
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
    """Makes and queries all maps. Returns the outcomes of the queries of each map."""
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
