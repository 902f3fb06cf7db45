#!/usr/bin/env python3
"""Times cold queries of four tiles with the map in a file and in PostgreSQL.

A `cairn serve` is started for each query, of the file and of the database in turn, and asked once. The
map is a dense simulated city; --work keeps it for the next run. The exit code is 1 if the bar is missed, 77 if
PostgreSQL is not installed.

Example:
  deploy/bench/cold.py --build build/release --work /tmp/cold
"""

import argparse
import http.client
import json
import pathlib
import statistics
import subprocess
import sys
import tempfile

import cluster
import database
import queries

SKIPPED = 77
NUM_TILES = 4
MAX_RATIO = 1.4  # Of the whole query, database to file.


def parse_arguments():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", required=True, type=pathlib.Path, help="build folder, as build/release")
    parser.add_argument("--work", type=pathlib.Path, help="folder of the map; default: a temporary one")
    parser.add_argument("--area", type=float, default=0.06, help="size of the city, square kilometers")
    parser.add_argument("--rounds", type=int, default=15, help="cold queries of each")
    return parser.parse_args()


def make_map(arguments, folder):
    """The paths of the map and of its query list."""
    map_path, list_path = folder / "city.gpkg", folder / "queries.json"
    folder.mkdir(parents=True, exist_ok=True)
    if not list_path.exists():
        map_path.unlink(missing_ok=True)  # Of an interrupted run.
        subprocess.run(
            [str(arguments.build / "lab" / "cli" / "cairn-lab"), "simulate", "--character", "old-town",
             "--size", "medium", "--area", str(arguments.area), "--num-queries", "40",
             "--map", str(map_path), "--queries", str(list_path)],
            check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return str(map_path), list_path


def ask(cairn, map_path, request):
    """The stages of the answer of a server that was asked nothing before."""
    server = cluster.Server(cairn, map_path, cache_mb=4096)
    try:
        connection = http.client.HTTPConnection(cluster.HOST, server.port, timeout=60)
        connection.request("POST", "/v1/localize", request.body,
                           {"Content-Type": f"multipart/form-data; boundary={queries.BOUNDARY}"})
        response = connection.getresponse()
        body = response.read()
        if response.status != 200:
            raise RuntimeError(f"status {response.status}: {body[:200]}")
        return json.loads(body)["stages"]
    finally:
        server.close()


def request_of_tiles(cairn, map_path, list_path):
    """A request that searches NUM_TILES tiles."""
    for request in queries.load_requests(list_path, include=["timings"]):
        if ask(cairn, map_path, request)["tiles"]["searched"] == NUM_TILES:
            return request
    raise RuntimeError(f"no query of the city searches {NUM_TILES} tiles; try a larger --area")


def measure(cairn, file_path, url, list_path, num_rounds):
    """[(ms of fetching and decoding, ms of the whole query)] for each of file and database."""
    request = request_of_tiles(cairn, file_path, list_path)
    times = {file_path: [], url: []}
    for _ in range(num_rounds):
        for path, measured in times.items():
            stages = ask(cairn, path, request)
            measured.append((stages["tiles"]["ms"], stages["totalMs"]))
    return times[file_path], times[url]


def run(arguments, folder):
    cairn = str(arguments.build / "cli" / "cairn")
    map_path, list_path = make_map(arguments, folder)
    store = database.Database()
    try:
        url = store.url("postgres")
        subprocess.run([cairn, "copy", map_path, url], check=True, stdout=subprocess.DEVNULL,
                       stderr=subprocess.DEVNULL)
        of_file, of_database = measure(cairn, map_path, url, list_path, arguments.rounds)
    finally:
        store.close()
    print("| cold query of four tiles, median | file | PostgreSQL | ratio |\n|---|---|---|---|")
    for name, column in (("stage `tiles`", 0), ("whole query", 1)):
        file_ms, database_ms = (statistics.median(row[column] for row in rows)
                                for rows in (of_file, of_database))
        ratio = database_ms / file_ms
        print(f"| {name} | {file_ms:.1f} ms | {database_ms:.1f} ms | {ratio:.2f} |")
    return 0 if ratio <= MAX_RATIO else 1


def main():
    arguments = parse_arguments()
    if database.programs() is None:
        print("skipped: PostgreSQL is not installed (scripts/install-dependencies --tests)")
        return SKIPPED
    with tempfile.TemporaryDirectory() as scratch:
        return run(arguments, arguments.work or pathlib.Path(scratch))


if __name__ == "__main__":
    sys.exit(main())
