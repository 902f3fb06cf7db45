#!/usr/bin/env python3
"""Disturbs `cairn` while it changes maps, as a user's machine may, and looks at what is left.

  kills      SIGKILL at moments that are spread evenly over each command
  full       the disk is full: a limit on the size of files, and, for root, a small tmpfs
  writers    three updates at once
  copies     copies of a map and its log while an update runs
  clients    twenty clients ask a server while the map changes
  database   kills of the builder of a PostgreSQL map

After each disturbance, a map is as before or as after the command, `cairn check` is clean, the command
succeeds when it is repeated and gives the same content, and there are no files but those of an undisturbed
run. An ingest that is repeated may number the content differently, because ids that a killed ingest reserved
are not given out again. Prints a table; the exit code is 1 if a line is not met.

Example:
  tests/deploy/check_faults.py build/release --kills 200
"""

import argparse
import contextlib
import os
import pathlib
import resource
import shutil
import signal
import sqlite3
import subprocess
import sys
import tempfile
import threading
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent.parent / "deploy" / "bench"))
import cluster
import database
import queries

CONFLICT = 4  # Exit codes, as `cairn --help` lists them.
IO_FAILURE = 6

VERSIONS = ("SELECT version, author, kind, session, summary, codebook_id, num_sessions, num_keyframes, num_tiles, "
            "num_landmarks, num_descriptors")
KEYFRAMES = ("SELECT image_name, tile_id, lat_deg, lon_deg, heading_deg FROM keyframes "
             "ORDER BY image_name, tile_id")
LANDMARKS = ("SELECT tile, x_m, y_m, z_m, sigma_m, num_descriptors, num_keyframes, num_sights, num_chances "
             "FROM cairn_landmarks ORDER BY 1, 2, 3, 4, 5, 6, 7, 8, 9")


def parse_arguments():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", type=pathlib.Path, help="build folder, as build/release")
    parser.add_argument("--kills", type=int, default=200, help="number of kills, over all commands")
    parser.add_argument("--part", action="append", choices=PARTS, help="only this part; repeatable")
    parser.add_argument("--case", action="append", choices=CASES, help="only this command; repeatable")
    return parser.parse_args()


def is_server(map_path):
    return "://" in str(map_path)


class Commands:
    """The `cairn` of a build, with a folder of its own for temporary files."""

    def __init__(self, build, scratch):
        self.cairn = str(build / "cli" / "cairn")
        self.lab = str(build / "lab" / "cli" / "cairn-lab")
        self.temporary = scratch / "tmp"
        self.temporary.mkdir()
        self.environment = dict(os.environ, TMPDIR=str(self.temporary), SQLITE_TMPDIR=str(self.temporary))

    def start(self, *arguments, **options):
        return subprocess.Popen([self.cairn, "--progress", "json", *map(str, arguments)], env=self.environment,
                                stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **options)

    def run(self, *arguments, **options):
        """(exit code, output, errors)"""
        process = self.start(*arguments, **options)
        out, errors = process.communicate()
        return process.returncode, out, errors

    def output_of(self, *arguments):
        code, out, errors = self.run(*arguments)
        if code != 0:
            raise RuntimeError(f"cairn {' '.join(map(str, arguments))}: exit code {code}\n{errors}")
        return out

    def state_of(self, map_path):
        """All versions and the digests of all payloads, without times; None if there is no map."""
        if self.is_missing(map_path):
            return None
        return (self.rows_of(map_path, VERSIONS + ", payload_bytes FROM cairn_versions ORDER BY version"),
                self.rows_of(map_path, "SELECT digest FROM cairn_payloads ORDER BY digest"))

    def content_of(self, map_path):
        """All versions and the content of the latest, without times and ids; None if there is no map."""
        if self.is_missing(map_path):
            return None
        landmarks = "" if is_server(map_path) else self.output_of("sql", map_path, "--format", "csv", LANDMARKS)
        return (self.rows_of(map_path, VERSIONS + " FROM cairn_versions ORDER BY version"),
                self.rows_of(map_path, KEYFRAMES), landmarks)

    def rows_of(self, map_path, sql):
        if is_server(map_path):
            return subprocess.run(["psql", "-qAt", str(map_path), "-c", sql], check=True, stdout=subprocess.PIPE, text=True,
                                  env=dict(os.environ, PGOPTIONS="-c search_path=cairn,public")).stdout
        with tempfile.TemporaryDirectory() as folder:  # A reader of the map itself would tidy up its log.
            for suffix in ("", "-wal"):
                if os.path.exists(f"{map_path}{suffix}"):
                    shutil.copy(f"{map_path}{suffix}", f"{folder}/map.gpkg{suffix}")
            with contextlib.closing(sqlite3.connect(f"{folder}/map.gpkg")) as database:
                return database.execute(sql).fetchall()

    @staticmethod
    def is_missing(map_path):
        return not is_server(map_path) and not pathlib.Path(map_path).exists()


CASES = ("ingest", "replace", "remove", "rollback", "prune", "compact", "rebuild", "merge", "recode", "extract")


class Case:
    """A command with the maps that it needs, and what they are before and after it."""

    def __init__(self, commands, name, folder, arguments, maps, is_repeatable=False):
        self.commands, self.name, self.folder, self.maps = commands, name, folder, maps
        self.arguments = arguments  # Of the command, from its working folder.
        self.is_repeatable = is_repeatable  # The command changes nothing if it has happened.
        work = self.prepare("undisturbed")
        self.before = self.states(work)
        begin = time.monotonic()
        commands.output_of(*self.arguments(work))
        self.seconds = time.monotonic() - begin
        self.after, self.content = self.states(work), self.contents(work)
        self.files = self.files_in(work)
        shutil.rmtree(work)

    def prepare(self, name):
        work = self.folder.parent / f"{self.name}-{name}"
        return pathlib.Path(shutil.copytree(self.folder, work))

    def states(self, work):
        return {name: self.commands.state_of(work / name) for name in self.maps}

    def contents(self, work):
        return {name: self.commands.content_of(work / name) for name in self.maps}

    @staticmethod
    def files_in(work):
        return sorted(str(file.relative_to(work)) for file in work.rglob("*") if file.is_file())

    def problems_of(self, work, ids_may_differ=False):
        """What is wrong with a folder after a disturbance; repeats the command if it has not happened."""
        problems = self.problems_of_maps(work, ids_may_differ)
        if self.is_repeatable or self.states(work) != self.after:
            code, _, errors = self.commands.run(*self.arguments(work))
            if code != 0:
                problems.append(f"the repeated command ends with {code}: {errors}")
        # An update that was killed after it was published leaves its log to the next writer.
        for name in self.maps:
            self.commands.run("prune", work / name, "--keep", "1000000")
            code, out, _ = self.commands.run("check", work / name)
            if code != 0:
                problems.append(f"cairn check {name} after the repeated command: exit code {code}: {out}")
        if self.states(work) != self.after and self.contents(work) != self.content:
            problems.append("the repeated command leaves something else")
        if self.files_in(work) != self.files:
            problems.append(f"files {self.files_in(work)} instead of {self.files}")
        if any(self.commands.temporary.iterdir()):
            problems.append(f"temporary files {list(self.commands.temporary.iterdir())}")
        return problems

    def problems_of_maps(self, work, ids_may_differ=False):
        """Maps that are not whole. Ids are in the digests; they differ if another command reserved some first."""
        problems = []
        for name, state in self.states(work).items():
            is_after = state == self.after[name] or (
                ids_may_differ and self.commands.content_of(work / name) == self.content[name])
            if state != self.before[name] and not is_after:
                problems.append(f"{name} is neither as before nor as after the command: {state}")
            if state is not None:
                code, out, _ = self.commands.run("check", work / name)
                if code != 0:
                    problems.append(f"cairn check {name}: exit code {code}: {out}")
        return problems


class Faults:
    """The maps of the commands, and the rows of the table."""

    def __init__(self, commands, scratch, num_kills, case_names):
        self.commands, self.scratch, self.num_kills = commands, scratch, num_kills
        self.is_met = True
        self.make_inputs()
        self.make_maps()
        self.cases = self.make_cases(case_names)

    def row(self, what, value, problems):
        self.is_met = self.is_met and not problems
        print(f"| {what} | {value} | {'yes' if not problems else 'NO'} |", flush=True)
        for problem in problems[:3]:
            print(f"  {what}: {problem}", file=sys.stderr, flush=True)

    def make_inputs(self):
        """A small city as COLMAP's files: its photos in two sessions. And queries."""
        self.colmap, self.list_path = self.scratch / "colmap", self.scratch / "queries.json"
        subprocess.run(
            [self.commands.lab, "simulate", "--character", "suburb", "--size", "quick", "--area", "0.03",
             "--passes", "1", "--keyframe-spacing", "8", "--image-keypoints", "150", "--num-queries", "20",
             "--keypoints", "200", "--map", self.scratch / "unused.gpkg", "--queries", self.list_path,
             "--colmap", self.colmap], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        names = [line.split(",")[0] for line in (self.colmap / "georef.csv").read_text().splitlines()[1:]]
        for session, first in (("even", 0), ("odd", 1)):
            (self.scratch / session).write_text("\n".join(names[first::2]) + "\n")

    def ingest(self, map_path, session, *options):
        return ["ingest", map_path, "--model", self.colmap / "sparse" / "0", "--database",
                self.colmap / "database.db", "--georef", self.colmap / "georef.csv", "--images",
                self.scratch / session, "--session", session, "--recorded", "2026-01-31T12:00:00Z", *options]

    def make_maps(self):
        """one: a session and an archive; two: both sessions and five versions; pruned: the last of these;
        both: a map of each session."""
        run = self.commands.output_of
        self.one, self.two, self.both = [self.scratch / name for name in ("one", "two", "both")]
        for folder in (self.one, self.both):
            (folder / "archive").mkdir(parents=True)
        one = self.one / "map.gpkg"
        run("init", one)
        run(*self.ingest(one, "even", "--archive", self.one / "archive"))
        shutil.copytree(self.one, self.two)
        two = self.two / "map.gpkg"
        run(*self.ingest(two, "odd"))
        shutil.copy(one, self.both / "even.gpkg")
        shutil.copy(two, self.both / "odd.gpkg")
        run("remove", self.both / "odd.gpkg", "even")
        for version in (2, 3):
            run("rollback", two, version)
        self.pruned = pathlib.Path(shutil.copytree(self.two, self.scratch / "pruned"))
        run("prune", self.pruned / "map.gpkg", "--keep", "1")

    def make_cases(self, names):
        ingest = lambda work: self.ingest(work / "map.gpkg", "odd", "--archive", work / "archive")
        replace = lambda work: [*ingest(work), "--max-descriptors", "100000"]
        recipes = {
            "ingest": (self.one, ingest, ["map.gpkg"]),
            "replace": (self.two, replace, ["map.gpkg"]),
            "remove": (self.two, lambda work: ["remove", work / "map.gpkg", "even"], ["map.gpkg"]),
            "rollback": (self.two, lambda work: ["rollback", work / "map.gpkg", 2], ["map.gpkg"]),
            "prune": (self.two, lambda work: ["prune", work / "map.gpkg", "--keep", 1], ["map.gpkg"]),
            "compact": (self.pruned, lambda work: ["compact", work / "map.gpkg"], ["map.gpkg"]),
            "rebuild": (self.one, lambda work: ["rebuild", work / "again.gpkg", "--archive", work / "archive"],
                        ["map.gpkg", "again.gpkg"]),
            "merge": (self.both, lambda work: ["merge", work / "even.gpkg", work / "odd.gpkg", "--out",
                                               work / "map.gpkg"], ["even.gpkg", "odd.gpkg", "map.gpkg"]),
            "recode": (self.two, lambda work: ["recode", work / "map.gpkg", "--codebook", "shipped"], ["map.gpkg"]),
            "extract": (self.two, lambda work: ["extract", work / "map.gpkg", "--bbox=-90,-180,90,180", "--out",
                                                work / "part.gpkg"], ["map.gpkg", "part.gpkg"])}
        return [Case(self.commands, name, *recipes[name], is_repeatable=name in ("ingest", "replace"))
                for name in names]


def kill_after(process, seconds):
    """True if the process was killed before it ended by itself."""
    try:
        process.wait(timeout=seconds)
    except subprocess.TimeoutExpired:
        process.send_signal(signal.SIGKILL)
    process.communicate()
    return process.returncode == -signal.SIGKILL


def part_kills(faults):
    for case, count in zip(faults.cases, shares(faults.num_kills, len(faults.cases))):
        problems, num_killed, num_published = [], 0, 0
        for seconds in moments(case.seconds, 4 * count):
            work = case.prepare("kill")
            num_killed += kill_after(faults.commands.start(*case.arguments(work)), seconds)
            num_published += case.states(work) == case.after
            problems += case.problems_of(work)
            shutil.rmtree(work)
            if num_killed == count:
                break
        if num_killed < count:
            problems.append(f"the command ended {4 * count - num_killed} times before it was killed")
        faults.row(f"{case.name}: kills over {1e3 * case.seconds:.0f} ms",
                   f"{num_killed} kills, {num_published} runs had published", problems)


def moments(seconds, count):
    """`count` moments between 0 and `seconds`; the first few are spread as evenly as all."""
    return [seconds * (0.5 + i * 0.6180339887) % seconds for i in range(count)]


def shares(total, count):
    """`total` in `count` parts of nearly one size."""
    return [(total + i) // count for i in range(count)]


def part_full(faults):
    for case in faults.cases:
        problems, num_failed = [], 0
        largest = max(file.stat().st_size for file in case.folder.rglob("*") if file.is_file())
        for share in (0.1, 0.5, 1.0, 1.02):
            work = case.prepare(f"full{share}")
            code, _, errors = faults.commands.run(
                *case.arguments(work), restore_signals=False,  # Python ignores SIGXFSZ.
                preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (int(share * largest),) * 2))
            num_failed += code != 0
            if code not in (0, IO_FAILURE):
                problems.append(f"exit code {code}: {errors}")
            problems += case.problems_of(work)
            shutil.rmtree(work)
        faults.row(f"{case.name}: files of limited size", f"{num_failed} of 4 refused", problems)
    part_small_disk(faults)


def part_small_disk(faults):
    mount = faults.scratch / "disk"
    mount.mkdir()
    for case in faults.cases:
        need = sum(file.stat().st_size for file in case.folder.rglob("*") if file.is_file())
        problems, num_failed = [], 0
        for extra in (0, 40_000, 200_000):
            if subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={need + extra + 65_536}", "tmpfs", mount],
                              check=False, stderr=subprocess.DEVNULL).returncode != 0:
                print("skipped: a small disk can only be mounted by root")
                return
            try:
                work = pathlib.Path(shutil.copytree(case.folder, mount / "work"))
                code, _, errors = faults.commands.run(*case.arguments(work))
                num_failed += code != 0
                if code not in (0, IO_FAILURE):
                    problems.append(f"exit code {code}: {errors}")
                problems += case.problems_of_maps(work)
                roomy = pathlib.Path(shutil.copytree(work, faults.scratch / "roomy"))
            finally:
                subprocess.run(["umount", mount], check=True)
            problems += case.problems_of(roomy)
            shutil.rmtree(roomy)
        faults.row(f"{case.name}: small disks", f"{num_failed} of 3 refused", problems)


def part_writers(faults):
    case = faults.make_cases(["ingest"])[0]
    codes, problems = [], []
    for i in range(max(4, faults.num_kills // 10)):
        work = case.prepare("writers")
        # Two of them want the same archive, or, without one, the same tiles.
        ingest = case.arguments(work) if i % 2 == 0 else faults.ingest(work / "map.gpkg", "odd")
        writers = [faults.commands.start(*command)
                   for command in (ingest, ingest, ["prune", work / "map.gpkg", "--keep", "1000000"])]
        errors = [writer.communicate()[1] for writer in writers]
        codes += [writer.returncode for writer in writers[:2]]
        problems += [f"exit code {writer.returncode}: {error}" for writer, error in zip(writers, errors)
                     if writer.returncode not in (0, CONFLICT)]
        if codes[-2:].count(0) == 0:
            problems.append(f"no update was published: {errors}")
        # Either of the two may reserve ids first, and either may publish.
        problems += case.problems_of(work, ids_may_differ=True)
        shutil.rmtree(work)
    if CONFLICT not in codes:
        problems.append("no second update met a conflict")
    faults.row("two ingests at once, and a prune", f"{codes.count(CONFLICT)} of {len(codes)} ingests refused", problems)


def part_copies(faults):
    count = max(2, faults.num_kills // 10)
    for case in faults.cases:
        problems = []
        for i in range(count):
            work = case.prepare(f"copy{i}")
            process = faults.commands.start(*case.arguments(work))
            try:
                process.wait(timeout=case.seconds * (i + 0.5) / count)
            except subprocess.TimeoutExpired:
                process.send_signal(signal.SIGSTOP)
            copy = work.with_name("copy")
            shutil.copytree(work, copy, ignore=shutil.ignore_patterns("*-shm"))
            process.send_signal(signal.SIGCONT)
            process.communicate()
            problems += case.problems_of_maps(copy)
            shutil.rmtree(copy)
            shutil.rmtree(work)
        faults.row(f"{case.name}: copies during the command", str(count), problems)


class Clients(queries.Stream):
    """Clients that ask one query after the other until they are told to finish."""

    NUM_CLIENTS = 20

    def __init__(self, port, requests):
        super().__init__(port, requests, queries.learn_cells(port, requests),
                         queries.at_random(len(requests), seed=1), 0)

    def wait(self):
        """Until each client has got a few more answers."""
        self.wait_for(len(self.outcomes) + 3 * self.NUM_CLIENTS)


def answers_of(faults, map_path, requests):
    server = cluster.Server(faults.commands.cairn, str(map_path), cache_mb=256)
    try:
        stream = queries.Stream(server.port, requests, queries.learn_cells(server.port, requests),
                                range(len(requests)), len(requests))
        return {outcome.request_idx: queries.content(outcome) for outcome in stream.start().finish()}
    finally:
        server.close()


def part_clients(faults):
    requests = queries.load_requests(faults.list_path)
    work = pathlib.Path(shutil.copytree(faults.one, faults.scratch / "served"))
    map_path = work / "map.gpkg"
    answers = {"even": answers_of(faults, map_path, requests),
               "both": answers_of(faults, faults.two / "map.gpkg", requests)}
    content_of = {2: "even"}
    server = cluster.Server(faults.commands.cairn, str(map_path), cache_mb=256)
    try:
        clients = Clients(server.port, requests).start()
        steps = [(faults.ingest(map_path, "odd"), "both"), (["rollback", map_path, 2], "even"),
                 (["rollback", map_path, 3], "both"), (["prune", map_path, "--keep", 2], "both"),
                 (["compact", map_path], "both")]
        for version, (arguments, content) in enumerate(steps, 3):
            content_of[version] = content  # The last step publishes no version.
            clients.wait()
            faults.commands.output_of(*arguments)
            clients.wait()
        outcomes = clients.finish()
    finally:
        server.close()
    failed = [outcome for outcome in outcomes if outcome.status != 200]
    mixed = [outcome for outcome in outcomes if outcome.status == 200 and
             queries.content(outcome) != answers[content_of[queries.map_version(outcome)]][outcome.request_idx]]
    num_different = sum(answers["even"][i] != answer for i, answer in answers["both"].items())
    problems = [f"status {outcome.status}: {outcome.body[:300]}" for outcome in failed]
    problems += [f"version {queries.map_version(outcome)} is mixed: {outcome.body[:300]}" for outcome in mixed]
    if num_different == 0:
        problems.append("no query tells the versions apart")
    num_versions = len({queries.map_version(outcome) for outcome in outcomes if outcome.status == 200})
    faults.row(f"{Clients.NUM_CLIENTS} clients while five commands run; {num_different} of {len(requests)} queries can "
               f"tell versions apart", f"{len(outcomes)} answers from {num_versions} versions", problems)


def part_database(faults):
    if database.programs() is None:
        print("skipped: PostgreSQL is not installed (scripts/install-dependencies --tests)")
        return
    store = database.Database()
    try:
        for name in ("ingest", "rollback", "prune"):
            kill_builders(faults, store, name)
    finally:
        store.close()


def kill_builders(faults, store, name):
    folder = faults.one if name == "ingest" else faults.two
    commands = {"ingest": lambda url: faults.ingest(url, "odd"), "rollback": lambda url: ["rollback", url, 2],
                "prune": lambda url: ["prune", url, "--keep", 1]}
    count = max(2, faults.num_kills // 15)
    urls = []
    for i in range(count + 1):
        urls.append(store.url(f"{name}{i}"))
        subprocess.run(["psql", "-q", store.url("postgres"), "-c", f"CREATE DATABASE {name}{i}"], check=True)
        faults.commands.output_of("copy", folder / "map.gpkg", urls[-1])
    before = faults.commands.state_of(urls[0])
    begin = time.monotonic()
    faults.commands.output_of(*commands[name](urls[0]))
    seconds = time.monotonic() - begin
    after, content = faults.commands.state_of(urls[0]), faults.commands.content_of(urls[0])
    problems, num_killed = [], 0
    for i, url in enumerate(urls[1:]):
        num_killed += kill_after(faults.commands.start(*commands[name](url)), seconds * (i + 0.5) / count)
        state = faults.commands.state_of(url)
        if state not in (before, after):
            problems.append(f"neither as before nor as after: {state}")
        if state != after:
            # The server notices the end of the connection after a moment, and keeps the lock until then.
            cluster.wait_until(lambda: faults.commands.run(*commands[name](url))[0] == 0, "a repeated command")
        if faults.commands.content_of(url) != content:
            problems.append("the repeated command leaves something else")
        faults.commands.output_of("check", url)
    faults.row(f"PostgreSQL, {name}: kills over {1e3 * seconds:.0f} ms", f"{num_killed} of {count}", problems)


PARTS = {"kills": part_kills, "full": part_full, "writers": part_writers, "copies": part_copies,
         "clients": part_clients, "database": part_database}


def main():
    arguments = parse_arguments()
    with tempfile.TemporaryDirectory() as folder:
        scratch = pathlib.Path(folder)
        faults = Faults(Commands(arguments.build, scratch), scratch, arguments.kills, arguments.case or CASES)
        print("| | measured | met |\n|---|---|---|", flush=True)
        for name in arguments.part or PARTS:
            PARTS[name](faults)
    return 0 if faults.is_met else 1


if __name__ == "__main__":
    sys.exit(main())
