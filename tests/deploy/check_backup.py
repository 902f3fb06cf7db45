#!/usr/bin/env python3
"""Backs up maps while updates are published, as docs/operations.md says, and restores them: a file under a
server that serves it, and a PostgreSQL database as the roles of docs/postgresql.md. Prints what it skips, because a program is not installed;
the exit code is 77 if it skips both.

Usage: check_backup.py BUILD_FOLDER [--without-postgres]
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
import database

SKIPPED = 77
# As docs/postgresql.md makes them; none has rights of a superuser.
ROLES = ["cairn_reader NOLOGIN", "cairn_builder NOLOGIN IN ROLE cairn_reader", "builder LOGIN",
         "server LOGIN IN ROLE cairn_reader", "backup LOGIN IN ROLE cairn_reader"]


def expect(condition, what):
    if not condition:
        sys.exit(f"failed: {what}")


def output_of(*command):
    finished = subprocess.run(command, capture_output=True, text=True)
    expect(finished.returncode == 0, f"{command}\n{finished.stdout}\n{finished.stderr}")
    return finished.stdout


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


def version_of(cairn, map_path):
    return json.loads(output_of(cairn, "info", map_path, "--json"))["version"]


def back_up(cairn, map_path, command):
    """Runs a backup while versions are published. Returns the range of versions that it may have."""
    head = version_of(cairn, map_path)
    publisher = Publisher(cairn, map_path, (head - 1, head))
    publisher.start()
    cluster.wait_until(lambda: publisher.num_published > 0, "an update")
    first = version_of(cairn, map_path)
    output_of(*command)
    last = version_of(cairn, map_path)
    num_at_backup = publisher.num_published
    cluster.wait_until(lambda: publisher.num_published > num_at_backup + 1, "a later update")
    publisher.stopping = True
    publisher.join()
    return range(first, last + 1)


def check_file(cairn, map_path, scratch):
    copy = f"{scratch}/copy.gpkg"
    server = cluster.Server(cairn, map_path, cache_mb=64)
    try:
        # Without the timeout, a backup may end with "database is locked".
        possible = back_up(cairn, map_path, ["sqlite3", "-cmd", ".timeout 60000", map_path,
                                             f".backup '{copy}'"])
        output_of(cairn, "check", copy)
        version = version_of(cairn, copy)
        expect(version in possible, "the copy has a version of its time")
        os.rename(copy, map_path)
        for end in ("-wal", "-shm"):  # Of the map before; nobody may read them into the new one.
            pathlib.Path(map_path + end).unlink(missing_ok=True)
        cluster.wait_until(lambda: server.map_version() == version, "the restored map")
        output_of(cairn, "check", map_path)
    finally:
        server.close()
    print(f"file: version {version} was backed up while others were published, and restored under a server")


def check_database(cairn, map_path, scratch):
    dump = f"{scratch}/city.dump"
    store = database.Database()
    try:
        for role in ROLES:
            output_of("psql", store.url("postgres"), "--command", f"CREATE ROLE {role}")
        for name in ("city", "restored"):
            output_of("psql", store.url("postgres"), "--command", f"CREATE DATABASE {name} OWNER builder")
            output_of("psql", store.url(name), "--command", "CREATE EXTENSION postgis")
        city, restored = store.url("city", "builder"), store.url("restored", "builder")
        output_of(cairn, "copy", map_path, city)
        possible = back_up(cairn, city, ["pg_dump", "--format=custom", "--schema=cairn", f"--file={dump}",
                                         store.url("city", "backup")])
        output_of("pg_restore", "--exit-on-error", "--dbname", restored, dump)
        output_of(cairn, "check", store.url("restored", "server"))
        version = version_of(cairn, restored)
        output_of(cairn, "rollback", restored, str(version - 1))  # It can be updated.
        expect(version in possible, "the dump has a version of its time")
    finally:
        store.close()
    print(f"database: version {version} was dumped while others were published, and restored")


def main():
    build = pathlib.Path(sys.argv[1])
    cairn = str(build / "cli" / "cairn")
    has_postgres = "--without-postgres" not in sys.argv and database.programs() is not None
    num_checked = 0
    with tempfile.TemporaryDirectory() as scratch:
        map_path = f"{scratch}/city.gpkg"
        output_of(str(build / "lab" / "cli" / "cairn-lab"), "simulate", "--size", "quick", "--area", "0.1",
                  "--num-queries", "1", "--map", map_path)
        for what, is_installed, check in (("sqlite3", shutil.which("sqlite3"), check_file),
                                          ("PostgreSQL", has_postgres, check_database)):
            if not is_installed:
                print(f"skipped: {what} is not installed (scripts/install-dependencies --tests)")
                continue
            check(cairn, map_path, scratch)
            num_checked += 1
    return 0 if num_checked > 0 else SKIPPED


if __name__ == "__main__":
    sys.exit(main())
