#!/usr/bin/env python3
"""Lets attackers loose on a server with API keys, all at once, while honest clients ask it.

    deploy/bench/soak.py --cairn build/release/cli/cairn --map city.gpkg [--queries queries.json] [--seconds 600]

Starts `cairn serve --api-keys` on loopback. Eight honest clients with a key each send a query a second and wait for the
answer: the photos of a query list (docs/formats/query_list_v1.md; `cairn demo` writes one), or noise. Each attack runs
twice: without a key, and with the key of an attacker who may localize and look and has no rate. Attackers come from
127.0.0.2 and further addresses. A hostile server meets `cairn localize --server` now and then.

Prints a table, and fails unless every attack reached the server, all honest queries were answered, and the memory of the
server stayed within 64 MB of what it was before the attacks.
"""

import argparse
import http.client
import json
import pathlib
import random
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time
import zlib

from floods import gray_png, memory_mb

NUM_HONEST = 8
HONEST_TIMEOUT_MS = 10_000
HONEST_PAUSE_S = 1.0
MAX_GROWTH_MB = 64
QUIET_S = 5.0  # Before the attacks.
SETTLE_S = 75.0  # After them, until memory is measured: the last photos have 60 s, broken uploads 15 s.
BOUNDARY = "cairn-soak-boundary"


# --- Requests --------------------------------------------------------------------------------------

def multipart(request, photo):
    def part(name, content):
        return f'--{BOUNDARY}\r\nContent-Disposition: form-data; name="{name}"\r\n\r\n'.encode() + content + b"\r\n"

    return part("request", json.dumps(request).encode()) + part("image", photo) + f"--{BOUNDARY}--\r\n".encode()


def post(body, key, length=None):
    authorization = f"Authorization: Bearer {key}\r\n" if key else ""
    return (f"POST /v1/localize HTTP/1.1\r\nHost: h\r\n{authorization}Content-Type: multipart/form-data; "
            f"boundary={BOUNDARY}\r\nContent-Length: {length or len(body)}\r\n\r\n").encode() + body


def get(path, key):
    authorization = f"Authorization: Bearer {key}\r\n" if key else ""
    return f"GET {path} HTTP/1.1\r\nHost: h\r\n{authorization}Connection: close\r\n\r\n".encode()


def query(photo, width, height, timeout_ms):
    camera = {"model": "SIMPLE_PINHOLE", "size": [width, height], "modelParams": [width, width / 2, height / 2]}
    return multipart({"camera": camera, "options": {"timeoutMs": timeout_ms}}, photo)


def honest_bodies(list_path):
    if list_path is None:
        noise = random.Random(1)
        photo = gray_png(320, 240, lambda _: noise.randbytes(320))
        return [query(photo, 320, 240, HONEST_TIMEOUT_MS)]
    folder = pathlib.Path(list_path).parent
    bodies = []
    for entry in json.loads(pathlib.Path(list_path).read_text())["queries"]:
        fields = {name: entry[name] for name in ("camera", "prior", "gravity") if name in entry}
        fields["options"] = {"timeoutMs": HONEST_TIMEOUT_MS, "maxMatches": 1}
        bodies.append(multipart(fields, (folder / entry["image"]).read_bytes()))
    return bodies


def exif_that_overlaps(num_bytes, entries=250, num_folders=9):
    """A TIFF structure in which all entries of all directories point to the same bytes."""
    names = ["0", "1", "exif", "gps", "iop"] + [f"sub{i}" for i in range(num_folders)]
    offsets, at = {}, 8
    for name in names:
        offsets[name] = at
        at += 2 + 12 * (entries + 6) + 4
    list_at, at = at, at + 4 * num_folders
    tiff = bytearray(b"II*\0" + struct.pack("<I", 8)) + b"\0" * (at - 8)
    for name in names:
        first_tag = 0x40 if name in ("gps", "iop") else 0xa500
        rows = [(first_tag + i, 1, num_bytes - at, at) for i in range(entries)]
        if name == "0":
            rows += [(0x8769, 4, 1, offsets["exif"]), (0x8825, 4, 1, offsets["gps"]), (0x014a, 4, num_folders, list_at)]
        if name == "exif":
            rows.append((0xa005, 4, 1, offsets["iop"]))
        struct.pack_into("<H", tiff, offsets[name], len(rows))
        for i, row in enumerate(sorted(rows)):
            struct.pack_into("<HHII", tiff, offsets[name] + 2 + 12 * i, *row)
        struct.pack_into("<I", tiff, offsets[name] + 2 + 12 * len(rows), offsets["1"] if name == "0" else 0)
    for i in range(num_folders):
        struct.pack_into("<I", tiff, list_at + 4 * i, offsets[f"sub{i}"])
    return bytes(tiff) + b" " * (num_bytes - len(tiff))


def png_with_exif(num_bytes):
    png = gray_png(64, 48, lambda _: bytes(64))
    block = b"eXIf" + exif_that_overlaps(num_bytes)
    after_head = 8 + 25  # The signature and IHDR.
    return (png[:after_head] + struct.pack(">I", len(block) - 4) + block + struct.pack(">I", zlib.crc32(block)) +
            png[after_head:])


# --- Attacks ---------------------------------------------------------------------------------------

class Attacker:
    """Repeats `step(connect, key)` in threads. A step that fails is repeated. Counts the steps that reached the server."""

    def __init__(self, name, step, num_threads, pause_s=0.0):
        self.name, self.step, self.num_threads, self.pause_s = name, step, num_threads, pause_s
        self.num_steps = 0
        self.lock = threading.Lock()

    def start(self, port, address, key, end):
        def run():
            num_connections = 0

            def connect():
                nonlocal num_connections
                connection = socket.create_connection(("127.0.0.1", port), source_address=(address, 0), timeout=30)
                num_connections += 1
                return connection

            while time.monotonic() < end:
                num_connections = 0
                try:
                    self.step(connect, key)
                except OSError:
                    time.sleep(0.05)
                if num_connections > 0:
                    with self.lock:
                        self.num_steps += 1
                time.sleep(self.pause_s)

        for _ in range(self.num_threads):
            threading.Thread(target=run, daemon=True).start()


def exchange(connection, bytes_):
    """Sends and reads the answer, or what there is of it."""
    connection.sendall(bytes_)
    response = http.client.HTTPResponse(connection)
    try:
        response.begin()
        response.read()
    except http.client.HTTPException:
        pass


def asking(make_bytes):
    def step(connect, key):
        with connect() as connection:
            exchange(connection, make_bytes(key))
    return step


def send_blank_lines(connect, _):
    with connect() as connection:
        for _ in range(20):
            connection.sendall(b"\r\n" * (1 << 17))


def trickle(head_of):
    def step(connect, key):
        with connect() as connection:
            connection.sendall(head_of(key))
            for _ in range(2000):
                connection.sendall(b"x")
                time.sleep(0.01)
    return step


def break_off(connect, key):
    """Half of an upload of 30 MB, then nothing until the server has had enough."""
    with connect() as connection:
        connection.sendall(post(b"x" * 1_000_000, key, length=30_000_000))
        while connection.recv(65536):
            pass


def read_nothing(connect, key):
    """Asks for much and does not read the answers."""
    with connect() as connection:
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        connection.sendall(get("/v1/tiles", key).replace(b"Connection: close\r\n", b"") * 200)
        time.sleep(5.0)


def hold_connections(connect, _):
    connections = [connect() for _ in range(100)]
    time.sleep(2.0)
    for connection in connections:
        connection.close()


def attacks():
    zeros = query(gray_png(4000, 3000, lambda _: bytes(4000)), 4000, 3000, 60_000)
    overlapping = query(png_with_exif(1 << 19), 64, 48, 2000)
    guess = random.Random(2)
    return [
        Attacker("photos of 12 kB and 12 megapixels, timeoutMs 60,000", asking(lambda key: post(zeros, key)), 12),
        Attacker("EXIF with entries that overlap", asking(lambda key: post(overlapping, key)), 4),
        Attacker("all tiles of the world, limit=1",
                 asking(lambda key: get("/v1/coverage?bbox=-180,-90,180,90&limit=1", key)), 4, 0.01),
        Attacker("blank lines", send_blank_lines, 2, 0.05),
        Attacker("bodies a byte at a time",
                 trickle(lambda key: post(b"", key, length=1_000_000)), 8),
        Attacker("heads a byte at a time", trickle(lambda _: b"GET / HTTP/1.1\r\nX: "), 8),
        Attacker("uploads that break off", break_off, 4),
        Attacker("answers that nobody reads", read_nothing, 4),
        Attacker("100 connections that say nothing", hold_connections, 2),
        Attacker("guessed keys", asking(lambda _: get("/v1/tiles", f"cairn_{guess.getrandbits(256):x}")), 2, 0.01),
        Attacker("no HTTP", asking(lambda _: guess.randbytes(2000) + b"\r\n\r\n"), 2, 0.01),
    ]


class HostileServer:
    """Answers with a status line of a megabyte."""

    def __init__(self):
        self.listening = socket.create_server(("127.0.0.1", 0))
        self.port = self.listening.getsockname()[1]
        threading.Thread(target=self.run, daemon=True).start()

    def run(self):
        while True:
            connection, _ = self.listening.accept()
            with connection:
                try:
                    connection.recv(65536)
                    connection.sendall(b"HTTP/1.1 200 " + b"b" * 1_000_000 + b"\r\n\r\n")
                except OSError:
                    pass


# --- Honest clients --------------------------------------------------------------------------------

class Honest(threading.Thread):
    def __init__(self, port, key, bodies, end):
        super().__init__(daemon=True)
        self.port, self.key, self.bodies, self.end = port, key, bodies, end
        self.answers, self.seconds = {}, []

    def run(self):
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=60)
        headers = {"Content-Type": f"multipart/form-data; boundary={BOUNDARY}", "Authorization": f"Bearer {self.key}"}
        order = random.Random(self.key)
        while time.monotonic() < self.end:
            begin = time.monotonic()
            try:
                connection.request("POST", "/v1/localize", order.choice(self.bodies), headers)
                response = connection.getresponse()
                answer = json.loads(response.read())
                word = answer.get("reason") or answer.get("status") if response.status == 200 else answer.get("code")
                name = f"{response.status} {word}"
            except (OSError, http.client.HTTPException) as error:
                connection.close()
                name = f"no answer: {type(error).__name__}"
            self.answers[name] = self.answers.get(name, 0) + 1
            self.seconds.append(time.monotonic() - begin)
            time.sleep(max(0.0, HONEST_PAUSE_S - self.seconds[-1]))


def is_answered(name):
    return name.startswith("200") and name != "200 TIMEOUT"


def run_honest(port, keys, bodies, seconds):
    clients = [Honest(port, key, bodies, time.monotonic() + seconds) for key in keys]
    for client in clients:
        client.start()
    return clients


def summary_of(clients):
    """Answers by name, and the sorted times."""
    answers = {}
    for client in clients:
        client.join()
        for name, count in client.answers.items():
            answers[name] = answers.get(name, 0) + count
    return answers, sorted(second for client in clients for second in client.seconds)


def watch_memory(pid, seconds, seen):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        seen.append(memory_mb(pid))
        time.sleep(0.5)


def visit_hostile_server(cairn, folder, end, outcomes):
    photo = pathlib.Path(folder) / "photo.png"
    photo.write_bytes(gray_png(64, 48, lambda _: bytes(64)))
    server = HostileServer()
    while time.monotonic() < end:
        finished = subprocess.run([cairn, "localize", "--image", photo, "--server", f"http://127.0.0.1:{server.port}"],
                                  capture_output=True, check=False)
        outcomes.append(finished.returncode)
        time.sleep(10.0)


def new_key(cairn, path, label, may):
    return subprocess.run([cairn, "keys", "new", path, "--label", label, "--may", may], capture_output=True, text=True,
                          check=True).stdout.strip()


def line(name, answers, times):
    answered = sum(count for answer, count in answers.items() if is_answered(answer))
    words = ", ".join(f"{count} x {answer}" for answer, count in sorted(answers.items()))
    print(f"| {name} | {len(times)} | {answered} | {times[len(times) // 2]:.2f} | {times[-1]:.2f} | {words} |", flush=True)
    return answered


def soak(arguments, folder):
    cairn, keys_path = arguments.cairn, str(pathlib.Path(folder) / "keys.json")
    honest_keys = [new_key(cairn, keys_path, f"honest-{i}", "localize") for i in range(NUM_HONEST)]
    attacker_key = new_key(cairn, keys_path, "attacker", "localize,look")
    bodies = honest_bodies(arguments.queries)
    server = subprocess.Popen([cairn, "serve", arguments.map, "--port", "0", "--api-keys", keys_path],
                              stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    try:
        port = int(server.stdout.readline().rsplit(":", 1)[1])
        print("| | honest queries | answered | median, s | longest, s | answers |\n|---|---|---|---|---|---|")
        line("alone", *summary_of(run_honest(port, honest_keys, bodies, 3 * QUIET_S)))
        time.sleep(QUIET_S)
        before, seen, outcomes = memory_mb(server.pid), [], []
        end = time.monotonic() + arguments.seconds
        threading.Thread(target=watch_memory, args=(server.pid, arguments.seconds, seen), daemon=True).start()
        threading.Thread(target=visit_hostile_server, args=(cairn, folder, end, outcomes), daemon=True).start()
        running = [(attack, key) for key in (None, attacker_key) for attack in attacks()]
        for i, (attack, key) in enumerate(running):
            attack.start(port, f"127.0.0.{2 + i}", key, end)
        answers, times = summary_of(run_honest(port, honest_keys, bodies, arguments.seconds))
        answered = line(f"under attack for {arguments.seconds:.0f} s", answers, times)
        time.sleep(SETTLE_S)
        after = memory_mb(server.pid)
        print("\n| attack | times without a key | with a key |\n|---|---|---|")
        half = len(running) // 2
        for (without, _), (with_key, _) in zip(running[:half], running[half:]):
            print(f"| {without.name} | {without.num_steps} | {with_key.num_steps} |")
        print(f"\nMemory of the server, MB: {before} before, {max(seen)} at most, {after} after. "
              f"{len(outcomes)} visits of a hostile server ended with {sorted(set(outcomes))}.")
        idle = [attack.name for attack, _ in running if attack.num_steps == 0]
        if idle:
            sys.exit(f"soak: these attacks never reached the server: {', '.join(idle)}")
        is_alive = server.poll() is None
        if not is_alive or answered < len(times) or after > before + MAX_GROWTH_MB or set(outcomes) - {7}:
            sys.exit("soak: the server does not hold")
    finally:
        server.kill()
        server.wait()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cairn", required=True)
    parser.add_argument("--map", required=True)
    parser.add_argument("--queries", help="query list with photos of the map")
    parser.add_argument("--seconds", type=float, default=600.0)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        soak(arguments, folder)


if __name__ == "__main__":
    main()
