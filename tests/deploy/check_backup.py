#!/usr/bin/env python3
"""Backs up a served map while updates are published, as docs/operations.md says, and restores it. The exit
code is 77 if sqlite3 is not installed.

Usage: check_backup.py BUILD_FOLDER
"""

import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import threading

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent.parent / "deploy" / "bench"))
import cluster

SKIPPED = 77


def output_of(*command):
    return subprocess.run(command, check=True, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                          text=True).stdout


class Publisher(threading.Thread):
    """Publishes the contents of two versions in turn until it is told to stop."""

    def __init__(self, cairn, map_path, versions):
        super().__init__()
        self.cairn, self.map_path, self.versions = cairn, map_path, versions
        self.num_published = 0
        self.stopping = False

    def run(self):
        while not self.stopping:
            output_of(self.cairn, "rollback", self.map_path, str(self.versions[self.num_published % 2]))
            self.num_published += 1


def expect(condition, what):
    if not condition:
        sys.exit(f"failed: {what}")


def version_of(cairn, map_path):
    return json.loads(output_of(cairn, "info", map_path, "--json"))["version"]


def back_up(cairn, map_path, copy):
    """Backs up while versions are published."""
    head = version_of(cairn, map_path)
    publisher = Publisher(cairn, map_path, (head - 1, head))
    publisher.start()
    cluster.wait_until(lambda: publisher.num_published > 0, "an update")
    first = version_of(cairn, map_path)
    output_of("sqlite3", map_path, f".backup '{copy}'")
    num_at_backup = publisher.num_published
    cluster.wait_until(lambda: publisher.num_published > num_at_backup + 1, "a later update")
    publisher.stopping = True
    publisher.join()
    expect(first <= version_of(cairn, copy) < version_of(cairn, map_path),
           "the copy has a version of its time")


def main():
    if shutil.which("sqlite3") is None:
        print("skipped: sqlite3 is not installed (scripts/install-dependencies --tests)")
        return SKIPPED
    build = pathlib.Path(sys.argv[1])
    cairn = str(build / "cli" / "cairn")
    with tempfile.TemporaryDirectory() as scratch:
        map_path, copy = f"{scratch}/city.gpkg", f"{scratch}/copy.gpkg"
        output_of(str(build / "lab" / "cli" / "cairn-lab"), "simulate", "--size", "quick", "--area", "0.1",
                  "--num-queries", "1", "--map", map_path)
        server = cluster.Server(cairn, map_path, cache_mb=64)
        try:
            back_up(cairn, map_path, copy)
            output_of(cairn, "check", copy)
            backed_up = version_of(cairn, copy)
            os.rename(copy, map_path)
            cluster.wait_until(lambda: server.map_version() == backed_up, "the restored map")
        finally:
            server.close()
    print(f"version {backed_up} was backed up while others were published, and restored under a server")
    return 0


if __name__ == "__main__":
    sys.exit(main())
