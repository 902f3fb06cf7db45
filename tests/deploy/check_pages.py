#!/usr/bin/env python3
"""Follows the commands of docs/postgresql.md and docs/operations.md from nothing, in namespaces of their own, and
rotates the access log as docs/http.md says: changes of /etc, /usr, /var and /run vanish at the end. All commands are
real but apt-get, whose packages must be installed, and systemctl, which is systemctl_of_test.py. Needs root. The exit
code is 77 if it skips.

Usage: check_pages.py CAIRN_BINARY
"""

import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import time

SKIPPED = 77
ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
ADDRESS = "10.0.0.5"  # Of the only machine, in the range that the page admits.

# Packages are there, and the package of Cairn brings its program, its unit and its user.
APT_GET = """#!/bin/sh
for name; do
  case $name in
    *cairn_*.deb)
      cp "$CAIRN" /usr/bin/cairn && cp deploy/systemd/cairn@.service /lib/systemd/system/ \\
        && sh deploy/debian/postinst configure || exit 1 ;;
    install|--yes) ;;
    *) dpkg --status "$name" > /dev/null || exit 1 ;;
  esac
done
"""


def commands_of(page, heading):
    """The blocks of shell commands below a heading, as far as the next heading of its level."""
    text = (ROOT / "docs" / page).read_text()
    section = text.split(f"\n## {heading}\n", 1)[1].split("\n## ", 1)[0]
    blocks = re.findall(r"^```sh\n(.*?)^```", section, re.M | re.S)
    if not blocks:
        raise RuntimeError(f"{page} has no commands below '{heading}'")
    return blocks


def run(script, folder, what):
    """Every command must succeed."""
    finished = subprocess.run(["bash", "-e", "-o", "pipefail", "-c", script], cwd=folder, text=True, timeout=250,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL)
    if finished.returncode != 0:
        sys.exit(f"failed: {what}\n{finished.stdout}")
    return finished.stdout


def has_packages(*names):
    return all(subprocess.run(["dpkg", "--status", name], capture_output=True).returncode == 0 for name in names)


def enter_namespaces():
    """Runs the script again in new namespaces, of which it is root."""
    if os.environ.get("CAIRN_PAGES_INSIDE"):
        return
    attempt = subprocess.run(["unshare", "--mount", "--net", "--pid", "--fork", "true"], capture_output=True)
    if os.geteuid() != 0 or attempt.returncode != 0:
        print("skipped: needs root and namespaces")
        sys.exit(SKIPPED)
    os.execvpe("unshare", ["unshare", "--mount", "--net", "--pid", "--fork", "--kill-child", "--mount-proc",
                           sys.executable, *sys.argv], dict(os.environ, CAIRN_PAGES_INSIDE="1"))


def prepare_machine(cairn):
    """Layers over the folders of the machine, its address and names, and the two stand-ins."""
    def mount(*arguments):
        subprocess.run(["mount", *arguments], check=True)
    mount("--make-rprivate", "/")
    scratch = pathlib.Path("/mnt")
    mount("-t", "tmpfs", "tmpfs", scratch)
    folder = scratch / "work"
    shutil.copytree(ROOT / "deploy", folder / "deploy")
    for name in ("etc", "usr", "var"):
        upper, work = scratch / f"{name}_upper", scratch / f"{name}_work"
        upper.mkdir()
        work.mkdir()
        mount("-t", "overlay", "overlay", "-o", f"lowerdir=/{name},upperdir={upper},workdir={work}", f"/{name}")
    mount("-t", "tmpfs", "tmpfs", "/run")
    subprocess.run(["ip", "link", "set", "lo", "up"], check=True)
    subprocess.run(["ip", "address", "add", f"{ADDRESS}/24", "dev", "lo"], check=True)
    with open("/etc/hosts", "a") as hosts:
        hosts.write(f"\n{ADDRESS} db1\n127.0.0.1 localhost\n{ADDRESS} city.example.org\n")
    home, programs = scratch / "home", scratch / "bin"
    home.mkdir()
    programs.mkdir()
    (programs / "apt-get").write_text(APT_GET)
    shutil.copy(pathlib.Path(__file__).parent / "systemctl_of_test.py", programs / "systemctl")
    for program in programs.iterdir():
        program.chmod(0o755)
    scratch.chmod(0o755)
    os.environ.update(HOME=str(home), CAIRN=cairn, PATH=f"{programs}:/usr/sbin:/usr/bin:/sbin:/bin")
    subprocess.run([cairn, "init", folder / "city.gpkg"], check=True, stdout=subprocess.DEVNULL)
    return folder


def follow_postgresql(folder):
    # As the Debian package leaves the machine.
    for path in ("/etc/postgresql", "/var/lib/postgresql", "/var/log/postgresql"):
        shutil.rmtree(path, ignore_errors=True)
    run("install -d -o postgres -g postgres /etc/postgresql /var/lib/postgresql /var/log/postgresql /run/postgresql;"
        "pg_createcluster 15 main && pg_ctlcluster 15 main start", folder, "a new cluster")
    database, servers = commands_of("postgresql.md", "From nothing")
    run(database, folder, "docs/postgresql.md, the machine of the database")
    run("cp /var/lib/postgresql/*.password /var/lib/postgresql/db1.crt .", folder, "the copies of files")
    run(servers, folder, "docs/postgresql.md, the machine of the servers")
    refused = subprocess.run(["psql", f"postgresql://server:wrong@{ADDRESS}/city", "-c", "SELECT 1"],
                             capture_output=True, text=True)
    if "password authentication failed" not in refused.stderr:
        sys.exit(f"failed: a wrong password is not refused: {refused.stderr}")
    run("systemctl stop cairn@8081; systemctl stop postgresql; rm -rf /var/lib/cairn; deluser --quiet cairn", folder,
        "the end of the machine")
    print("docs/postgresql.md: followed")


def follow_operations(folder):
    several = commands_of("operations.md", "Several servers")[0]
    several = several.replace("./build/release/cairn_", "./cairn_")
    run("rm -f /etc/default/haproxy", folder, "a machine without HAProxy")
    run(several, folder, "docs/operations.md, several servers")
    run("curl --fail --silent --retry 20 --retry-connrefused http://127.0.0.1/version", folder, "the front")
    run("openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes -keyout privkey.pem -out "
        "fullchain.pem -days 2 -subj /CN=city.example.org -addext subjectAltName=DNS:city.example.org", folder,
        "a certificate")
    os.environ["CURL_CA_BUNDLE"] = str(folder / "fullchain.pem")
    # Until each server is ready, and the front has found each of them. Curl repeats what gets 503.
    curl = "curl --silent --output /dev/null --retry 30 --retry-connrefused"
    wait = (f"for port in 8081 8082 8083; do {curl} http://127.0.0.1:$port/readyz; done\n"
            f"for i in 1 2 3 4 5 6; do {curl} https://city.example.org/version; done\n")
    internet = commands_of("operations.md", "Before the open internet")[0]
    internet = internet.replace("# From another machine", wait + "# From another machine")
    output = run(internet, folder, "docs/operations.md, before the open internet")
    for expected in (r"^401$", r"^308$", r"^404$", r"^ *\d+ 429$", r"^MemoryMax="):  # The limit's line has a count.
        if not re.search(expected, output, re.M):
            sys.exit(f"failed: no {expected} in\n{output}")
    print("docs/operations.md: followed")
    if has_packages("logrotate"):
        rotate_access_log(folder)
    else:
        print("skipped: logrotate (scripts/install-dependencies --tests)")


def logged(path):
    """The labels and paths of the requests in an access log."""
    lines = [json.loads(line) for line in pathlib.Path(path).read_text().splitlines()]
    return {(line["label"], line["path"]) for line in lines}


def rotate_access_log(folder):
    """On the machine of docs/operations.md: logrotate, as docs/http.md configures it, before a second request."""
    section = (ROOT / "docs" / "http.md").read_text().split("\n## Access log\n", 1)[1]
    log, rules = re.search(r"^```\n((/\S+) \{\n.*?)^```", section, re.M | re.S).group(2, 1)
    pathlib.Path("/etc/logrotate.d/cairn").write_text(rules)
    run(f"sed -i 's|^CAIRN_OPTIONS=.*|& --access-log {log}|' /etc/default/cairn; systemctl restart cairn@8081", folder,
        "an access log")

    def ask(path):
        run(f"curl --fail --silent --retry 20 --retry-connrefused http://127.0.0.1:8081{path} "
            '--header "Authorization: Bearer $(cat phones.key)"', folder, path)
        for _ in range(500):  # The line is written after the answer.
            if os.path.exists(log) and ("phones", path) in logged(log):
                return
            time.sleep(0.02)
        sys.exit(f"failed: {path} is not in {log}")

    ask("/version")
    run("logrotate --force /etc/logrotate.d/cairn", folder, "docs/http.md, logrotate")
    for _ in range(500):  # The server opens the file again some time after SIGHUP.
        if os.path.exists(log):
            break
        time.sleep(0.02)
    ask("/geopose")
    if ("phones", "/version") not in logged(f"{log}.1") or ("phones", "/version") in logged(log):
        sys.exit("failed: the access log is not rotated")
    print("docs/http.md: the access log is rotated")


def main():
    enter_namespaces()
    folder = prepare_machine(sys.argv[1])
    num_followed = 0
    for packages, follow in ((("postgresql-15", "postgresql-15-postgis-3", "openssl"), follow_postgresql),
                             (("haproxy", "openssl"), follow_operations)):
        if not has_packages(*packages):
            print(f"skipped: {', '.join(packages)} (scripts/install-dependencies --tests)")
            continue
        follow(folder)
        num_followed += 1
    return 0 if num_followed else SKIPPED  # The namespaces end with everything in them.


if __name__ == "__main__":
    sys.exit(main())
