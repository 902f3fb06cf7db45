#!/usr/bin/env python3
"""Spreads an ingest over tasks that are killed at random, over two publishers at a time, and over the tasks
of the Kubernetes job, and compares the maps with that of `cairn ingest`.

Usage: check_array.py BUILD_FOLDER [--kills N]
"""

import argparse
import os
import pathlib
import random
import shutil
import signal
import subprocess
import tempfile
import time

try:
    import yaml
except ImportError:
    yaml = None

from array_world import World, expect, expect_equal, output_of

NUM_TASKS = 4
SEED = 7
KUBERNETES = pathlib.Path(__file__).resolve().parent.parent.parent / "deploy" / "kubernetes"


def build(world, plan, index, count=NUM_TASKS):
    return [world.cairn, "build-tiles", "--plan", str(plan), "--index", str(index), "--count", str(count)]


def unfinished(plan):
    return list((plan / "results").glob("*.part"))


def kill_tasks(world, plan, num_kills):
    """Kills `num_kills` tasks that it starts. Returns how many left an unfinished file."""
    chance = random.Random(SEED)
    trial = plan.with_suffix(".trial")
    shutil.copytree(plan, trial)
    begin = time.monotonic()
    output_of(*build(world, trial, 0))
    seconds = time.monotonic() - begin
    shutil.rmtree(trial)
    num_killed = num_unfinished = 0
    while num_killed < num_kills:
        for result in (plan / "results").iterdir():
            if not result.name.endswith(".part"):
                result.unlink()  # There shall be something to build.
        before = len(unfinished(plan))
        task = subprocess.Popen(build(world, plan, chance.randrange(NUM_TASKS)),
                                stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        time.sleep(chance.uniform(0.0, seconds))
        task.send_signal(signal.SIGKILL)
        num_killed += task.wait() == -signal.SIGKILL
        num_unfinished += len(unfinished(plan)) > before
    return num_unfinished


def check_kills(world, scratch, num_kills):
    sequential, spread, plan = scratch / "sequential.gpkg", scratch / "spread.gpkg", scratch / "odd.plan"
    world.make_map(sequential)
    shutil.copy(sequential, spread)
    output_of(world.cairn, "ingest", sequential, *world.arguments("odd"))
    output_of(world.cairn, "plan", spread, *world.arguments("odd"), "--out", plan)
    # A kill hardly ever meets the moment in which a file is written; this one did.
    tile = next((plan / "shards").iterdir()).name
    (plan / "results" / f"{tile}.0123456789abcdef.part").write_bytes(b"half a tile")
    num_unfinished = kill_tasks(world, plan, num_kills)
    refused = subprocess.run([world.cairn, "publish", "--plan", plan, "--count", str(NUM_TASKS)],
                             capture_output=True, text=True)
    expect(refused.returncode == 4 and "have no result" in refused.stderr, f"publish says {refused.stderr}")
    expect(world.version(spread) == 2, "an incomplete plan changes nothing")
    twice = [subprocess.Popen(build(world, plan, index % NUM_TASKS), stdout=subprocess.DEVNULL,
                              stderr=subprocess.DEVNULL)
             for index in range(2 * NUM_TASKS)]
    expect([task.wait() for task in twice] == [0] * len(twice), "tasks may be repeated, and run twice at a time")
    expect(not unfinished(plan), "what killed tasks left is removed")
    output_of(world.cairn, "publish", "--plan", plan)
    output_of(world.cairn, "check", spread)
    expect_equal(spread, sequential)
    expect(sorted(path.name for path in plan.iterdir()) == ["plan.json"], "shards and results are removed")
    print(f"kills: {num_kills} tasks killed, {num_unfinished + 1} unfinished files; the map is that of ingest")


def check_publishers(world, scratch):
    """Two plans of the same tiles are published at the same time."""
    target = scratch / "contested.gpkg"
    world.make_map(target)
    plans = []
    for name, first in (("one", 1), ("other", 3)):
        images = (world.folder / "odd.txt").read_text().split()[first::4]
        (world.folder / f"{name}.txt").write_text("\n".join(images) + "\n")
        plans.append(scratch / f"{name}.plan")
        output_of(world.cairn, "plan", target, *world.arguments(name), "--out", plans[-1])
        output_of(*build(world, plans[-1], 0, 1))
    publishers = [subprocess.Popen([world.cairn, "publish", "--plan", plan], stderr=subprocess.PIPE,
                                   stdout=subprocess.DEVNULL, text=True) for plan in plans]
    errors = [publisher.communicate()[1] for publisher in publishers]
    codes = [publisher.returncode for publisher in publishers]
    expect(sorted(codes) == [0, 4], f"one publisher wins: {codes} {errors}")
    loser = errors[codes.index(4)]
    tiles = [path.name for path in (plans[codes.index(4)] / "shards").iterdir()]
    expect("have changed since version 2" in loser and all(tile in loser for tile in tiles), loser)
    expect(world.version(target) == 3, "one version is published")
    output_of(world.cairn, "check", target)
    print("publishers: one of two won, the other named the tiles")


def job(name):
    """The specification of a job, the command of its container, and the environment that is no secret."""
    spec = yaml.safe_load((KUBERNETES / f"{name}.yaml").read_text())["spec"]
    container = spec["template"]["spec"]["containers"][0]
    environment = {variable["name"]: variable["value"]
                   for variable in container["env"] if "valueFrom" not in variable}
    return spec, container["command"] + container["args"], environment


def check_kubernetes(world, scratch):
    """Runs the commands of the jobs as Kubernetes would, with other paths."""
    sequential, spread = scratch / "sequential.gpkg", scratch / "kubernetes.gpkg"
    world.make_map(spread)
    own = {"PATH": f"{os.path.dirname(world.cairn)}:{os.environ['PATH']}", "MAP": str(spread),
           "PLAN": str(scratch / "kubernetes.plan")}

    def run(name, **more):
        _, command, environment = job(name)
        command = [part.replace("/shared/", f"{world.folder}/").replace(
            "--session monday", " ".join(world.arguments("odd")[6:])) for part in command]
        output_of(*command, env={**os.environ, **environment, **own, **more})

    spec, _, environment = job("build")
    expect(spec["completionMode"] == "Indexed", "the job is indexed")
    expect(int(environment["COUNT"]) == spec["completions"] == int(job("publish")[2]["COUNT"]),
           "COUNT is the number of completions")
    run("plan")
    for index in range(spec["completions"]):
        run("build", JOB_COMPLETION_INDEX=str(index))
    run("publish")
    expect_equal(spread, sequential)
    print(f"kubernetes: {spec['completions']} tasks of the job made the map of ingest")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("build")
    parser.add_argument("--kills", type=int, default=50)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        scratch = pathlib.Path(folder)
        world = World(arguments.build, scratch)
        check_kills(world, scratch, arguments.kills)
        check_publishers(world, scratch)
        if yaml is None:
            print("skipped: python3-yaml is not installed (scripts/install-dependencies --tests)")
        else:
            check_kubernetes(world, scratch)


if __name__ == "__main__":
    main()
