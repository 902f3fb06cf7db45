#!/usr/bin/env python3
"""What check_pages.py has instead of systemctl: starts and stops the services of the pages as their units say."""

import fnmatch
import os
import pathlib
import re
import shlex
import shutil
import signal
import subprocess
import sys

PIDS = pathlib.Path("/run/services_of_test")


def unit_of(service):
    name, _, instance = service.partition("@")
    folders = [pathlib.Path("/etc/systemd/system"), pathlib.Path("/lib/systemd/system")]
    file = f"{name}@.service" if instance else f"{name}.service"
    text = next((folder / file for folder in folders if (folder / file).exists())).read_text()
    return re.findall(r"^(\w+)=(.*)$", text.replace("%i", instance).replace("\\\n", " "), re.M)


def environment_of(unit):
    environment = dict(os.environ)
    for key, value in unit:
        if key == "Environment":
            environment.update(entry.split("=", 1) for entry in shlex.split(value))
        if key == "EnvironmentFile" and pathlib.Path(value.lstrip("-")).exists():
            for line in pathlib.Path(value.lstrip("-")).read_text().splitlines():
                if re.match(r"\w+=", line):
                    name, text = line.split("=", 1)
                    environment[name] = text.strip('"')
    return environment


def start(service):
    if service == "postgresql":
        subprocess.run(["pg_ctlcluster", "15", "main", "restart"], check=True)
        return
    unit = unit_of(service)
    environment = environment_of(unit)
    settings = dict(unit)
    command = []
    for word in shlex.split(settings["ExecStart"]):
        if match := re.fullmatch(r"\$(\w+)", word):  # Becomes several words.
            command += shlex.split(environment.get(match[1], ""))
        else:
            command.append(re.sub(r"\$\{(\w+)\}", lambda match: environment.get(match[1], ""), word))
    user = settings.get("User")
    home = {"HOME": f"/var/lib/{user}"} if user else {}
    if logs := settings.get("LogsDirectory"):
        folder = pathlib.Path("/var/log") / logs
        folder.mkdir(exist_ok=True)
        folder.chmod(int(settings["LogsDirectoryMode"], 8))
        shutil.chown(folder, user, user)
    log = open(f"/run/{service}.log", "w")
    process = subprocess.Popen(command, env=dict(environment, **home), user=user, group=user, stdin=subprocess.DEVNULL,
                               extra_groups=[] if user else None, stdout=log, stderr=log, start_new_session=True)
    PIDS.mkdir(exist_ok=True)
    (PIDS / service).write_text(str(process.pid))


def stop(service):
    if service == "postgresql":
        subprocess.run(["pg_ctlcluster", "15", "main", "stop"], check=True)
    elif (PIDS / service).exists():
        os.killpg(int((PIDS / service).read_text()), signal.SIGKILL)
        (PIDS / service).unlink()


def reload(service):
    pid = (PIDS / service).read_text()
    command = dict(unit_of(service))["ExecReload"].replace("$MAINPID", pid)
    subprocess.run(shlex.split(command), check=True)


def running(pattern):
    """The services that a pattern names, as systemctl reads it, or the one with this name."""
    services = sorted(path.name for path in PIDS.glob("*")) if PIDS.exists() else []
    return [service for service in services if fnmatch.fnmatch(service, pattern)]


def main():
    verb, *services = [word for word in sys.argv[1:] if not word.startswith("--")]
    if verb == "show":
        name = next(word.split("=")[1] for word in sys.argv if word.startswith("--property="))
        print(f"{name}={dict(unit_of(services[0]))[name]}")
    if verb == "reload":
        for service in [service for pattern in services for service in running(pattern)]:
            reload(service)
    for service in services:
        if verb in ("stop", "restart"):
            if verb == "stop" or service != "postgresql":
                stop(service)
        if verb in ("enable", "restart"):
            start(service)


if __name__ == "__main__":
    main()
