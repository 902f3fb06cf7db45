"""Queries of a query list (docs/formats/query_list_v1.md) as HTTP requests, and streams of them."""

import http.client
import json
import pathlib
import random
import threading
import time
import typing

import cluster

CELL_HEADER = "X-Cairn-Cell"
TIMEOUT_MS = 60_000  # No deadline cuts an answer short, so equal queries have equal answers.
BOUNDARY = "cairn-bench-boundary"


class Request(typing.NamedTuple):
    lat: float
    lon: float
    body: bytes


class Outcome(typing.NamedTuple):
    request_idx: int
    status: int  # 0 if the connection failed.
    body: bytes
    seconds: float


def multipart(request_json, features):
    parts = [("request", "application/json", request_json.encode()),
             ("features", "application/octet-stream", features)]
    body = b""
    for name, content_type, content in parts:
        body += (f'--{BOUNDARY}\r\nContent-Disposition: form-data; name="{name}"\r\n'
                 f"Content-Type: {content_type}\r\n\r\n").encode() + content + b"\r\n"
    return body + f"--{BOUNDARY}--\r\n".encode()


def load_requests(list_path, include=(), timeout_ms=TIMEOUT_MS):
    list_path = pathlib.Path(list_path)
    requests = []
    for query in json.loads(list_path.read_text())["queries"]:
        fields = {name: query[name] for name in ("camera", "prior", "gravity")}
        fields["options"] = {"timeoutMs": timeout_ms, "maxMatches": 1, "include": list(include)}
        position = query["prior"]["position"]
        requests.append(Request(position["lat"], position["lon"], multipart(
            json.dumps(fields), (list_path.parent / query["features"]).read_bytes())))
    return requests


def learn_cells(port, requests):
    """The cell of each request, as the server names it."""
    cells = []
    for request in requests:
        status, body = cluster.get(port, f"/v1/availability?lat={request.lat}&lon={request.lon}")
        if status != 200:
            raise RuntimeError(f"/v1/availability: {status} {body}")
        cells.append(json.loads(body)["cell"])
    return cells


def at_random(num_requests, seed):
    """Endless indices of requests."""
    generator = random.Random(seed)
    while True:
        yield generator.randrange(num_requests)


class Stream:
    """Sends queries over a few connections, as fast as they are answered: the first `num_queries` of
    `order`, and more of them until `finish` is called."""

    NUM_CLIENTS = 16

    def __init__(self, port, requests, cells, order, num_queries):
        self.port = port
        self.requests = requests
        self.cells = cells
        self.order = iter(order)
        self.num_queries = num_queries
        self.num_begun = 0
        self.may_end = False
        self.outcomes = []
        self.lock = threading.Lock()
        self.threads = [threading.Thread(target=self._work) for _ in range(self.NUM_CLIENTS)]

    def start(self):
        for thread in self.threads:
            thread.start()
        return self

    def wait_for(self, num_answers):
        while len(self.outcomes) < num_answers:
            time.sleep(0.002)

    def finish(self):
        self.may_end = True
        for thread in self.threads:
            thread.join()
        return self.outcomes

    def _work(self):
        connection = http.client.HTTPConnection(cluster.HOST, self.port, timeout=90)
        while True:
            request_idx = self._next()
            if request_idx is None:
                return connection.close()
            self.outcomes.append(self._ask(connection, request_idx))

    def _next(self):
        """The index of the next request; None at the end."""
        with self.lock:
            if self.may_end and self.num_begun >= self.num_queries:
                return None
            self.num_begun += 1
            return next(self.order, None)

    def _ask(self, connection, request_idx):
        headers = {"Content-Type": f"multipart/form-data; boundary={BOUNDARY}",
                   CELL_HEADER: self.cells[request_idx]}
        begin = time.monotonic()
        try:
            connection.request("POST", "/v1/localize", self.requests[request_idx].body, headers)
            response = connection.getresponse()
            return Outcome(request_idx, response.status, response.read(), time.monotonic() - begin)
        except (OSError, http.client.HTTPException) as error:
            connection.close()
            return Outcome(request_idx, 0, str(error).encode(), time.monotonic() - begin)


def map_version(outcome):
    return json.loads(outcome.body)["map"]["version"]


def content(outcome):
    """All of an answer that depends on nothing but the query and the version of the map."""
    answer = json.loads(outcome.body)
    for name in ("map", "stages"):
        answer.pop(name)
    return json.dumps(answer, sort_keys=True)
