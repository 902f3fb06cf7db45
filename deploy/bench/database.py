"""Throw-away PostgreSQL servers on sockets in folders of their own."""

import contextlib
import os
import pathlib
import shutil
import signal
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

    def __init__(self, primary=None):
        """A new server, or a standby of another one."""
        self.folder = tempfile.mkdtemp(prefix="cairn_bench_")
        if os.geteuid() == 0:
            os.chown(self.folder, NOBODY, NOBODY)
        self.log = open(f"{self.folder}/log", "w")
        if primary is None:
            self._finish("initdb", "-A", "trust", "-U", "cairn", "-E", "UTF8", "--locale=C")
        else:
            self._finish("pg_basebackup", "-h", primary.folder, "-U", "cairn", "-R", "-c", "fast")
        self.start()

    def start(self):
        self.process = self._run("postgres", "-k", self.folder, "-c", "listen_addresses=")
        socket = pathlib.Path(self.folder) / ".s.PGSQL.5432"
        cluster.wait_until(lambda: socket.exists() and self._accepts(), "a database that answers")

    def url(self, name, user="cairn"):
        return f"postgresql:///{name}?host={self.folder}&user={user}"

    def freeze(self):
        """Stops all processes, the first one first, because it starts the others."""
        self.process.send_signal(signal.SIGSTOP)
        self._signal_children(signal.SIGSTOP)

    def thaw(self):
        self._signal_children(signal.SIGCONT)
        self.process.send_signal(signal.SIGCONT)

    def kill(self):
        """Kills all processes. `start` begins anew."""
        self.freeze()
        self._signal_children(signal.SIGKILL)
        self.process.kill()
        self.process.wait(timeout=60)

    def promote(self):
        self._finish("pg_ctl", "promote", "-w")

    def _signal_children(self, number):
        first = self.process.pid
        for child in pathlib.Path(f"/proc/{first}/task/{first}/children").read_text().split():
            with contextlib.suppress(ProcessLookupError):  # The process of a closed connection ends any time.
                os.kill(int(child), number)

    def _run(self, program, *options):
        command = [programs() / program, "-D", f"{self.folder}/data", *options]
        return subprocess.Popen(command, cwd="/", stdout=self.log, stderr=self.log, **run_as_nobody_if_root())

    def _finish(self, program, *options):
        if self._run(program, *options).wait() != 0:
            raise RuntimeError(f"{program} failed:\n{pathlib.Path(self.log.name).read_text()}")

    def _accepts(self):
        command = [programs() / "pg_isready", "--quiet", "--host", self.folder]
        return subprocess.run(command, check=False).returncode == 0

    def close(self):
        if self.process.poll() is None:
            self.thaw()
            self.process.send_signal(signal.SIGINT)  # Ends connections that are still open.
            self.process.wait(timeout=60)
        self.log.close()
        shutil.rmtree(self.folder)
