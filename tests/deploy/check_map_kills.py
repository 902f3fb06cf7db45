#!/usr/bin/env python3
"""Kills `cairn map` (SIGKILL) at moments that are spread evenly over each command, and runs it again. Then runs
it on disks that are too small (for root, a tmpfs), and again on a larger one.

  folder    one folder becomes a map
  guessed   the same, with a focal length that nobody states
  folders   two folders become the sessions of a map
  join      a folder joins a map
  again     two folders, of which the map has one

After each kill, and on a full disk, the map is as before or as after the command, and `cairn check` is clean. The command
succeeds when it is repeated with the same work folder and another number of threads, leaves the bytes of an
undisturbed run, and no files but those of one. A session that joins may be numbered differently, because ids
that a killed run reserved are not given out again. A full disk ends the command with a sentence. Prints a table; the exit code is 1 if a line is not met.

Example:
  tests/deploy/check_map_kills.py build/release --kills 100
"""

import argparse
import contextlib
import copy
import csv
import itertools
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

import check_faults

# Two walks along the same houses.
WALKS = {"monday": range(0, 10, 2), "tuesday": range(1, 10, 2)}
FEW_FEATURES = '{"mapping": {"sift": {"max_features": 600}}}'
SCRATCH_BYTES = 600 * 128  # Of a photo's descriptors.
# What each command maps, and the folders of the map that it finds; none: it makes the map.
RECIPES = {"folder": (["monday"], []), "guessed": (["monday"], []),
           "folders": (["monday", "tuesday"], []),
           "join": (["tuesday"], ["monday"]), "again": (["tuesday", "monday"], ["monday"])}


def parse_arguments():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", type=pathlib.Path, help="build folder, as build/release")
    parser.add_argument("--kills", type=int, default=100, help="number of kills, over all commands")
    parser.add_argument("--case", action="append", choices=RECIPES, help="only this command; repeatable")
    return parser.parse_args()


def make_photos(build, folder):
    """Rendered photos in a folder for each walk, and a table of their positions."""
    subprocess.run([build / "tests" / "python" / "cairn_make_street", folder / "street", "--photos"],
                   check=True)
    with open(folder / "street" / "positions.csv", newline="", encoding="utf-8") as table:
        header, *rows = csv.reader(table)
    names = sorted(os.listdir(folder / "street" / "photos"))
    walks = folder / "walks"
    with open(folder / "positions.csv", "w", newline="", encoding="utf-8") as table:
        writer = csv.writer(table)
        writer.writerow(header)
        for walk, numbers in WALKS.items():
            (walks / walk).mkdir(parents=True)
            for name in (names[number] for number in numbers):
                shutil.copy(folder / "street" / "photos" / name, walks / walk / f"{walk}_{name}")
                writer.writerow([f"{walk}_{name}", *next(row for row in rows if row[0] == name)[1:]])
    (folder / "options.json").write_text(FEW_FEATURES, encoding="utf-8")
    return walks


class MapCase(check_faults.Case):
    """`cairn map` of some walks."""

    def __init__(self, commands, name, scratch, walks):
        mapped, known = RECIPES[name]
        folder = scratch / name
        folder.mkdir()
        camera = [] if name == "guessed" else ["--camera", "PINHOLE,480,360,320,320,240,180"]
        threads = itertools.cycle(["1", "2"])

        def arguments(work, of_walks=mapped, stages="w"):
            return ["map", work / "town.gpkg", *[walks / walk for walk in of_walks], "--gps",
                    scratch / "positions.csv", *camera, "--threads", next(threads), "--options", scratch / "options.json", "--recorded", "2026-01-31T12:00:00Z",
                    "--work", work / stages]

        self.makes_map = not known
        for walk in known:
            commands.output_of(*arguments(folder, [walk], "known"))
        super().__init__(commands, name, folder, arguments, ["town.gpkg"], is_repeatable=True)


def run_case(case, count):
    """(what happened, problems)"""
    problems, num_killed, num_published, num_same = [], 0, 0, 0
    for seconds in check_faults.moments(case.seconds, 4 * count):
        work = case.prepare("kill")
        num_killed += check_faults.kill_after(case.commands.start(*case.arguments(work)), seconds)
        num_published += case.states(work) != case.before
        problems += case.problems_of(work)
        is_same = case.states(work) == case.after
        num_same += is_same
        if case.makes_map and not is_same:
            problems.append("the repeated command leaves other bytes")
        shutil.rmtree(work)
        if num_killed == count:
            break
    if num_killed < count:
        problems.append(f"the command ended {4 * count - num_killed} times before it was killed")
    return (f"{num_killed} kills, {num_published} runs had published a session, "
            f"{num_same} end with the same bytes"), problems


@contextlib.contextmanager
def small_disk(mount, num_bytes):
    """A disk of that size; None if it cannot be mounted."""
    mount.mkdir(exist_ok=True)
    if subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={num_bytes}", "tmpfs", mount], check=False,
                      stderr=subprocess.DEVNULL).returncode != 0:
        yield None
        return
    try:
        yield mount
    finally:
        subprocess.run(["umount", mount], check=True)


def with_scratch_in(commands, folder):
    """The same commands with their temporary files in this folder."""
    moved = copy.copy(commands)
    moved.temporary = folder
    moved.temporary.mkdir()
    moved.environment = dict(commands.environment, TMPDIR=str(folder), SQLITE_TMPDIR=str(folder))
    return moved


def problems_of_refusal(code, errors, scratch):
    problems = [] if code in (0, check_faults.IO_FAILURE) else [f"exit code {code}: {errors}"]
    if code != 0 and "No space left on device" not in errors and "disk is full" not in errors:
        problems.append(f"the error does not say that the disk is full: {errors}")
    if any(scratch.iterdir()):
        problems.append(f"temporary files {list(scratch.iterdir())}")
    return problems


def run_on_small_disks(case, num_photos, mount):
    """(what happened, problems); None if no disk can be mounted. All files of the command are on the disk."""
    work = case.prepare("roomy")
    case.commands.output_of(*case.arguments(work))
    need = sum(file.stat().st_size for file in work.rglob("*") if file.is_file()) + num_photos * SCRATCH_BYTES
    shutil.rmtree(work)
    problems, num_failed = [], 0
    shares = (0.1, 0.3, 0.5, 0.7, 0.9)
    for share in shares:
        before = sum(file.stat().st_size for file in case.folder.rglob("*") if file.is_file())
        with small_disk(mount, before + 65_536 + int(share * (need - before))) as disk:
            if disk is None:
                return None
            commands = with_scratch_in(case.commands, disk / "tmp")
            work = pathlib.Path(shutil.copytree(case.folder, disk / "work"))
            code, _, errors = commands.run(*case.arguments(work))
            num_failed += code != 0
            problems += problems_of_refusal(code, errors, commands.temporary)
            problems += case.problems_of_maps(work)
            roomy = pathlib.Path(shutil.copytree(work, case.folder.parent / f"{case.name}-moved"))
        problems += case.problems_of(roomy)
        shutil.rmtree(roomy)
    problems += problems_without_scratch(case, mount)
    return f"{num_failed} of {len(shares)} refused, and 1 of 1 without room for scratch files", problems


def problems_without_scratch(case, mount):
    """What is wrong if only the scratch file has no room."""
    work = case.prepare("full")
    with small_disk(mount, SCRATCH_BYTES) as disk:
        commands = with_scratch_in(case.commands, disk / "tmp")
        code, _, errors = commands.run(*case.arguments(work))
        problems = problems_of_refusal(code, errors, commands.temporary)
        if code == 0 or f"{commands.temporary}: " not in errors or "variable TMPDIR" not in errors:
            problems.append(f"the error does not name the folder: exit code {code}, {errors}")
    problems += case.problems_of_maps(work)
    problems += case.problems_of(work)
    shutil.rmtree(work)
    return problems


def main():
    arguments = parse_arguments()
    is_met = True
    with tempfile.TemporaryDirectory() as folder:
        scratch = pathlib.Path(folder)
        commands = check_faults.Commands(arguments.build.resolve(), scratch)
        walks = make_photos(arguments.build.resolve(), scratch)
        names = arguments.case or list(RECIPES)
        print("| | measured | met |\n|---|---|---|", flush=True)
        for name, count in zip(names, check_faults.shares(arguments.kills, len(names))):
            case = MapCase(commands, name, scratch, walks)
            num_photos = sum(len(WALKS[walk]) for walk in RECIPES[name][0])
            rows = {f"kills over {1e3 * case.seconds:.0f} ms": run_case(case, count),
                    "small disks": run_on_small_disks(case, num_photos, scratch / "disk")}
            for disturbance, result in rows.items():
                if result is None:
                    print("skipped: a small disk can only be mounted by root")
                    continue
                what, problems = result
                is_met = is_met and not problems
                print(f"| {name}: {disturbance} | {what} | {'NO' if problems else 'yes'} |", flush=True)
                for problem in problems[:3]:
                    print(f"  {name}: {problem}", file=sys.stderr, flush=True)
    return 0 if is_met else 1


if __name__ == "__main__":
    sys.exit(main())
