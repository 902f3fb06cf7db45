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
DEPLOY = pathlib.Path(__file__).resolve().parent.parent
# Where Debian puts the programs of administrators.
PATH = os.environ["PATH"] + ":/usr/sbin:/sbin"


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

    def __init__(self, cairn, map_path, cache_mb, drain_s=0, log=None):
        """The log goes to an open file, or to the standard error."""
        self.port = free_port()
        self.log = log
        self.command = [cairn, "serve", map_path, "--port", str(self.port), "--cache-mb", str(cache_mb),
                        "--drain-seconds", str(drain_s), "--log-level", "error"]
        self.process = None
        self.start()

    def start(self):
        self.process = subprocess.Popen(self.command, stdout=subprocess.DEVNULL, stderr=self.log)
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
    """A proxy before servers. `make_command` returns the command and the environment of the proxy."""

    def __init__(self, make_command, servers):
        self.port = free_port()
        self.scratch = tempfile.TemporaryDirectory()
        command, environment = make_command(pathlib.Path(self.scratch.name), self.port,
                                            [server.port for server in servers])
        self.process = subprocess.Popen(command, env=dict(os.environ, PATH=PATH, **environment),
                                        stdout=subprocess.DEVNULL)
        wait_until(lambda: get(self.port, "/version")[0] == 200, "a front that answers")

    def close(self):
        self.process.terminate()
        self.process.wait(timeout=60)
        self.scratch.cleanup()


def haproxy_with(config):
    def make_command(scratch, port, server_ports):
        file = scratch / "haproxy.cfg"
        file.write_text(config)
        environment = {f"CAIRN{i}": f"{HOST}:{server}" for i, server in enumerate(server_ports, 1)}
        # All clients of the bench have one address.
        return ["haproxy", "-db", "-q", "-f", file], dict(
            environment, FRONT_ADDRESS=f"{HOST}:{port}", CLIENT_REQUESTS="1000000", CLIENT_CONNECTIONS="1000")
    return make_command


def haproxy():
    return haproxy_with((DEPLOY / "haproxy" / "haproxy.cfg").read_text())


def haproxy_round_robin():
    """The shipped configuration with another distribution of the queries."""
    config = (DEPLOY / "haproxy" / "haproxy.cfg").read_text()
    config = re.sub(r"^ *(hash-type|hash-balance-factor) .*\n", "", config, flags=re.M)
    return haproxy_with(config.replace("balance hdr(X-Cairn-Cell)", "balance roundrobin"))


def nginx():
    def make_command(scratch, port, server_ports):
        config = (DEPLOY / "nginx" / "cairn.conf").read_text().replace("listen 8080", f"listen {HOST}:{port}")
        for shipped, server in zip((8081, 8082, 8083), server_ports):
            config = config.replace(f"{HOST}:{shipped}", f"{HOST}:{server}")
        # All clients of the bench have one address.
        config = config.replace("rate=20r/s", "rate=10000r/s").replace("limit_conn clients_open 100", "limit_conn clients_open 1000")
        folders = "".join(f"{kind}_temp_path {scratch}/{kind};" for kind in
                          ("client_body", "proxy", "fastcgi", "uwsgi", "scgi"))
        (scratch / "nginx.conf").write_text(
            f"daemon off; pid {scratch}/pid; events {{}}\nhttp {{ access_log off; {folders}\n{config} }}\n")
        scratch.chmod(0o755)  # The workers of nginx run as another user.
        return ["nginx", "-e", scratch / "errors", "-c", scratch / "nginx.conf"], {}
    return make_command


class Cluster:
    """Three servers and a front; ends them all when the block ends."""

    NUM_SERVERS = 3

    def __init__(self, cairn, map_path, cache_mb, make_front, drain_s=0):
        self.servers = []
        self.front = None
        try:
            for _ in range(self.NUM_SERVERS):
                self.servers.append(Server(cairn, map_path, cache_mb, drain_s))
            self.front = Front(make_front, self.servers)
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
