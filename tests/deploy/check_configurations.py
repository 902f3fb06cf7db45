#!/usr/bin/env python3
"""Checks the files of deploy/ with the programs that read them. Prints which checks it skips, because
the program is not installed.

Usage: check_configurations.py CAIRN_BINARY
"""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

DEPLOY = pathlib.Path(__file__).resolve().parent.parent.parent / "deploy"
HAPROXY_ENVIRONMENT = {"FRONT_ADDRESS": "127.0.0.1:8080", "CAIRN1": "127.0.0.1:8081",
                       "CAIRN2": "127.0.0.1:8082", "CAIRN3": "127.0.0.1:8083"}
# Where Debian puts the programs of administrators.
PATH = os.environ["PATH"] + ":/usr/sbin:/sbin"


class CheckFailed(Exception):
    """A file is not what its program expects."""


def run(command, **environment):
    finished = subprocess.run(command, env=dict(os.environ, PATH=PATH, **environment), text=True,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    if finished.returncode != 0:
        raise CheckFailed(f"{' '.join(map(str, command))}\n{finished.stdout}")


def check_haproxy(_, __):
    everywhere = ["haproxy", "-c", "-f", DEPLOY / "haproxy" / "haproxy.cfg"]
    run(everywhere, **HAPROXY_ENVIRONMENT)
    run([*everywhere, "-f", DEPLOY / "haproxy" / "debian.cfg"], **HAPROXY_ENVIRONMENT)


def check_nginx(scratch, _):
    main = scratch / "nginx.conf"
    main.write_text(f"pid {scratch}/pid; error_log {scratch}/log; events {{}}\n"
                    f"http {{ include {DEPLOY}/nginx/cairn.conf; access_log off; }}\n")
    run(["nginx", "-t", "-e", scratch / "log", "-c", main])


def check_systemd(scratch, cairn):
    unit = scratch / "cairn@.service"
    text = (DEPLOY / "systemd" / unit.name).read_text()
    unit.write_text(text.replace("/usr/bin/cairn", cairn))  # It must exist.
    run(["systemd-analyze", "verify", unit])


def check_promtool(_, __):
    run(["promtool", "check", "config", DEPLOY / "prometheus" / "prometheus.yaml"])
    run(["promtool", "test", "rules", DEPLOY / "prometheus" / "alerts_test.yaml"])


def check_compose(_, __):
    import yaml
    compose = yaml.safe_load((DEPLOY / "compose" / "compose.yaml").read_text())
    services = compose["services"]
    front = services["front"]["environment"]
    needed = set(re.findall(r"\$\{(\w+)\}", (DEPLOY / "haproxy" / "haproxy.cfg").read_text()))
    if set(front) != needed:
        raise CheckFailed(f"compose.yaml sets {sorted(front)}, haproxy.cfg needs {sorted(needed)}")
    servers = {f"{service['networks']['front']['ipv4_address']}:8080"
               for name, service in services.items() if name.startswith("cairn")}
    if servers != {address for name, address in front.items() if name.startswith("CAIRN")}:
        raise CheckFailed("the front of compose.yaml has other addresses than the servers")
    for volume in (mount for service in services.values() for mount in service.get("volumes", [])):
        source = volume.split(":")[0]
        if source.startswith(".") and not (DEPLOY / "compose" / source).is_file():
            raise CheckFailed(f"compose.yaml mounts {source}, which does not exist")


CHECKS = {"haproxy": check_haproxy, "nginx": check_nginx, "systemd-analyze": check_systemd,
          "promtool": check_promtool, "python3": check_compose}


def main():
    cairn = sys.argv[1]
    failures = []
    for program, check in CHECKS.items():
        if shutil.which(program, path=PATH) is None:
            print(f"skipped: {program} is not installed (scripts/install-dependencies --tests)")
            continue
        with tempfile.TemporaryDirectory() as scratch:
            try:
                check(pathlib.Path(scratch), cairn)
                print(f"valid: the files that {program} reads")
            except CheckFailed as failure:
                failures.append(f"{program}: {failure}")
    print("\n".join(failures))
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
