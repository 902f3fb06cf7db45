"""Three `cairn serve` and a front, as processes on loopback."""

import os
import pathlib
import re
import signal
import socket
import subprocess
import tempfile
import time
import urllib.error
import urllib.request

HOST = "127.0.0.1"
START_SECONDS = 60
SHIPPED_CONFIG = pathlib.Path(__file__).resolve().parent.parent / "haproxy" / "haproxy.cfg"


def free_port():
    with socket.socket() as probe:
        probe.bind((HOST, 0))
        return probe.getsockname()[1]


def get(port, path):
    """(status, body) of a GET; (0, reason) if nobody answers."""
    try:
        with urllib.request.urlopen(f"http://{HOST}:{port}{path}", timeout=10) as response:
            return response.status, response.read().decode()
    except urllib.error.HTTPError as error:
        return error.code, error.read().decode()
    except OSError as error:
        return 0, str(error)


def wait_until(condition, what, seconds=START_SECONDS):
    """Polls until the condition holds; returns the seconds that it took."""
    begin = time.monotonic()
    while not condition():
        if time.monotonic() - begin > seconds:
            raise TimeoutError(f"not within {seconds} s: {what}")
        time.sleep(0.005)
    return time.monotonic() - begin


class Server:
    """A `cairn serve`, which keeps its port when it is started again."""

    def __init__(self, cairn, map_path, cache_mb, drain_s=0):
        self.port = free_port()
        self.command = [cairn, "serve", map_path, "--port", str(self.port), "--cache-mb", str(cache_mb),
                        "--drain-seconds", str(drain_s), "--log-level", "error"]
        self.process = None
        self.start()

    def start(self):
        self.process = subprocess.Popen(self.command, stdout=subprocess.DEVNULL)
        wait_until(self.is_ready, "a server that is ready")

    def is_ready(self):
        if self.process.poll() is not None:
            raise RuntimeError(f"cairn serve ended with {self.process.returncode}")
        return get(self.port, "/readyz")[0] == 200

    def send(self, signal_number):
        self.process.send_signal(signal_number)

    def wait(self):
        return self.process.wait(timeout=60)

    def close(self):
        if self.process.poll() is None:
            self.send(signal.SIGKILL)
        self.wait()

    def metric(self, name):
        """The sum of a metric over its labels."""
        pattern = re.compile(rf"^{name}(?:{{[^}}]*}})? (\S+)$", re.M)
        return sum(float(value) for value in pattern.findall(get(self.port, "/metrics")[1]))

    def map_version(self):
        match = re.search(r'"map":{"version":(\d+)', get(self.port, "/healthz")[1])
        return int(match[1]) if match else None


class Front:
    """HAProxy before servers."""

    def __init__(self, config, servers):
        self.port = free_port()
        self.file = tempfile.NamedTemporaryFile("w", suffix=".cfg")
        self.file.write(config)
        self.file.flush()
        environment = dict(os.environ, FRONT_ADDRESS=f"{HOST}:{self.port}")
        for number, server in enumerate(servers, 1):
            environment[f"CAIRN{number}"] = f"{HOST}:{server.port}"
        self.process = subprocess.Popen(["haproxy", "-db", "-q", "-f", self.file.name], env=environment,
                                        stdout=subprocess.DEVNULL)
        wait_until(lambda: get(self.port, "/version")[0] == 200, "a front that answers")

    def close(self):
        self.process.terminate()
        self.process.wait(timeout=60)
        self.file.close()


class Cluster:
    """Three servers and a front; ends them all when the block ends."""

    NUM_SERVERS = 3

    def __init__(self, cairn, map_path, cache_mb, config, drain_s=0):
        self.servers = []
        self.front = None
        try:
            for _ in range(self.NUM_SERVERS):
                self.servers.append(Server(cairn, map_path, cache_mb, drain_s))
            self.front = Front(config, self.servers)
        except BaseException:
            self.close()
            raise

    def close(self):
        for process in [self.front, *self.servers]:
            if process is not None:
                process.close()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def metric(self, name):
        return sum(server.metric(name) for server in self.servers)


def shipped_config():
    return SHIPPED_CONFIG.read_text()


def round_robin_config():
    """The shipped configuration with another distribution of the queries."""
    config = re.sub(r"^ *(hash-type|hash-balance-factor) .*\n", "", shipped_config(), flags=re.M)
    return config.replace("balance hdr(X-Cairn-Cell)", "balance roundrobin")
