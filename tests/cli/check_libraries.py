#!/usr/bin/env python3
"""Compares the shared libraries of a program with docs/dependencies.md: check_libraries.py PROGRAM PAGE

Fails if the program loads a library whose package the section "What the program loads" does not name, if
the section names a package that it does not load, or if the packages are more than the section allows.
Exits with 77, which ctest takes for skipped, where there is no dpkg.
"""

import os
import re
import shutil
import subprocess
import sys

MAX_PACKAGES = 60


def packages_of(program):
    """The Debian packages of all libraries that the loader maps for the program."""
    text = subprocess.run(["ldd", program], check=True, capture_output=True, text=True).stdout
    # dpkg knows files by the path that their package has, which /lib -> /usr/lib may hide.
    names_of = {path: {path, os.path.realpath(path), os.path.realpath(path).removeprefix("/usr")}
                for path in re.findall(r"(?:=> |^\s+)(/\S+)", text, re.M)}
    # One call for all, since each reads the whole database; it fails, because not all names are known.
    found = subprocess.run(["dpkg", "-S", *sorted(set().union(*names_of.values()))], capture_output=True, text=True)
    package_of = {}
    for line in found.stdout.splitlines():
        packages, name = line.rsplit(": ", 1)
        package_of[name] = packages.split(":")[0]
    packages = set()
    for path, names in names_of.items():
        known = sorted(names & package_of.keys())
        if not known:
            sys.exit(f"{path} belongs to no package")
        packages.add(package_of[known[0]])
    return packages


def packages_on_page(page):
    """The packages in the first column of the tables of the section."""
    with open(page, encoding="utf-8") as file:
        section = file.read().split("## What the program loads")[1].split("\n## ")[0]
    rows = [line.split("|")[1] for line in section.splitlines() if line.startswith("| `")]
    return {name for row in rows for name in re.findall(r"`([^`]+)`", row)}


def main():
    program, page = sys.argv[1:]
    if not shutil.which("dpkg"):
        sys.exit(77)
    loaded, named = packages_of(program), packages_on_page(page)
    problems = [f"{package} is loaded, but not on the page" for package in sorted(loaded - named)]
    problems += [f"{package} is on the page, but not loaded" for package in sorted(named - loaded)]
    if len(loaded) > MAX_PACKAGES:
        problems.append(f"{len(loaded)} packages, at most {MAX_PACKAGES}")
    for problem in problems:
        print(problem, file=sys.stderr)
    sys.exit(f"check_libraries: {len(problems)} problems" if problems else 0)


if __name__ == "__main__":
    main()
