#!/usr/bin/env python3
"""Times cold queries of four tiles with the map in a file and in PostgreSQL.

A `cairn serve` is started for each query, of the file and of the database in turn, and asked once. With --warm,
it is asked the same query 15 times more, and the median of these counts. The map is a dense simulated city;
--work keeps it for the next run. The exit code is 1 if the bar is missed, 77 if PostgreSQL is not installed.

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
NUM_WARM = 15
MAX_RATIO = {"cold": 1.4, "warm": 1.05}  # Of the whole query, database to file.


def parse_arguments():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", required=True, type=pathlib.Path, help="build folder, as build/release")
    parser.add_argument("--work", type=pathlib.Path, help="folder of the map; default: a temporary one")
    parser.add_argument("--area", type=float, default=0.06, help="size of the city, square kilometers")
    parser.add_argument("--rounds", type=int, default=15, help="servers of each")
    parser.add_argument("--warm", action="store_true", help="time the queries after the first one")
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


def ask(cairn, map_path, request, num_queries=1):
    """The stages of the answers of a server that was asked nothing before."""
    server = cluster.Server(cairn, map_path, cache_mb=4096)
    try:
        return [ask_once(server.port, request) for _ in range(num_queries)]
    finally:
        server.close()


def ask_once(port, request):
    connection = http.client.HTTPConnection(cluster.HOST, port, timeout=60)
    connection.request("POST", "/v1/localize", request.body,
                       {"Content-Type": f"multipart/form-data; boundary={queries.BOUNDARY}"})
    response = connection.getresponse()
    body = response.read()
    connection.close()
    if response.status != 200:
        raise RuntimeError(f"status {response.status}: {body[:200]}")
    return json.loads(body)["stages"]


def request_of_tiles(cairn, map_path, list_path):
    """A request that searches NUM_TILES tiles."""
    for request in queries.load_requests(list_path, include=["timings"]):
        if ask(cairn, map_path, request)[0]["tiles"]["searched"] == NUM_TILES:
            return request
    raise RuntimeError(f"no query of the city searches {NUM_TILES} tiles; try a larger --area")


def measure(arguments, cairn, paths, request):
    """[(ms of fetching and decoding, ms of the whole query)] for each path, one of each server."""
    times = {path: [] for path in paths}
    for _ in range(arguments.rounds):
        for path, measured in times.items():
            stages = ask(cairn, path, request, 1 + NUM_WARM if arguments.warm else 1)
            counted = stages[1:] if arguments.warm else stages
            measured.append((statistics.median(stage["tiles"]["ms"] for stage in counted),
                             statistics.median(stage["totalMs"] for stage in counted)))
    return times.values()


def run(arguments, folder):
    cairn = str(arguments.build / "cli" / "cairn")
    map_path, list_path = make_map(arguments, folder)
    store = database.Database()
    try:
        url = store.url("postgres")
        subprocess.run([cairn, "copy", map_path, url], check=True, stdout=subprocess.DEVNULL,
                       stderr=subprocess.DEVNULL)
        request = request_of_tiles(cairn, map_path, list_path)
        of_file, of_database = measure(arguments, cairn, [map_path, url], request)
    finally:
        store.close()
    kind = "warm" if arguments.warm else "cold"
    print(f"| {kind} query of four tiles, median | file | PostgreSQL | ratio |\n|---|---|---|---|")
    for name, column in (("stage `tiles`", 0), ("whole query", 1)):
        file_ms, database_ms = (statistics.median(row[column] for row in rows)
                                for rows in (of_file, of_database))
        ratio = database_ms / file_ms
        print(f"| {name} | {file_ms:.2f} ms | {database_ms:.2f} ms | {ratio:.2f} |")
    return 0 if ratio <= MAX_RATIO[kind] else 1


def main():
    arguments = parse_arguments()
    if database.programs() is None:
        print("skipped: PostgreSQL is not installed (scripts/install-dependencies --tests)")
        return SKIPPED
    with tempfile.TemporaryDirectory() as scratch:
        return run(arguments, arguments.work or pathlib.Path(scratch))


if __name__ == "__main__":
    sys.exit(main())
