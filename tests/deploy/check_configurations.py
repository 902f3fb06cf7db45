#!/usr/bin/env python3
"""Checks the files of deploy/ with the programs that read them. Prints which checks it skips, because
the program is not installed; the exit code is 77 if it skips them all.

Usage: check_configurations.py CAIRN_BINARY
"""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

try:
    import yaml
except ImportError:
    yaml = None

SKIPPED = 77
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


def check_kubernetes(_, __):
    image = (DEPLOY / "compose" / "Dockerfile").read_text()
    group = int(re.search(r"^USER \d+:(\d+)$", image, re.M)[1])
    for file in sorted((DEPLOY / "kubernetes").glob("*.yaml")):
        pod = yaml.safe_load(file.read_text())["spec"]["template"]["spec"]
        if pod["securityContext"]["fsGroup"] != group:
            raise CheckFailed(f"{file.name}: the group of the image is {group}")
        volumes = {volume["name"] for volume in pod["volumes"]}
        mounted = {mount["name"] for mount in pod["containers"][0]["volumeMounts"]}
        if volumes != mounted:
            raise CheckFailed(f"{file.name} has the volumes {volumes} and mounts {mounted}")


def has_program(name):
    return shutil.which(name, path=PATH) is not None


# What reads the files, whether it is installed, and the check.
CHECKS = [("haproxy", has_program("haproxy"), check_haproxy),
          ("nginx", has_program("nginx"), check_nginx),
          ("systemd-analyze", has_program("systemd-analyze"), check_systemd),
          ("promtool", has_program("promtool"), check_promtool),
          ("compose (python3-yaml)", yaml is not None, check_compose),
          ("Kubernetes (python3-yaml)", yaml is not None, check_kubernetes)]


def main():
    cairn = sys.argv[1]
    failures = []
    for program, is_installed, check in CHECKS:
        if not is_installed:
            print(f"skipped: {program} is not installed (scripts/install-dependencies --tests)")
            continue
        with tempfile.TemporaryDirectory() as scratch:
            try:
                check(pathlib.Path(scratch), cairn)
                print(f"valid: the files that {program} reads")
            except CheckFailed as failure:
                failures.append(f"{program}: {failure}")
    print("\n".join(failures))
    if not any(is_installed for _, is_installed, _ in CHECKS):
        return SKIPPED
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
