"""A throw-away PostgreSQL server on a socket in a folder of its own."""

import os
import pathlib
import shutil
import subprocess
import tempfile

import cluster

NOBODY = 65534


def programs():
    """The folder of the newest PostgreSQL with PostGIS, or None."""
    extensions = pathlib.Path("/usr/share/postgresql").glob("*/extension/postgis.control")
    versions = [file.parent.parent.name for file in extensions]
    folders = [pathlib.Path("/usr/lib/postgresql") / version / "bin" for version in versions]
    return max((folder for folder in folders if (folder / "initdb").exists()), default=None)


def run_as_nobody_if_root():
    """PostgreSQL refuses to run as root."""
    return {"user": NOBODY, "group": NOBODY, "extra_groups": []} if os.geteuid() == 0 else {}


class Database:
    """Ends and vanishes when it is closed. All roles may log in without a password."""

    def __init__(self):
        self.folder = tempfile.mkdtemp(prefix="cairn_bench_")
        if os.geteuid() == 0:
            os.chown(self.folder, NOBODY, NOBODY)
        self.log = open(f"{self.folder}/log", "w")
        self._run("initdb", "-A", "trust", "-U", "cairn", "-E", "UTF8", "--locale=C").wait()
        self.process = self._run("postgres", "-k", self.folder, "-c", "listen_addresses=")
        socket = pathlib.Path(self.folder) / ".s.PGSQL.5432"
        cluster.wait_until(lambda: socket.exists() and self._accepts(), "a database that answers")

    def url(self, name):
        return f"postgresql:///{name}?host={self.folder}&user=cairn"

    def _run(self, program, *options):
        command = [programs() / program, "-D", f"{self.folder}/data", *options]
        return subprocess.Popen(command, cwd="/", stdout=self.log, stderr=self.log, **run_as_nobody_if_root())

    def _accepts(self):
        command = [programs() / "pg_isready", "--quiet", "--host", self.folder]
        return subprocess.run(command, check=False).returncode == 0

    def close(self):
        self.process.terminate()
        self.process.wait(timeout=60)
        self.log.close()
        shutil.rmtree(self.folder)
