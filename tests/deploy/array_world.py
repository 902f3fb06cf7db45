"""A session for `cairn plan`, and maps to compare: what the checks of the builds by array share."""

import csv
import json
import pathlib
import sqlite3
import subprocess
import sys

# Columns that say when a row was written.
TIMES = {"created_at", "last_change"}


def expect(condition, what):
    if not condition:
        sys.exit(f"failed: {what}")


def output_of(*command, **options):
    finished = subprocess.run(list(map(str, command)), capture_output=True, text=True, **options)
    expect(finished.returncode == 0, f"{command}\n{finished.stdout}\n{finished.stderr}")
    return finished.stdout


class World:
    """A simulated city of a dozen tiles whose photos make two sessions: every other photo each."""

    def __init__(self, build, scratch):
        self.cairn = str(pathlib.Path(build).resolve() / "cli" / "cairn")
        self.folder = pathlib.Path(scratch) / "world"
        lab = pathlib.Path(build).resolve() / "lab" / "cli" / "cairn-lab"
        output_of(lab, "simulate", "--size", "quick", "--area", "0.12", "--colmap", self.folder)
        with open(self.folder / "georef.csv", encoding="utf-8") as table:
            names = [row["image"] for row in csv.DictReader(table)]
        for session, first in (("even", 0), ("odd", 1)):
            (self.folder / f"{session}.txt").write_text("\n".join(names[first::2]) + "\n")

    def arguments(self, session):
        """The options of `cairn ingest` and `cairn plan`."""
        return ["--model", f"{self.folder}/sparse/0", "--database", f"{self.folder}/database.db",
                "--georef", f"{self.folder}/georef.csv", "--images", f"{self.folder}/{session}.txt",
                "--session", session, "--recorded", "2026-01-31T12:00:00Z"]

    def make_map(self, path):
        """A map that has the even photos."""
        output_of(self.cairn, "init", path)
        output_of(self.cairn, "ingest", path, *self.arguments("even"))

    def version(self, path):
        return json.loads(output_of(self.cairn, "info", path, "--json"))["version"]


def contents(path):
    """All rows of a map without the times at which they were written."""
    tables = {}
    with sqlite3.connect(path) as database:
        names = [name for (name,) in database.execute(
            "SELECT name FROM sqlite_master WHERE type = 'table' AND name NOT LIKE 'rtree_%'")]
        for name in names:
            cursor = database.execute(f"SELECT * FROM {name}")
            kept = [i for i, column in enumerate(cursor.description) if column[0] not in TIMES]
            tables[name] = sorted((tuple(row[i] for i in kept) for row in cursor), key=repr)
    database.close()
    return tables


def expect_equal(path, other):
    ours, theirs = contents(path), contents(other)
    different = [name for name in ours if ours[name] != theirs.get(name)]
    expect(ours.keys() == theirs.keys() and not different, f"{path} and {other} differ in {different}")
