#!/usr/bin/env python3
"""Follows the commands of the pages for readers, on real photos: every block of shell commands must succeed. The links of
these pages must lead somewhere. The exit code is 77 if the photos are not there.

Usage: check_reader_pages.py BUILD_DIR
"""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

SKIPPED = 77
ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
LINKED_PAGES = ["README.md", "glossary.md", "when_it_does_not_localize.md", "from_hloc.md", "from_colmap.md",
                "using_the_library.md", "first_hour.md", "newcomers.md"]


def commands_of(page):
    blocks = re.findall(r"^```sh\n(.*?)^```", (ROOT / "docs" / page).read_text(), re.M | re.S)
    if not blocks:
        sys.exit(f"{page} has no commands")
    return blocks


def anchor_of(heading):
    return re.sub(r"[^\w\- ]", "", heading.strip().lower()).replace(" ", "-")


def check_links(page):
    folder = ROOT / "docs"
    for target in re.findall(r"\]\(([^)\s]+)\)", (folder / page).read_text()):
        if "://" in target:
            continue
        path, _, anchor = target.partition("#")
        linked = folder / path if path else folder / page
        if not linked.exists():
            sys.exit(f"{page} links to {target}, which is not there")
        if anchor and linked.suffix == ".md":
            headings = re.findall(r"^#+ (.*)$", linked.read_text(), re.M)
            if anchor not in map(anchor_of, headings):
                sys.exit(f"{page} links to {target}, but there is no such heading")


def prepare(folder, data):
    """A folder as the pages assume it: photos, a model with its database, a photo and lists."""
    shutil.copytree(data / "images", folder / "photos", copy_function=os.symlink)
    (folder / "sparse").mkdir()
    os.symlink(data / "colmap_model", folder / "sparse" / "0")
    shutil.copy(data / "database.db", folder / "database.db")
    os.chmod(folder / "database.db", 0o644)
    names = sorted(path.name for path in (folder / "photos").iterdir() if path.suffix == ".jpg")
    shutil.copy(folder / "photos" / names[0], folder / "photo.jpg")
    with open(folder / "queries_with_intrinsics.txt", "w") as queries:
        for name in names[:3]:
            queries.write(f"{name} SIMPLE_PINHOLE 1024 768 996 512 384\n")


def follow(page, folder, environment):
    for block in commands_of(page):
        finished = subprocess.run(["bash", "-e", "-o", "pipefail", "-c", block], cwd=folder, env=environment, text=True,
                                  stdout=subprocess.PIPE, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL,
                                  timeout=250)
        if finished.returncode != 0:
            sys.exit(f"failed: {page}\n{block}\n{finished.stdout}")


def main():
    build = pathlib.Path(sys.argv[1]).resolve()
    for page in LINKED_PAGES:
        check_links(page)
    data = pathlib.Path(os.environ.get("CAIRN_TEST_DATA", ROOT / ".." / "shared" / "data")) / "street_lund"
    if not data.exists():
        print(f"test data not found: {data} (set CAIRN_TEST_DATA)")
        sys.exit(SKIPPED)
    environment = dict(os.environ, PATH=f"{build / 'cli'}:{os.environ['PATH']}", CAIRN_BUILD=str(build))
    with tempfile.TemporaryDirectory(prefix="cairn_pages_") as name:
        # Pages that begin with the same map have folders of their own.
        folder, other_folder, first_folder = (pathlib.Path(name) / each for each in "abc")
        for each in folder, other_folder, first_folder:
            each.mkdir()
            prepare(each, data)
        for page in ["from_hloc.md", "when_it_does_not_localize.md", "using_the_library.md"]:
            follow(page, folder, environment)
        follow("from_colmap.md", other_folder, environment)
        follow("first_hour.md", first_folder, environment)
        lines = (folder / "results.txt").read_text().splitlines()
        if not lines or any(len(line.split()) != 8 for line in lines):
            sys.exit(f"results.txt is not what hloc reads: {lines}")


if __name__ == "__main__":
    main()
