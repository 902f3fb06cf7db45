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
HAPROXY_ENVIRONMENT = {"FRONT_ADDRESS": "127.0.0.1:8080"}
THREE_SERVERS = {"CAIRN1": "127.0.0.1:8081", "CAIRN2": "127.0.0.1:8082", "CAIRN3": "127.0.0.1:8083"}
MAX_EXPOSURE = 2.0  # Of `systemd-analyze security`, from 0 to 10.
# Requests and answers in memory, the program, and 0.3 GB for each of four cores (docs/http.md, Memory).
LEAST_BESIDE_CACHE_MB = 1600
# Where Debian puts the programs of administrators.
PATH = os.environ["PATH"] + ":/usr/sbin:/sbin"


class CheckFailed(Exception):
    """A file is not what its program expects."""


def run(command, **environment):
    finished = subprocess.run(command, env=dict(os.environ, PATH=PATH, **environment), text=True,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    if finished.returncode != 0:
        raise CheckFailed(f"{' '.join(map(str, command))}\n{finished.stdout}")
    return finished.stdout


def check_haproxy(_, __):
    everywhere = ["haproxy", "-c", "-f", DEPLOY / "haproxy" / "haproxy.cfg"]
    run(everywhere, **HAPROXY_ENVIRONMENT, **THREE_SERVERS)
    run([*everywhere, "-f", DEPLOY / "haproxy" / "debian.cfg"], **HAPROXY_ENVIRONMENT, **THREE_SERVERS)
    run(everywhere, **HAPROXY_ENVIRONMENT, CAIRN_SERVERS="cairn.internal:8080")


def check_nginx(scratch, _):
    main = scratch / "nginx.conf"
    main.write_text(f"pid {scratch}/pid; error_log {scratch}/log; events {{}}\n"
                    f"http {{ include {DEPLOY}/nginx/cairn.conf; access_log off; }}\n")
    run(["nginx", "-t", "-e", scratch / "log", "-c", main])  # check_fronts.py has the one with TLS.


def check_systemd(scratch, cairn):
    unit = scratch / "cairn@.service"
    text = (DEPLOY / "systemd" / unit.name).read_text()
    unit.write_text(text.replace("/usr/bin/cairn", cairn))  # It must exist.
    run(["systemd-analyze", "verify", unit])
    run(["systemd-analyze", "security", "--offline=true", f"--threshold={round(10 * MAX_EXPOSURE)}", unit])
    directives = dict(re.findall(r"^(\w+)=(.*)$", text, re.M))
    cache_mb = int(re.search(r"--cache-mb (\d+)", text)[1])
    memory_mb = 1024 * int(re.fullmatch(r"(\d+)G", directives["MemoryMax"])[1])
    if memory_mb < cache_mb + LEAST_BESIDE_CACHE_MB:
        raise CheckFailed(f"the service gets {memory_mb} MB, but its cache alone takes {cache_mb} MB")


def check_promtool(_, __):
    run(["promtool", "check", "config", DEPLOY / "prometheus" / "prometheus.yaml"])
    run(["promtool", "test", "rules", DEPLOY / "prometheus" / "alerts_test.yaml"])


def number_of_mb(text):
    number, unit = re.fullmatch(r"(\d+)([GM])I?", text.upper()).groups()
    return int(number) * (1024 if unit == "G" else 1)


def check_memory(name, arguments, limit):
    """The limit of a container holds the cache of its server."""
    text = " ".join(map(str, arguments))
    cache = re.search(r"--cache-mb[ =](\d+)", text)
    if cache and number_of_mb(limit) < int(cache[1]) + LEAST_BESIDE_CACHE_MB:
        raise CheckFailed(f"{name} gets {limit}, but its cache alone takes {cache[1]} MB")


def check_compose(_, __):
    compose = yaml.safe_load((DEPLOY / "compose" / "compose.yaml").read_text())
    services = compose["services"]
    for name, service in services.items():
        if "mem_limit" not in service:
            raise CheckFailed(f"compose.yaml does not limit the memory of {name}")
        check_memory(name, service.get("command", []), service["mem_limit"])
        for network in service["networks"]:
            if network not in compose["networks"]:
                raise CheckFailed(f"{name} is in {network}, which compose.yaml does not have")
    name, port = services["front"]["environment"]["CAIRN_SERVERS"].split(":")
    if name not in services or port not in services[name]["command"]:
        raise CheckFailed(f"the front looks for {name} with the port {port}")
    run(["haproxy", "-c", "-f", DEPLOY / "haproxy" / "haproxy.cfg"], **services["front"]["environment"])
    if services[name]["deploy"]["replicas"] < 2:
        raise CheckFailed("a front before one server")
    for volume in (mount for service in services.values() for mount in service.get("volumes", [])):
        source = volume.split(":")[0]
        if source.startswith(".") and not (DEPLOY / "compose" / source).is_file():
            raise CheckFailed(f"compose.yaml mounts {source}, which does not exist")


def pods_of(documents):
    return [document["spec"]["template"]["spec"] for document in documents
            if "template" in document.get("spec", {})]


def check_pod(file, pod):
    volumes = {volume["name"] for volume in pod.get("volumes", [])}
    containers = pod["containers"] + pod.get("initContainers", [])
    mounted = {mount["name"] for container in containers for mount in container.get("volumeMounts", [])}
    if volumes != mounted:
        raise CheckFailed(f"{file.name} has the volumes {volumes} and mounts {mounted}")
    for container in pod["containers"]:
        check_memory(container["name"], container.get("args", []),
                     container.get("resources", {}).get("limits", {}).get("memory", "1000G"))


def check_kubernetes(_, __):
    image = (DEPLOY / "compose" / "Dockerfile").read_text()
    group = int(re.search(r"^USER \d+:(\d+)$", image, re.M)[1])
    for file in sorted((DEPLOY / "kubernetes").glob("*.yaml")):
        for pod in pods_of(yaml.safe_load_all(file.read_text())):
            check_pod(file, pod)
            if pod["containers"][0]["image"].startswith("cairn:") and pod["securityContext"]["fsGroup"] != group:
                raise CheckFailed(f"{file.name}: the group of the image is {group}")
    documents = list(yaml.safe_load_all((DEPLOY / "kubernetes" / "serve.yaml").read_text()))
    check_services(documents)


def check_services(documents):
    """Each service finds pods with the port that it names, and the front finds the service of the servers."""
    deployments = [document for document in documents if document["kind"] == "Deployment"]
    services = [document for document in documents if document["kind"] == "Service"]
    for service in services:
        pods = [deployment["spec"]["template"] for deployment in deployments
                if service["spec"]["selector"].items() <= deployment["spec"]["template"]["metadata"]["labels"].items()]
        ports = {port["name"] for pod in pods for port in pod["spec"]["containers"][0]["ports"]}
        if not {port["targetPort"] for port in service["spec"]["ports"]} <= ports:
            raise CheckFailed(f"the service {service['metadata']['name']} leads to no port of {ports}")
    for deployment in deployments:
        container = deployment["spec"]["template"]["spec"]["containers"][0]
        if "readinessProbe" not in container or "livenessProbe" not in container:
            raise CheckFailed(f"{deployment['metadata']['name']} has no probes")
        environment = {entry["name"]: entry.get("value") for entry in container.get("env", [])}
        name = environment.get("CAIRN_SERVERS", "").split(".")[0]
        if name and name not in {service["metadata"]["name"] for service in services}:
            raise CheckFailed(f"the front looks for {name}")


def missing_from(given, known, path=""):
    """Where `given` has something that `known` has not."""
    if isinstance(given, dict) and isinstance(known, dict):
        return [missing for key, value in given.items()
                for missing in (missing_from(value, known[key], f"{path}/{key}") if key in known
                                else [f"{path}/{key}"])]
    if isinstance(given, list) and isinstance(known, list) and len(given) == len(known):
        return [missing for i, pair in enumerate(zip(given, known)) for missing in missing_from(*pair, f"{path}/{i}")]
    return [] if type(given) is not type(known) or given == known else [path]


def check_kubectl(scratch, _):
    """kubectl reads the manifests with the types of Kubernetes, without a cluster. It refuses values of a
    wrong type, and what it writes lacks the fields that it does not know."""
    for file in sorted((DEPLOY / "kubernetes").glob("*.yaml")):
        for document in yaml.safe_load_all(file.read_text()):
            one = scratch / "one.yaml"
            one.write_text(yaml.safe_dump(document))
            change = (["selector"], list(map("=".join, document["spec"]["selector"].items()))) \
                if document["kind"] == "Service" else (["env"], ["CHECKED=1"])
            written = run(["kubectl", "set", *change[0], "--local", "-f", one, "-o", "yaml", *change[1]])
            known = yaml.safe_load(written)
            for container in pods_of([known])[0]["containers"] if pods_of([known]) else []:
                container["env"] = [entry for entry in container["env"] if entry["name"] != "CHECKED"]
            for pod in pods_of([document]):
                for container in pod["containers"]:
                    container.setdefault("env", [])
            if missing := missing_from(document, known):
                raise CheckFailed(f"{file.name}: Kubernetes does not know {missing}")


def has_program(name):
    return shutil.which(name, path=PATH) is not None


def has_kubectl():
    """Of Kubernetes 1.21 or newer, which knows jobs with an index. Debian 12 has 1.20."""
    if not has_program("kubectl"):
        return False
    version = run(["kubectl", "version", "--client", "-o", "yaml"])
    return int(re.search(r"minor: \"?(\d+)", version)[1]) >= 21


# What reads the files, whether it is installed, and the check.
CHECKS = [("haproxy", has_program("haproxy"), check_haproxy),
          ("nginx", has_program("nginx"), check_nginx),
          ("systemd-analyze", has_program("systemd-analyze"), check_systemd),
          ("promtool", has_program("promtool"), check_promtool),
          ("compose (python3-yaml)", yaml is not None and has_program("haproxy"), check_compose),
          ("Kubernetes (python3-yaml)", yaml is not None, check_kubernetes),
          ("kubectl 1.21", yaml is not None and has_kubectl(), check_kubectl)]


def main():
    cairn = sys.argv[1]
    failures = []
    for program, is_installed, check in CHECKS:
        if not is_installed:
            print(f"skipped: {program} is not installed (scripts/install-dependencies --tests, for all but kubectl)")
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
