#!/usr/bin/env python3
"""Measures the accuracy and the query time of a build and writes both into docs/figures.md.

    lab/report/write_figures.py --data DIR [--only accuracy|bench] [--build build/release]

DIR is a folder with real data, as CAIRN_TEST_DATA names it. The page has one block for each table, between
<!-- report:begin NAME --> and <!-- report:end NAME -->. The script replaces the block and names the commit, the
date and the processor. The bench takes ten minutes and wants an idle machine.
"""

import argparse
import csv
import datetime
import json
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "figures.md"


def run(*command):
    """Returns the standard output of a command; ends the script if the command fails."""
    result = subprocess.run([str(word) for word in command], capture_output=True, text=True, check=False)
    if result.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}\nexit code {result.returncode}\n{result.stderr}")
    return result.stdout


def provenance():
    """One line: processor, commit, date."""
    processor = re.search(r"model name\s*: (.*)", pathlib.Path("/proc/cpuinfo").read_text())
    flags = pathlib.Path("/proc/cpuinfo").read_text()
    vectors = "AVX-512" if "avx512f" in flags else "AVX2" if "avx2" in flags else "no AVX2"
    commit = run("git", "-C", ROOT, "describe", "--always", "--dirty").strip()
    name = processor.group(1) if processor else "unknown processor"
    return f"{name} with {vectors}; commit `{commit}`, {datetime.date.today()}."


def interval(value, scale=1.0, digits=4):
    numbers = [scale * value[key] for key in ("value", "low", "high")]
    return "{:.{d}f} [{:.{d}f}, {:.{d}f}]".format(*numbers, d=digits)


class Accuracy:
    """Maps of some photos of a drive or walk, asked for the others."""

    def __init__(self, cairn, data, scratch):
        self.cairn, self.data, self.scratch = cairn, data, scratch

    def table(self):
        kitti = self.data / "kitti_vo_2x51"
        with open(kitti / "georef_seq1.csv", newline="", encoding="utf-8") as file:
            kitti_names = [row["image"] for row in csv.DictReader(file)]
        lund = self.data / "street_lund"
        lund_names = sorted(path.name for path in (lund / "images").glob("*.jpg"))
        rows = self.rows(
            "KITTI drive, 60 m", kitti_names[::2],
            ["--model", kitti / "colmap_model_seq1", "--database", kitti / "database_seq1.db"],
            ["--georef", kitti / "georef_seq1.csv"], kitti / "KITTI_sequence_1" / "image_l")
        rows += self.rows(
            "Lund, phone photos along 171 m", [name for i, name in enumerate(lund_names) if i % 4 != 3],
            ["--model", lund / "colmap_model", "--database", lund / "database.db"], ["--gps"], lund / "images")
        head = ["| data | map | queries | answered | right | median position error | median rotation error | bytes a landmark |",
                "|---|---|---|---|---|---|---|---|"]
        return "\n".join(head + rows)

    def rows(self, name, mapped, model, positions, images):
        stem = name.split()[0].lower().strip(",")
        town, names = self.scratch / f"{stem}.gpkg", self.scratch / f"{stem}.txt"
        names.write_text("\n".join(mapped) + "\n", encoding="utf-8")
        run(self.cairn, "init", town)
        run(self.cairn, "ingest", town, *model, *positions, "--images", names, "--session", "one")
        report = json.loads(run(self.cairn, "info", town, "--json"))
        bytes_a_landmark = report["payloadBytes"] / report["landmarks"]
        rows = []
        for kind, extra in (("features", []), ("photos", ["--features", "extract", "--image-dir", images])):
            out = self.scratch / f"{stem}_{kind}.json"
            run(self.cairn, "eval", town, *model, *extra, "--json", out)
            answers = json.loads(out.read_text(encoding="utf-8"))
            right = next(recall for recall in answers["recalls"] if recall["position_m"] == 3)
            rows.append(
                f"| {name}, {kind} | {len(mapped)} photos | {answers['num_queries']} | {answers['num_localized']} "
                f"| {round(right['value'] * answers['num_queries'])} "
                f"| {interval(answers['median_position_error_m'])} m "
                f"| {interval(answers['median_rotation_error_deg'], digits=3)}° | {bytes_a_landmark:.1f} |")
        return rows


def bench_table(lab):
    """The medians of `cairn-lab bench` for both kinds of index."""
    wanted = [("matching", "matching"), ("voting", "voting"), ("pose", "pose"), ("whole query", "total")]
    columns = {}
    for index in ("random_grids", "inverted_lists"):
        lines = run(lab, "bench", "--index", index).splitlines()
        columns[index] = lines
    rows = ["| | random grids (the default) | inverted lists |", "|---|---|---|"]
    for label, stage in wanted:
        cells = []
        for lines in columns.values():
            line = next(line for line in lines if line.startswith(stage))
            cells.append(f"{float(line.split()[1]):.1f} ms")
        rows.append(f"| {label} | {cells[0]} | {cells[1]} |")
    others = [[line for line in lines if ":" in line or "  " in line and not re.match(r"\w+ +[\d.]+ +[\d.]+", line)]
              for lines in columns.values()]
    for first, second in zip(*others):
        label, cell = re.split(r"\s{2,}|: ", first.strip(), maxsplit=1) if re.search(r"\s{2,}|: ", first.strip()) else (None, None)
        if label and label == re.split(r"\s{2,}|: ", second.strip(), maxsplit=1)[0]:
            rows.append(f"| {label} | {cell.strip()} | {re.split(r'[ ]{2,}|: ', second.strip(), maxsplit=1)[1].strip()} |")
    return "\n".join(rows)


def replace_block(name, text):
    page = PAGE.read_text(encoding="utf-8")
    pattern = re.compile(rf"(<!-- report:begin {name} -->\n).*?(<!-- report:end {name} -->)", re.S)
    if not pattern.search(page):
        sys.exit(f"{PAGE}: has no block '{name}'")
    block = f"{provenance()}\n\n{text}\n"
    PAGE.write_text(pattern.sub(lambda match: match.group(1) + block + match.group(2), page), encoding="utf-8")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=pathlib.Path, required=True)
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build" / "release")
    parser.add_argument("--only", choices=("accuracy", "bench"))
    arguments = parser.parse_args()
    if arguments.only != "bench":
        with tempfile.TemporaryDirectory() as scratch:
            cairn = arguments.build / "cli" / "cairn"
            replace_block("accuracy", Accuracy(cairn, arguments.data, pathlib.Path(scratch)).table())
    if arguments.only != "accuracy":
        replace_block("bench", bench_table(arguments.build / "lab" / "cli" / "cairn-lab"))


if __name__ == "__main__":
    main()
