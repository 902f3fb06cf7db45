#!/usr/bin/env python3
"""Runs both fronts of deploy/ with TLS before servers that tell what they see: a certificate that the script
makes, the redirection to https, the addresses of the clients, the limit of requests, the routes of operators,
and, with HAProxy, servers that are found by DNS. Prints what it skips; the exit code is 77 if it skips all.
"""

import http.client
import http.server
import json
import os
import pathlib
import shutil
import socket
import socketserver
import ssl
import subprocess
import sys
import tempfile
import threading
import warnings

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "deploy" / "bench"))
import cluster  # noqa: E402

SKIPPED = 77
HAPROXY_CONFIG = ROOT / "deploy" / "haproxy" / "haproxy.cfg"
NGINX_CONFIG = ROOT / "deploy" / "nginx" / "cairn.conf"
# Fewer than the fronts allow as shipped, so that a slow machine asks often enough.
ALLOWED_REQUESTS = 50


class Teller(http.server.BaseHTTPRequestHandler):
    """Answers each request with its headers and the address that it came to."""
    protocol_version = "HTTP/1.1"

    def do_GET(self):
        seen = {"headers": {name.lower(): self.headers.get_all(name) for name in self.headers},
                "server": self.server.server_address[0]}
        body = json.dumps(seen).encode()
        self.send_response(200)
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, *_):
        pass


class Tellers(http.server.ThreadingHTTPServer):
    daemon_threads = True

    def handle_error(self, *_):
        """Fronts reset the connections of their health checks."""


def start_teller(host, port):
    server = Tellers((host, port), Teller)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    return server


class Names(socketserver.BaseRequestHandler):
    """A DNS server that answers every question for IPv4 addresses with `addresses`."""
    addresses = []

    def handle(self):
        query, reply_to = self.request
        end = 12
        while query[end] != 0:
            end += 1 + query[end]
        question = query[12:end + 5]
        wants_ipv4 = question[-4:-2] == b"\0\1"
        answers = [b"\xc0\x0c\0\1\0\1\0\0\0\1\0\4" + socket.inet_aton(address)
                   for address in (self.addresses if wants_ipv4 else [])]
        counts = b"\0\1" + len(answers).to_bytes(2, "big") + b"\0\0\0\0"
        reply_to.sendto(query[:2] + b"\x81\x80" + counts + question + b"".join(answers), self.client_address)


class Front:
    """A running front, which has the certificate `authority`."""

    def __init__(self, command, environment, port, tls_port, authority):
        self.port, self.tls_port = port, tls_port
        self.context = ssl.create_default_context(cafile=authority)
        self.process = subprocess.Popen(command, env=dict(os.environ, PATH=cluster.PATH, **environment),
                                        stdout=subprocess.DEVNULL)
        try:
            cluster.wait_until(lambda: self.answers("/version"), "a front that answers")
        except BaseException:
            self.close()
            raise

    def answers(self, path):
        if self.process.poll() is not None:
            raise RuntimeError(f"the front ended with {self.process.returncode}")
        try:
            return self.get(path)[0] == 200
        except OSError:
            return False

    def get(self, path, headers=None, tls=True, source="127.0.0.1", connection=None):
        """(status, headers, body) of a GET."""
        own = connection or self.connect(tls, source)
        try:
            own.request("GET", path, headers=headers or {})
            response = own.getresponse()
            return response.status, response.headers, response.read().decode()
        finally:
            if connection is None:
                own.close()

    def connect(self, tls=True, source="127.0.0.1"):
        if tls:
            return http.client.HTTPSConnection("localhost", self.tls_port, context=self.context, timeout=10,
                                               source_address=(source, 0))
        return http.client.HTTPConnection("127.0.0.1", self.port, timeout=10, source_address=(source, 0))

    def close(self):
        self.process.terminate()
        self.process.wait(timeout=60)


def make_certificate(folder):
    """A certificate of `localhost` that is its own authority."""
    subprocess.run(["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1",
                    "-nodes", "-keyout", folder / "cairn.key", "-out", folder / "cairn.pem", "-days", "2",
                    "-subj", "/CN=localhost", "-addext", "subjectAltName=DNS:localhost"],
                   check=True, capture_output=True)
    (folder / "both.pem").write_text((folder / "cairn.pem").read_text() + (folder / "cairn.key").read_text())


def haproxy(scratch, servers):
    port, tls_port = cluster.free_port(), cluster.free_port()
    environment = {"FRONT_ADDRESS": f"127.0.0.1:{port}", "TLS_ADDRESS": f"127.0.0.1:{tls_port}",
                   "TLS_CERTIFICATE": str(scratch / "both.pem"), "CLIENT_REQUESTS": str(ALLOWED_REQUESTS), **servers}
    return Front(["haproxy", "-db", "-q", "-f", HAPROXY_CONFIG], environment, port, tls_port,
                 scratch / "cairn.pem")


def haproxy_before(scratch, ports):
    return haproxy(scratch, {f"CAIRN{i}": f"127.0.0.1:{port}" for i, port in enumerate(ports, 1)})


def nginx_before(scratch, ports):
    port, tls_port = cluster.free_port(), cluster.free_port()
    config = NGINX_CONFIG.read_text().replace("listen 8080", f"listen 127.0.0.1:{port}")
    config = config.replace("rate=20r/s", "rate=1r/s").replace("burst=200", f"burst={ALLOWED_REQUESTS}")
    for shipped, server in zip((8081, 8082, 8083), ports):
        config = config.replace(f"127.0.0.1:{shipped}", f"127.0.0.1:{server}")
    tls = (ROOT / "deploy" / "nginx" / "cairn-tls.conf").read_text()
    (scratch / "cairn-tls.conf").write_text(tls.replace("listen 443", f"listen 127.0.0.1:{tls_port}"))
    folders = "".join(f"{kind}_temp_path {scratch}/{kind};"
                      for kind in ("client_body", "proxy", "fastcgi", "uwsgi", "scgi"))
    (scratch / "nginx.conf").write_text(
        f"daemon off; pid {scratch}/pid; events {{}}\nhttp {{ access_log off; {folders}\n{config} }}\n")
    scratch.chmod(0o755)  # The workers of nginx run as another user.
    return Front(["nginx", "-e", scratch / "errors", "-c", scratch / "nginx.conf"], {}, port, tls_port,
                 scratch / "cairn.pem")


def expect(condition, what):
    if not condition:
        raise AssertionError(what)


def check_tls(front):
    status, headers, _ = front.get("/v1/tiles?limit=1", tls=False)
    expect(status == 308 and headers["Location"].endswith("/v1/tiles?limit=1"), f"not sent to https: {status}")
    _, headers, _ = front.get("/version")
    expect("max-age" in headers.get("Strict-Transport-Security", ""), "no Strict-Transport-Security")
    old = ssl.create_default_context(cafile=None)
    old.check_hostname, old.verify_mode = False, ssl.CERT_NONE
    old.set_ciphers("DEFAULT:@SECLEVEL=0")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        old.minimum_version = old.maximum_version = ssl.TLSVersion.TLSv1_1
    try:
        with socket.create_connection(("127.0.0.1", front.tls_port)) as plain, old.wrap_socket(plain):
            expect(False, "TLS 1.1 is accepted")
    except (ssl.SSLError, OSError):
        pass


def check_forwarded(front):
    strange = {"X-Forwarded-For": "9.9.9.9", "X-Cairn-Cell": "32N-00388-04390"}
    seen = json.loads(front.get("/version", strange)[2])["headers"]
    expect(seen["x-forwarded-for"] == ["127.0.0.1"], f"forwarded for {seen['x-forwarded-for']}")
    expect(seen["x-cairn-cell"] == ["32N-00388-04390"], "the cell is lost")
    for path in ("/metrics", "/healthz", "/livez", "/readyz", "/%6detrics"):
        expect(front.get(path)[0] == 404, f"strangers reach {path}")


def check_limit(front):
    """A client of its own address, so that the other checks have their requests."""
    greedy = front.connect(source="127.0.0.77")
    answers = [front.get("/version", connection=greedy) for _ in range(2 * ALLOWED_REQUESTS)]
    statuses = [status for status, _, _ in answers]
    expect(set(statuses[:ALLOWED_REQUESTS]) == {200}, "refused within the limit")
    expect(set(statuses) == {200, 429}, f"statuses {sorted(set(statuses))}")
    _, headers, body = answers[statuses.index(429)]
    expect(headers["Retry-After"] is not None, "429 without Retry-After")
    expect(headers["Content-Type"] == "application/problem+json" and json.loads(body)["status"] == 429, body)
    expect(front.get("/version")[0] == 200, "another client is refused")


def check_dns(scratch, _):
    hosts = ["127.0.0.21", "127.0.0.22", "127.0.0.23"]
    first = start_teller(hosts[0], 0)
    port = first.server_address[1]
    for host in hosts[1:]:
        start_teller(host, port)
    Names.addresses = hosts[:2]
    names = socketserver.ThreadingUDPServer(("127.0.0.1", 0), Names)
    threading.Thread(target=names.serve_forever, daemon=True).start()
    front = haproxy(scratch, {"CAIRN_SERVERS": f"cairn.test:{port}",
                              "DNS_SERVER": f"127.0.0.1:{names.server_address[1]}",
                              "CLIENT_REQUESTS": "1000000"})

    def servers_in_use():
        answers = [front.get("/version") for _ in range(6)]
        return {json.loads(body)["server"] for status, _, body in answers if status == 200}
    try:
        cluster.wait_until(lambda: servers_in_use() == set(hosts[:2]), "both servers of the name")
        Names.addresses = hosts[1:]
        cluster.wait_until(lambda: servers_in_use() == set(hosts[1:]), "the new server instead of the old one")
        names.shutdown()  # DNS falls silent.
        expect(servers_in_use() == set(hosts[1:]), "a silent DNS server takes servers away")
    finally:
        front.close()


def check_front(make):
    def check(scratch, ports):
        front = make(scratch, ports)
        try:
            for part in (check_tls, check_forwarded, check_limit):
                part(front)
        finally:
            front.close()
    return check


CHECKS = [("haproxy", "HAProxy", check_front(haproxy_before)), ("nginx", "nginx", check_front(nginx_before)),
          ("haproxy", "HAProxy with DNS", check_dns)]


def main():
    if shutil.which("openssl") is None:
        print("skipped: openssl is not installed")
        return SKIPPED
    ports = [start_teller("127.0.0.1", 0).server_address[1] for _ in range(3)]
    num_checked = 0
    for program, name, check in CHECKS:
        if shutil.which(program, path=cluster.PATH) is None:
            print(f"skipped: {program} is not installed (scripts/install-dependencies --tests)")
            continue
        with tempfile.TemporaryDirectory() as scratch:
            folder = pathlib.Path(scratch)
            make_certificate(folder)
            check(folder, ports)
        num_checked += 1
        print(f"{name}: passed")
    return 0 if num_checked > 0 else SKIPPED


if __name__ == "__main__":
    sys.exit(main())
