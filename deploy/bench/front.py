#!/usr/bin/env python3
"""Measures three `cairn serve` behind HAProxy with the shipped configuration, all on loopback.

  hit rate   each server caches half of the tiles that the queries need: the share of tiles that are
             found in memory, against the same front with round robin
  kill       kill -9 of one server while queries run: how many fail
  nginx      the same behind nginx
  outside    requests that strangers may send: the routes of operators, names of cells that are none
  drain      SIGTERM of one server while queries run: how many fail
  rolling    SIGTERM and a new start of each server in turn while queries run: how many fail
  overload   300 clients at once: how many of 3,000 queries are answered. The others get 503
  publish    `cairn rollback` publishes other content while queries run: answers that agree with no
             version as a whole, and the time until every server answers from the new version

The map is a simulated city; --work keeps it for the next run. With --store postgresql, the servers read
it from a throw-away PostgreSQL server. The exit code is 1 if a bar is missed, 77 if HAProxy or PostgreSQL
is not installed.

Example:
  deploy/bench/front.py --build build/release --work /tmp/front
"""

import argparse
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile

import cluster
import database
import queries

SKIPPED = 77
MIB = 1 << 20
DRAIN_SECONDS = 2
MAX_VISIBLE_SECONDS = 1.5
OVERLOAD_QUERIES = 3000
MIN_ANSWERED = 0.8  # Under overload.


def parse_arguments():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", required=True, type=pathlib.Path, help="build folder, as build/release")
    parser.add_argument("--work", type=pathlib.Path, help="folder of the map; default: a temporary one")
    parser.add_argument("--part", action="append", choices=PARTS, help="only this part; repeatable")
    parser.add_argument("--store", choices=["file", "postgresql"], default="file",
                        help="what the servers read the map from")
    parser.add_argument("--area", type=float, default=16.0, help="size of the city, square kilometers")
    parser.add_argument("--queries", type=int, default=2000, help="number of different queries")
    parser.add_argument("--publish-queries", type=int, default=10_000, help="queries while publishing")
    return parser.parse_args()


class Bench:
    """The programs, the map, its queries, and the rows of the table."""

    def __init__(self, arguments, work):
        self.arguments = arguments
        self.work = work
        self.cairn = str(arguments.build / "cli" / "cairn")
        self.map_path = str(work / "city.gpkg")
        self.list_path = work / "queries.json"
        self.rows = []
        self.database = None

    def make_map(self):
        self.work.mkdir(parents=True, exist_ok=True)
        if not self.list_path.exists():
            pathlib.Path(self.map_path).unlink(missing_ok=True)  # Of an interrupted run.
            subprocess.run(
                [str(self.arguments.build / "lab" / "cli" / "cairn-lab"), "simulate",
                 "--character", "suburb", "--size", "quick", "--area", str(self.arguments.area),
                 "--passes", "1", "--keyframe-spacing", "16", "--image-keypoints", "150",
                 "--num-queries", str(self.arguments.queries), "--keypoints", "200",
                 "--map", self.map_path, "--queries", str(self.list_path)],
                check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.requests = queries.load_requests(self.list_path)
        if self.arguments.store == "postgresql":
            self.database = database.Database()
            url = self.database.url("postgres")
            subprocess.run([self.cairn, "copy", self.map_path, url], check=True,
                           stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            self.map_path = url

    def close(self):
        if self.database is not None:
            self.database.close()

    def use_copy_of_map(self):
        """Updates go to a copy, so that the next run begins with the same map. A database is a copy."""
        if self.database is not None:
            return
        copy = self.work / "published.gpkg"
        for old in self.work.glob(copy.name + "*"):  # With the log of an earlier copy.
            old.unlink()
        self.map_path = str(shutil.copy(self.map_path, copy))

    def cluster(self, cache_mb=4096, front=cluster.haproxy, drain_s=0):
        return cluster.Cluster(self.cairn, self.map_path, cache_mb, front(), drain_s)

    def learn(self):
        """Asks one server everything once: learns the cells and the memory of all tiles."""
        server = cluster.Server(self.cairn, self.map_path, cache_mb=65_536)
        try:
            self.cells = queries.learn_cells(server.port, self.requests)
            self.ask_each(server.port)
            self.tile_bytes = server.metric("cairn_tile_cache_bytes")
            self.num_tiles = int(server.metric("cairn_tile_cache_entries"))
        finally:
            server.close()

    def stream(self, port, num_queries, seed=1):
        order = queries.at_random(len(self.requests), seed)
        return queries.Stream(port, self.requests, self.cells, order, num_queries).start()

    def ask_each(self, port):
        order = range(len(self.requests))
        return queries.Stream(port, self.requests, self.cells, order, len(order)).start().finish()

    def row_of_failures(self, what, outcomes):
        failed = [outcome for outcome in outcomes if outcome.status != 200]
        self.row(f"{what}: failed queries", f"{len(failed)} of {len(outcomes)}", "0", not failed)
        for outcome in failed[:3]:
            print(f"failed: status {outcome.status}, {outcome.body[:200]}", file=sys.stderr)

    def row(self, what, value, bar, is_met):
        self.rows.append((what, value, bar, is_met))
        print(f"| {what} | {value} | {bar} | {'yes' if is_met else 'NO'} |", flush=True)


def hit_rate(bench, front):
    with bench.cluster(int(bench.tile_bytes / 2 / MIB), front) as servers:
        num_queries = len(bench.requests)
        bench.stream(servers.front.port, num_queries, seed=2).finish()
        before = [servers.metric(f"cairn_tile_cache_{kind}_total") for kind in ("hits", "misses")]
        outcomes = bench.stream(servers.front.port, num_queries, seed=3).finish()
        hits, misses = [servers.metric(f"cairn_tile_cache_{kind}_total") - count
                        for kind, count in zip(("hits", "misses"), before)]
    if any(outcome.status != 200 for outcome in outcomes):
        raise RuntimeError("queries failed while nothing happened")
    return hits / (hits + misses)


def part_hit_rate(bench):
    shipped = hit_rate(bench, cluster.haproxy)
    bench.row("hit rate, shipped configuration", f"{shipped:.3f}", "0.94 or more", shipped >= 0.94)
    round_robin = hit_rate(bench, cluster.haproxy_round_robin)
    bench.row("hit rate, round robin", f"{round_robin:.3f}", "less", round_robin < shipped)


def kill(bench, front, name):
    with bench.cluster(front=front) as servers:
        stream = bench.stream(servers.front.port, 600)
        stream.wait_for(200)
        servers.servers[0].send(signal.SIGKILL)
        bench.row_of_failures(f"kill -9 of a server{name}", stream.finish())


def part_kill(bench):
    kill(bench, cluster.haproxy, "")


def part_nginx(bench):
    if shutil.which("nginx", path=cluster.PATH) is None:
        print("skipped: nginx is not installed (scripts/install-dependencies --tests)")
        return
    kill(bench, cluster.nginx, " behind nginx")


def part_outside(bench):
    paths = ["/metrics", "/healthz", "/livez", "/readyz", "/%6detrics", "//metrics", "/metrics?x",
             "/./metrics"]
    for name, front in FRONTS.items():
        if shutil.which(name, path=cluster.PATH) is None:
            print(f"skipped: {name} is not installed (scripts/install-dependencies --tests)")
            continue
        with bench.cluster(front=front) as servers:
            reached = [path for path in paths if cluster.get(servers.front.port, path)[0] == 200]
            strange = ["x" * 4000] * len(bench.cells)
            stream = queries.Stream(servers.front.port, bench.requests, strange, range(60), 60).start()
            answered = sum(outcome.status == 200 for outcome in stream.finish())
            num_used = sum(server.metric("cairn_localize_total") > 0 for server in servers.servers)
        bench.row(f"{name}: routes of operators that strangers reach", f"{reached}", "[]", not reached)
        bench.row(f"{name}: queries of no cell that are answered, servers that share them",
                  f"{answered} of 60, {num_used}", "60, 3", (answered, num_used) == (60, 3))


def part_drain(bench):
    with bench.cluster(drain_s=DRAIN_SECONDS) as servers:
        stream = bench.stream(servers.front.port, 600)
        stream.wait_for(200)
        leaving = servers.servers[0]
        leaving.send(signal.SIGTERM)
        took = cluster.wait_until(lambda: leaving.process.poll() is not None, "the end of the server")
        stream.wait_for(len(stream.outcomes) + 100)  # The others answer on.
        bench.row_of_failures("SIGTERM of a server", stream.finish())
        exit_code = leaving.wait()
    bench.row("its end", f"code {exit_code} after {took:.1f} s", f"code 0 after {DRAIN_SECONDS} s",
              exit_code == 0 and took >= DRAIN_SECONDS)


def part_rolling(bench):
    with bench.cluster(drain_s=DRAIN_SECONDS) as servers:
        stream = bench.stream(servers.front.port, 600)
        for server in servers.servers:
            server.send(signal.SIGTERM)
            server.wait()
            server.start()
            num_before = server.metric("cairn_localize_total")
            cluster.wait_until(lambda: server.metric("cairn_localize_total") > num_before,
                               "queries for the server that is back")
        bench.row_of_failures("restart of each server in turn", stream.finish())


class Crowd(queries.Stream):
    NUM_CLIENTS = 300


def part_overload(bench):
    with bench.cluster() as servers:
        order = queries.at_random(len(bench.requests), seed=4)
        outcomes = Crowd(servers.front.port, bench.requests, bench.cells, order, OVERLOAD_QUERIES).start().finish()
    num_answered, num_refused = (sum(outcome.status == status for outcome in outcomes) for status in (200, 503))
    bench.row("300 clients: answered queries, of the others with 503",
              f"{num_answered} of {len(outcomes)}, {num_refused} of {len(outcomes) - num_answered}", "80 %, all",
              num_answered >= MIN_ANSWERED * len(outcomes) and num_answered + num_refused == len(outcomes))


def reference_answers(bench, version):
    """The content of the answer to each query while the map has this version."""
    server = cluster.Server(bench.cairn, bench.map_path, cache_mb=65_536)
    try:
        outcomes = bench.ask_each(server.port)
    finally:
        server.close()
    if {queries.map_version(outcome) for outcome in outcomes} != {version}:
        raise RuntimeError(f"the map does not have version {version}")
    return {outcome.request_idx: queries.content(outcome) for outcome in outcomes}


def publish(bench, version):
    """Publishes the content of an earlier version as a new version, whose number it returns."""
    report = subprocess.run([bench.cairn, "rollback", bench.map_path, str(version)], check=True,
                            capture_output=True, text=True).stdout
    return int(re.search(r"is now version (\d+)", report)[1])


class Publications:
    """Versions of the map that hold all tiles or the first half of them, and the answers to both."""

    def __init__(self, bench):
        self.bench = bench
        self.name_of = {}  # Of the content of a version.
        self.answers = {}
        half = publish(bench, 2 + bench.num_tiles // 2)
        self.content = {"half": half, "whole": half - 1}
        for name in ("whole", "half"):
            self.answers[name] = reference_answers(bench, self.publish(name))

    def publish(self, name):
        version = publish(self.bench, self.content[name])
        self.name_of[version] = name
        return version

    def is_whole(self, outcome):
        """Whether the answer is that of the version that it names."""
        name = self.name_of[queries.map_version(outcome)]
        return queries.content(outcome) == self.answers[name][outcome.request_idx]

    def num_different(self):
        return sum(self.answers["half"][i] != answer for i, answer in self.answers["whole"].items())


def part_publish(bench):
    bench.use_copy_of_map()
    publications = Publications(bench)
    seconds = []
    with bench.cluster() as servers:
        stream = bench.stream(servers.front.port, bench.arguments.publish_queries)
        for name in ["whole", "half"] * 2:
            stream.wait_for(len(stream.outcomes) + bench.arguments.publish_queries // 6)
            version = publications.publish(name)
            seconds.append(cluster.wait_until(
                lambda: all(server.map_version() == version for server in servers.servers),
                "the new version"))
        stream.wait_for(len(stream.outcomes) + bench.arguments.publish_queries // 6)
        outcomes = stream.finish()
    bench.row_of_failures("publishing 4 versions", outcomes)
    answered = [outcome for outcome in outcomes if outcome.status == 200]
    mixed = sum(not publications.is_whole(outcome) for outcome in answered)
    num_seen = len({queries.map_version(outcome) for outcome in answered})
    bench.row(f"answers that mix versions; {publications.num_different()} of {len(bench.requests)} queries "
              "can tell", f"{mixed} of {len(answered)}, from {num_seen} versions", "0, from 5",
              mixed == 0 and num_seen == 5 and publications.num_different() > 0.1 * len(bench.requests))
    bench.row("until every server has the new version", f"{1e3 * max(seconds):.0f} ms",
              f"{1e3 * MAX_VISIBLE_SECONDS:.0f} ms", max(seconds) <= MAX_VISIBLE_SECONDS)


FRONTS = {"haproxy": cluster.haproxy, "nginx": cluster.nginx}
PARTS = {"hit_rate": part_hit_rate, "kill": part_kill, "nginx": part_nginx, "outside": part_outside,
         "drain": part_drain, "rolling": part_rolling, "overload": part_overload, "publish": part_publish}


def main():
    arguments = parse_arguments()
    if shutil.which("haproxy", path=cluster.PATH) is None:
        print("skipped: HAProxy is not installed (scripts/install-dependencies --tests)")
        return SKIPPED
    if arguments.store == "postgresql" and database.programs() is None:
        print("skipped: PostgreSQL is not installed (scripts/install-dependencies --tests)")
        return SKIPPED
    with tempfile.TemporaryDirectory() as scratch:
        bench = Bench(arguments, arguments.work or pathlib.Path(scratch))
        try:
            return run(bench)
        finally:
            bench.close()


def run(bench):
    bench.make_map()
    bench.learn()
    print(f"{bench.num_tiles} tiles of {bench.tile_bytes / MIB:.0f} MiB in memory, {len(bench.requests)} "
          f"queries of {len(set(bench.cells))} cells\n\n| | measured | bar | met |\n|---|---|---|---|")
    for name in bench.arguments.part or PARTS:
        PARTS[name](bench)
    return 0 if all(is_met for _, _, _, is_met in bench.rows) else 1


if __name__ == "__main__":
    sys.exit(main())
