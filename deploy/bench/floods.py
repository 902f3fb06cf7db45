#!/usr/bin/env python3
"""Measures how long queries of one client take while another client floods the server.

    deploy/bench/floods.py --cairn build/release/cli/cairn --map city.gpkg

Starts `cairn serve` on loopback for each flood. The flood comes from 127.0.0.2, the queries from 127.0.0.1. Prints a
table: the longest query alone and under the flood, the answers, and the memory of the server before and after.
"""

import argparse
import http.client
import json
import random
import re
import socket
import struct
import subprocess
import threading
import time
import zlib

GOOD, ATTACKER = "127.0.0.1", "127.0.0.2"
NUM_QUERIES = 5


def gray_png(width, height, row_of):
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    rows = b"".join(b"\0" + row_of(y) for y in range(height))
    head = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows, 9)) + chunk(b"IEND", b"")


def query_of(png, width, height, timeout_ms):
    request = {"camera": {"model": "SIMPLE_PINHOLE", "size": [width, height],
                          "modelParams": [width, width / 2, height / 2]},
               "options": {"timeoutMs": timeout_ms}}
    body = (b"--B\r\nContent-Disposition: form-data; name=\"request\"\r\n\r\n" + json.dumps(request).encode() +
            b"\r\n--B\r\nContent-Disposition: form-data; name=\"image\"\r\n\r\n" + png + b"\r\n--B--\r\n")
    head = (f"POST /v1/localize HTTP/1.1\r\nHost: h\r\nContent-Type: multipart/form-data; boundary=B\r\n"
            f"Content-Length: {len(body)}\r\n\r\n")
    return head.encode() + body


def connect(port, source):
    return socket.create_connection(("127.0.0.1", port), source_address=(source, 0))


class Flood:
    """Runs `step(port)` in threads until the end of the block. A step that fails is repeated."""

    def __init__(self, step, num_threads, port):
        self.step, self.port, self.is_over = step, port, False
        self.threads = [threading.Thread(target=self.run, daemon=True) for _ in range(num_threads)]

    def run(self):
        while not self.is_over:
            try:
                self.step(self.port)
            except OSError:
                time.sleep(0.01)

    def __enter__(self):
        for thread in self.threads:
            thread.start()
        time.sleep(1.0)

    def __exit__(self, *_):
        self.is_over = True


def send_and_read(bytes_, port):
    with connect(port, ATTACKER) as connection:
        connection.sendall(bytes_)
        while connection.recv(65536):
            if b"Connection: close" in bytes_:
                continue
            break


def send_blank_lines(port):
    with connect(port, ATTACKER) as connection:
        while True:
            connection.sendall(b"\r\n" * (1 << 19))


def trickle_body(port):
    with connect(port, ATTACKER) as connection:
        connection.sendall(b"POST /v1/localize HTTP/1.1\r\nHost: h\r\nContent-Length: 1000000\r\n\r\n")
        while True:
            connection.sendall(b"x")
            time.sleep(0.001)


def get(path):
    return f"GET {path} HTTP/1.1\r\nHost: h\r\nConnection: close\r\n\r\n".encode()


def floods():
    zeros = query_of(gray_png(4000, 3000, lambda _: bytes(4000)), 4000, 3000, 60000)
    return {
        "blank lines, 4 connections": (send_blank_lines, 4),
        "photos of 12 kB and 12 megapixels, timeoutMs 60,000, 64 connections": (lambda p: send_and_read(zeros, p), 64),
        "all tiles of the world, limit=1, 16 connections":
            (lambda p: send_and_read(get("/v1/coverage?bbox=-180,-90,180,90&limit=1"), p), 16),
        "bodies a byte at a time, 64 connections": (trickle_body, 64),
    }


def memory_mb(pid):
    with open(f"/proc/{pid}/status") as status:
        return int(re.search(r"VmRSS:\s+(\d+)", status.read())[1]) // 1024


def measure(query, port):
    """The longest time of a query in seconds, and the set of answers."""
    longest, answers = 0.0, set()
    for _ in range(NUM_QUERIES):
        start = time.monotonic()
        with connect(port, GOOD) as connection:
            connection.sendall(query)
            response = http.client.HTTPResponse(connection)
            response.begin()
            body = json.loads(response.read())
        longest = max(longest, time.monotonic() - start)
        answers.add(f"{response.status} {body.get('reason') or body.get('status') or body.get('code')}")
    return longest, answers


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cairn", required=True)
    parser.add_argument("--map", required=True)
    arguments = parser.parse_args()
    noise = random.Random(1)
    photo = gray_png(320, 240, lambda _: noise.randbytes(320))
    query = query_of(photo, 320, 240, 5000)
    print("| flood | alone, s | under the flood, s | answers | memory before, after, MB |\n|---|---|---|---|---|")
    for name, (step, num_threads) in floods().items():
        server = subprocess.Popen([arguments.cairn, "serve", arguments.map, "--port", "0"], stdout=subprocess.PIPE,
                                  stderr=subprocess.DEVNULL, text=True)
        try:
            port = int(server.stdout.readline().rsplit(":", 1)[1])
            measure(query, port)
            alone, _ = measure(query, port)
            before = memory_mb(server.pid)
            with Flood(step, num_threads, port):
                flooded, answers = measure(query, port)
            after = memory_mb(server.pid)
            print(f"| {name} | {alone:.2f} | {flooded:.2f} | {', '.join(sorted(answers))} | {before}, {after} |",
                  flush=True)
        finally:
            server.kill()
            server.wait()


if __name__ == "__main__":
    main()
