#!/usr/bin/env python3
"""Asks a `cairn serve` while the PostgreSQL server of its map fails, all on one machine.

  kill         kill -9 of all processes of PostgreSQL, and a new start
  freeze       SIGSTOP of all its processes, and SIGCONT
  cut_silent   a proxy stops in the middle of a payload and says nothing more, as a firewall may
  cut_closed   the proxy closes all connections in the middle of a payload
  failover     kill -9 of the primary; the URL also names a standby, which is promoted at the end

A fault lasts for --seconds. Meanwhile, one client asks for places whose tiles the server has in memory, and one
for other places, with a deadline of 1 s. The bars: the first client gets the answers of before, and those are
marked as stale from 2.5 s after the fault on; the second one gets 503 with Retry-After within the deadline
+ 50 ms; 2 s after the end of the fault, both get fresh answers. With a standby, both get fresh answers 2 s
after the fault. The exit code is 1 if a bar is missed, 77 if PostgreSQL is not installed.

The map is a simulated city; --work keeps it for the next run.

Example:
  deploy/bench/store_faults.py --build build/release --work /tmp/faults
"""

import argparse
import http.client
import json
import pathlib
import re
import subprocess
import sys
import tempfile
import threading
import time
import typing

import cluster
import database
import proxy
import queries

SKIPPED = 77
CENTER = "47.38,8.54,408"  # Far from the border of a UTM zone, where the server keeps no records of tiles.
DEADLINE_S = 1.0
PAUSE_S = 0.05  # Between the queries of a client.
MAX_EXCESS_S = 0.05
MAX_UNMARKED_S = 2.5
MAX_RECOVERY_S = 2.0
MAX_VISIBLE_S = 1.5


def parse_arguments():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", required=True, type=pathlib.Path, help="build folder, as build/release")
    parser.add_argument("--work", type=pathlib.Path, help="folder of the map; default: a temporary one")
    parser.add_argument("--fault", action="append", choices=FAULTS, help="only this fault; repeatable")
    parser.add_argument("--seconds", type=float, default=10, help="how long a fault lasts")
    parser.add_argument("--slack", type=float, default=0,
                        help="seconds that a busy machine may take longer; the statuses count nevertheless")
    parser.add_argument("--area", type=float, default=2.0, help="size of the city, square kilometers")
    return parser.parse_args()


class Kill:
    has_standby = False

    def __init__(self, store):
        self.store = store
        self.url = store.url("postgres")

    def begin(self):
        self.store.kill()

    def end(self):
        self.store.start()

    def close(self):
        pass


class Freeze(Kill):
    def begin(self):
        self.store.freeze()

    def end(self):
        self.store.thaw()


class Cut(Kill):
    is_silent = False

    def __init__(self, store):
        super().__init__(store)
        self.proxy = proxy.Proxy(store.folder, self.is_silent)
        self.url = self.url.replace(store.folder, self.proxy.folder)

    def begin(self):
        self.proxy.arm()

    def end(self):
        if not self.proxy.is_cut:
            raise RuntimeError("no payload came through the proxy")
        self.proxy.mend()

    def close(self):
        self.proxy.close()


class SilentCut(Cut):
    is_silent = True


class Failover(Kill):
    has_standby = True

    def __init__(self, store):
        super().__init__(store)
        self.standby = database.Database(primary=store)
        self.url = self.url.replace(store.folder, f"{store.folder},{self.standby.folder}")

    def end(self):
        self.standby.promote()

    def close(self):
        self.standby.close()


FAULTS = {"kill": Kill, "freeze": Freeze, "cut_silent": SilentCut, "cut_closed": Cut, "failover": Failover}


class Answer(typing.NamedTuple):
    begin: float  # Of the query; time.monotonic().
    end: float
    request_idx: int
    status: int
    retry_after: str
    body: bytes

    def is_stale(self):
        return self.status == 200 and "stale" in json.loads(self.body)["map"]

    def is_fresh(self):
        return self.status == 200 and not self.is_stale()

    def content(self):
        return queries.content(self) if self.status == 200 else self.body


def ask(port, request_idx, request):
    connection = http.client.HTTPConnection(cluster.HOST, port, timeout=90)
    begin = time.monotonic()
    connection.request("POST", "/v1/localize", request.body,
                       {"Content-Type": f"multipart/form-data; boundary={queries.BOUNDARY}"})
    response = connection.getresponse()
    body = response.read()
    end = time.monotonic()
    connection.close()
    return Answer(begin, end, request_idx, response.status, response.headers.get("Retry-After"), body)


class Client(threading.Thread):
    """Asks queries in turn until it is told to stop."""

    def __init__(self, port, requests):
        super().__init__()
        self.port, self.requests = port, requests
        self.answers = []
        self.is_stopping = False

    def run(self):
        while not self.is_stopping:
            request_idx = len(self.answers) % len(self.requests)
            self.answers.append(ask(self.port, request_idx, self.requests[request_idx]))
            time.sleep(PAUSE_S)

    def stop(self):
        self.is_stopping = True
        self.join()


class Bench:
    """The map, queries of places that the server will know, and queries of others."""

    def __init__(self, arguments, work):
        self.arguments = arguments
        self.cairn = str(arguments.build / "cli" / "cairn")
        self.map_path, self.list_path = str(work / "city.gpkg"), work / "queries.json"
        self.is_met = True
        work.mkdir(parents=True, exist_ok=True)
        if not self.list_path.exists():
            pathlib.Path(self.map_path).unlink(missing_ok=True)  # Of an interrupted run.
            self.run(str(arguments.build / "lab" / "cli" / "cairn-lab"), "simulate",
                     "--character", "suburb", "--center", CENTER, "--size", "quick",
                     "--area", str(arguments.area), "--passes", "1",
                     "--keyframe-spacing", "16", "--image-keypoints", "150", "--num-queries", "120",
                     "--keypoints", "200", "--map", self.map_path, "--queries", str(self.list_path))
        self.choose_queries()

    @staticmethod
    def run(*command):
        return subprocess.run(command, check=True, capture_output=True, text=True).stdout

    def choose_queries(self):
        """The western third of the city is known. The others have no tile in common with it."""
        patient = queries.load_requests(self.list_path)
        urgent = queries.load_requests(self.list_path, timeout_ms=int(1e3 * DEADLINE_S))
        server = cluster.Server(self.cairn, self.map_path, cache_mb=64)
        try:
            tiles, cells = zip(*(self.places(server, request) for request in patient))
        finally:
            server.close()
        order = sorted(range(len(patient)), key=lambda i: patient[i].lon)
        west, east = order[:len(order) // 3], order[len(order) // 3:]
        known_tiles = set().union(*(tiles[i] for i in west))
        # From the east on, where the cells are unknown, too.
        east = [i for i in reversed(east) if not known_tiles & tiles[i]]
        self.known, self.other = [patient[i] for i in west], [urgent[i] for i in east]
        print(f"{len(west)} queries of {len({cells[i] for i in west})} cells are known, {len(east)} of "
              f"{len({cells[i] for i in east})} cells are not\n\n| | measured | bar | met |\n|---|---|---|---|")

    @staticmethod
    def places(server, request):
        """The names of the tiles and the cell of a query."""
        status, body = cluster.get(server.port, f"/v1/availability?lat={request.lat}&lon={request.lon}&accuracy=30")
        if status != 200:
            raise RuntimeError(f"/v1/availability: {status} {body}")
        answer = json.loads(body)
        return set(answer["tiles"]), answer["cell"]

    def row(self, what, value, bar, is_met):
        self.is_met = self.is_met and bool(is_met)
        print(f"| {what} | {value} | {bar} | {'yes' if is_met else 'NO'} |", flush=True)


def time_until(answers, since, is_wished):
    """Seconds from `since` until all answers are as wished; None if the last one is not."""
    end = None
    for answer in reversed(answers):
        if not is_wished(answer):
            break
        end = answer.end
    return None if end is None else max(0.0, end - since)


class Trial:
    """One fault under the eyes of two clients."""

    def __init__(self, bench, name, fault):
        self.bench, self.name, self.fault = bench, name, fault
        # The log has a line for each refusal.
        self.server = cluster.Server(bench.cairn, fault.url, cache_mb=4096, log=subprocess.DEVNULL)

    def run(self):
        try:
            self.before = [ask(self.server.port, i, request).content()
                           for i, request in enumerate(self.bench.known)]
            self.known, self.other = (Client(self.server.port, requests)
                                      for requests in (self.bench.known, self.bench.other))
            self.disturb()
            self.report()
            if self.fault.has_standby:
                self.publish()
        finally:
            self.server.close()

    def disturb(self):
        self.fault.begin()
        self.fault_time = time.monotonic()
        self.known.start()
        self.other.start()
        try:
            time.sleep(self.bench.arguments.seconds)
            self.end_time = time.monotonic()
            self.fault.end()
            self.mended_time = time.monotonic()
            self.wait_for_fresh_answers()
        finally:
            self.known.stop()
            self.other.stop()

    def wait_for_fresh_answers(self):
        deadline = self.mended_time + MAX_RECOVERY_S + DEADLINE_S + self.bench.arguments.slack
        while time.monotonic() < deadline and not all(
                client.answers[-1].begin > self.mended_time and client.answers[-1].is_fresh()
                for client in (self.known, self.other)):
            time.sleep(PAUSE_S)

    def report(self):
        known, other = ([answer for answer in client.answers if answer.end < self.end_time]
                        for client in (self.known, self.other))
        changed = [answer for answer in known if answer.content() != self.before[answer.request_idx]]
        self.row("known places, answered as before", f"{len(known) - len(changed)} of {len(known)}", "all",
                 known and not changed)
        self.report_refusals(other)
        self.print_some(changed + [answer for answer in other if answer.status not in (200, 503)])
        if self.fault.has_standby:
            self.report_fresh("after the fault", self.fault_time)
        else:
            self.row_of_time("known places, until answers are marked stale",
                             time_until(known, self.fault_time, Answer.is_stale), MAX_UNMARKED_S)
            self.report_fresh("after its end", self.mended_time)

    def report_refusals(self, answers):
        refused = [answer for answer in answers if answer.status == 503 and answer.retry_after]
        num_right = len(refused)
        if self.fault.has_standby:
            num_right += sum(answer.status == 200 for answer in answers)
        self.row("other places, 503 with Retry-After", f"{len(refused)} of {len(answers)}",
                 "the others are answered" if self.fault.has_standby else "all",
                 answers and num_right == len(answers))
        self.row_of_time("other places, longest refusal",
                         max((answer.end - answer.begin for answer in refused), default=0.0),
                         DEADLINE_S + MAX_EXCESS_S)

    def report_fresh(self, when, since):
        for what, client in (("known", self.known), ("other", self.other)):
            answers = [answer for answer in client.answers if answer.end > since]
            self.row_of_time(f"{what} places, fresh answers {when}", time_until(answers, since, Answer.is_fresh),
                             MAX_RECOVERY_S)

    def print_some(self, wrong):
        for answer in wrong[:3]:
            print(f"{answer.begin - self.fault_time:.3f} s after the fault, status {answer.status}: {answer.body[:300]}",
                  file=sys.stderr)

    def publish(self):
        """The server sees a version that is published at the standby of before."""
        head = self.server.map_version()
        report = self.bench.run(self.bench.cairn, "rollback", self.fault.url, str(head - 1))
        begin = time.monotonic()
        version = int(re.search(r"is now version (\d+)", report)[1])
        cluster.wait_until(lambda: self.server.map_version() == version, "the new version")
        self.row_of_time("a version published at the new primary is served", time.monotonic() - begin,
                         MAX_VISIBLE_S)

    def row(self, what, *value_and_bar):
        self.bench.row(f"{self.name}: {what}", *value_and_bar)

    def row_of_time(self, what, seconds, bar_s):
        value = "never" if seconds is None else f"{seconds:.3f} s"
        is_met = seconds is not None and seconds <= bar_s + self.bench.arguments.slack
        self.row(what, value, f"{bar_s:g} s", is_met)


def run(bench):
    for name in bench.arguments.fault or FAULTS:
        store = database.Database()
        try:
            bench.run(bench.cairn, "copy", bench.map_path, store.url("postgres"))
            fault = FAULTS[name](store)
            try:
                Trial(bench, name, fault).run()
            finally:
                fault.close()
        finally:
            store.close()
    return 0 if bench.is_met else 1


def main():
    arguments = parse_arguments()
    if database.programs() is None:
        print("skipped: PostgreSQL is not installed (scripts/install-dependencies --tests)")
        return SKIPPED
    with tempfile.TemporaryDirectory() as scratch:
        return run(Bench(arguments, arguments.work or pathlib.Path(scratch)))


if __name__ == "__main__":
    sys.exit(main())
