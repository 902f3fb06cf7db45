#!/usr/bin/env python3
"""Runs deploy/slurm on a Slurm cluster of one node that the script starts: plan, 20 tasks of which one fails,
no publication; then that task again, and the publication. Wrong numbers of tasks leave no job. The exit code is 77 if
Slurm is not installed, or cannot run here: containers may lack a cgroup file system, a name for the user or one for the host.

Usage: check_slurm.py BUILD_FOLDER
"""

import ctypes
import getpass
import os
import pathlib
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time

from array_world import World, expect, expect_equal, output_of

SKIPPED = 77
NUM_TASKS = 20
SCRIPTS = pathlib.Path(__file__).resolve().parent.parent.parent / "deploy" / "slurm"
PATH = os.environ["PATH"] + ":/usr/sbin:/sbin"  # Where Debian puts the programs of administrators.
HOST = socket.gethostname().split(".")[0]

CONFIGURATION = """
ClusterName=test
SlurmctldHost={host}(127.0.0.1)
SlurmUser={user}
SlurmdUser={user}
SlurmctldPort={controller_port}
SlurmdPort={node_port}
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
CredType=cred/munge
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
SwitchType=switch/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerType=sched/builtin
SchedulerParameters=sched_interval=1,batch_sched_delay=0,sched_min_interval=0
SlurmdParameters=config_overrides
ReturnToService=2
NodeName=node NodeHostname={host} NodeAddr=127.0.0.1 CPUs=8 State=UNKNOWN
PartitionName=all Nodes=node Default=YES State=UP
"""


# What slurmd and slurmctld say of cgroups that are not there.
CGROUP_WORDS = ("cgroup",)


class CannotRunError(Exception):
    """Slurm cannot run here, whatever Cairn does."""


def die_with_parent():
    """Ends a started program when this script ends, however it ends."""
    ctypes.CDLL(None).prctl(1, signal.SIGTERM)  # PR_SET_PDEATHSIG


def why_not():
    """Returns why Slurm cannot run here, or nothing."""
    for program in ("munged", "slurmctld", "slurmd", "sbatch"):
        if shutil.which(program, path=PATH) is None:
            return f"{program} is not installed (scripts/install-dependencies --tests)"
    try:
        getpass.getuser()
    except (KeyError, OSError):
        return "the user has no name"
    for name in (HOST, "127.0.0.1"):
        try:
            # As Slurm asks. With no other network interface than loopback, no name has an address.
            socket.getaddrinfo(name, 6817, socket.AF_INET, socket.SOCK_STREAM, flags=socket.AI_ADDRCONFIG)
        except OSError as error:
            return f"{name} has no address here, as Slurm asks for it ({error.strerror})"
    return None


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


class Cluster:
    """munged, slurmctld and slurmd with all their files in a folder."""

    def __init__(self, folder):
        self.folder = folder
        self.environment = dict(os.environ, PATH=PATH, SLURM_CONF=f"{folder}/slurm.conf",
                                SBATCH_OUTPUT=f"{folder}/%x-%A-%a.out")
        for name in ("state", "spool"):
            (folder / name).mkdir()
        (folder / "slurm.conf").write_text(CONFIGURATION.format(
            host=HOST, user=getpass.getuser(), folder=folder, controller_port=free_port(),
            node_port=free_port()))
        key = folder / "munge.key"
        key.write_bytes(os.urandom(1024))
        key.chmod(0o400)
        self.processes = []
        try:
            self.start_all(key)
        except BaseException:
            self.close()
            raise

    def start_all(self, key):
        folder = self.folder
        self.start("munged", "--foreground", "--force", f"--key-file={key}", f"--socket={folder}/munge.socket",
                   f"--pid-file={folder}/munged.pid", f"--log-file={folder}/munged.log",
                   f"--seed-file={folder}/munged.seed")
        self.wait_until(lambda: (folder / "munge.socket").exists(), "munged")
        self.start("slurmctld", "-D")
        self.start("slurmd", "-D", "-N", "node")
        self.wait_until(lambda: "idle" in self.ask("sinfo", "--noheader", "--format=%T"), "an idle node")

    def start(self, *command):
        with open(self.folder / f"{command[0]}.out", "w", encoding="utf-8") as log:
            self.processes.append(subprocess.Popen(command, env=self.environment, stdout=log,
                                                   stderr=subprocess.STDOUT, preexec_fn=die_with_parent))

    def ask(self, *command):
        return subprocess.run(command, env=self.environment, capture_output=True, text=True).stdout

    def submit(self, *command):
        return output_of(*command, env=self.environment, cwd=self.folder).split()

    def wait_until(self, condition, what, seconds=60):
        begin = time.monotonic()
        while not condition():
            if time.monotonic() - begin > seconds or any(p.poll() is not None for p in self.processes):
                logs = "\n".join(path.read_text() for path in sorted(self.folder.glob("*.out")))
                self.require_cgroups()
                sys.exit(f"failed: no {what} within {seconds} s\n{self.ask('squeue')}\n{logs}")
            time.sleep(0.05)

    def require_cgroups(self):
        """Tells a program that ended for lack of cgroups from one that failed."""
        for process, name in zip(self.processes, ("munged", "slurmctld", "slurmd")):
            log = (self.folder / f"{name}.out").read_text()
            complaints = [line for line in log.splitlines()
                          if "error" in line and any(word in line for word in CGROUP_WORDS)]
            if process.poll() is not None and complaints:
                raise CannotRunError(f"{name} found no cgroup file system: {complaints[0]}")

    def wait_for_jobs(self):
        """Returns when no job waits or runs."""
        self.wait_until(lambda: not self.ask("squeue", "--noheader").strip(), "end of the jobs")

    def state(self, job):
        fields = self.ask("scontrol", "--oneliner", "show", "job", job).split()
        return {field.split("=", 1)[1] for field in fields if field.startswith("JobState=")}

    def close(self):
        """Ends the jobs, and then the programs."""
        try:
            subprocess.run(("scancel", "--user", getpass.getuser()), env=self.environment, timeout=10,
                           stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        except subprocess.TimeoutExpired:
            pass  # The controller has gone, and started nothing since.
        for process in reversed(self.processes):
            process.terminate()
            try:
                process.wait(timeout=20)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()


def make_program(world, folder):
    """A program that is `cairn`, but whose task 7 fails while the file `broken` is there."""
    program = folder / "cairn"
    program.write_text(f'#!/bin/sh\ncase "$*" in *"--index 7 "*) [ ! -e {folder}/broken ] || exit 1;; esac\n'
                       f'exec {world.cairn} "$@"\n')
    program.chmod(0o755)
    (folder / "broken").touch()
    return program


def check_refused(cluster, world, scratch):
    """A wrong number of tasks is refused, and leaves no job: without an end, the wait for them fails."""
    program = scratch / "endless"
    program.write_text("#!/bin/sh\nexec sleep 100\n")
    program.chmod(0o755)
    environment = {**cluster.environment, "CAIRN": str(program)}
    for count, code in (("0", 2), ("many", 2), ("100000", 1)):
        submit = [SCRIPTS / "submit", count, scratch / "refused.plan", scratch / "no.gpkg",
                  *world.arguments("odd")]
        refused = subprocess.run(submit, env=environment, cwd=cluster.folder, capture_output=True, text=True)
        expect(refused.returncode == code and not refused.stdout, f"submit {count}: {refused}")
        cluster.wait_for_jobs()
    expect(cluster.state("1") == {"CANCELLED"}, f"the job before a refused one: {cluster.state('1')}")


def check(cluster, world, scratch):
    sequential, spread, plan = scratch / "sequential.gpkg", scratch / "spread.gpkg", scratch / "odd.plan"
    world.make_map(sequential)
    shutil.copy(sequential, spread)
    output_of(world.cairn, "ingest", sequential, *world.arguments("odd"))
    cluster.environment["CAIRN"] = str(make_program(world, scratch))

    begin = time.monotonic()
    jobs = cluster.submit(SCRIPTS / "submit", NUM_TASKS, plan, spread, *world.arguments("odd"))
    cluster.wait_for_jobs()
    seconds = time.monotonic() - begin
    expect(cluster.state(jobs[1]) == {"COMPLETED", "FAILED"}, f"one task fails: {cluster.state(jobs[1])}")
    expect(cluster.state(jobs[2]) == {"CANCELLED"}, f"nothing is published: {cluster.state(jobs[2])}")
    expect(world.version(spread) == 2, "a failed task stops the publication")
    refused = subprocess.run([world.cairn, "publish", "--plan", plan, "--count", str(NUM_TASKS)],
                             capture_output=True, text=True)
    expect(refused.returncode == 4 and "--index 7" in refused.stderr, f"publish says {refused.stderr}")

    (scratch / "broken").unlink()
    again = cluster.submit("sbatch", "--parsable", "--array=7", SCRIPTS / "build.sbatch", plan, NUM_TASKS)
    publish = cluster.submit("sbatch", "--parsable", f"--dependency=afterok:{again[0]}",
                             SCRIPTS / "publish.sbatch", plan, NUM_TASKS)
    cluster.wait_for_jobs()
    expect(cluster.state(publish[0]) == {"COMPLETED"}, "the plan is published")
    output_of(world.cairn, "check", spread)
    expect_equal(spread, sequential)
    print(f"slurm: plan and {NUM_TASKS} tasks in {seconds:.1f} s; one failed and stopped the publication; "
          f"run again, the map is that of ingest")


def run_all():
    with tempfile.TemporaryDirectory() as folder:
        scratch = pathlib.Path(folder)
        world = World(sys.argv[1], scratch)
        (scratch / "slurm").mkdir()
        cluster = Cluster(scratch / "slurm")
        try:
            check_refused(cluster, world, scratch)
            check(cluster, world, scratch)
        finally:
            cluster.close()


def main():
    reason = why_not()
    if reason:
        print(f"skipped: {reason}")
        return SKIPPED
    try:
        run_all()
    except CannotRunError as error:
        print(f"skipped: {error}")
        return SKIPPED
    return 0


if __name__ == "__main__":
    sys.exit(main())
