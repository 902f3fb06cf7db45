#!/usr/bin/env python3
"""Draws how true confidences and radii are, from the answers that hard_queries.py keeps.

    lab/report/plot_calibration.py ANSWERS.csv [ANSWERS.csv ...] --output PICTURE.svg

The first chart has the share of right answers over the confidence that they state, in bins of a tenth; a bin of
fewer than five answers joins the next. The second has the share of right answers whose position is within a
multiple of the 68 % radius that they state. A right answer is within 3 m and 10 degrees. Bars and bands are 95 %
intervals (Wilson). Each kind of query has a color. Queries of elsewhere (--kinds elsewhere) are wrong answers of
the known camera.
"""

import argparse
import csv
import math
import pathlib
import sys

RIGHT_M, RIGHT_DEG = 3.0, 10.0
NUM_BINS, MIN_IN_BIN = 10, 5
MAX_MULTIPLE = 4.0
# Okabe and Ito; each kind has a word in the legend, too.
COLORS = {"known": "#0072b2", "free": "#00795a", "unknown": "#b35900"}
WORDS = {"known": "known camera", "free": "known camera, no gravity", "unknown": "unknown camera"}
WIDTH, HEIGHT, LEFT, TOP, SIDE = 880, 440, 70, 70, 320
INK, PALE, GRID = "#202428", "#6b7178", "#d9dcdf"


def is_right(row):
    return (not row["kind"].startswith("elsewhere") and float(row["position_error_m"]) < RIGHT_M and
            float(row["rotation_error_deg"]) < RIGHT_DEG)


def wilson(num, count):
    """The share and its 95 % interval."""
    z, share = 1.96, num / count
    middle = (share + z * z / (2 * count)) / (1 + z * z / count)
    half = z / (1 + z * z / count) * math.sqrt(share * (1 - share) / count + z * z / (4 * count * count))
    return share, max(0.0, middle - half), min(1.0, middle + half)


def confidence_bins(rows):
    """(mean confidence, share, low, high, number) of each bin."""
    bins, pending = [], []
    for number in range(NUM_BINS):
        pending += [row for row in rows
                    if min(NUM_BINS - 1, int(NUM_BINS * float(row["confidence"]))) == number]
        if len(pending) >= MIN_IN_BIN or (pending and number == NUM_BINS - 1):
            mean = sum(float(row["confidence"]) for row in pending) / len(pending)
            bins.append((mean, *wilson(sum(map(is_right, pending)), len(pending)), len(pending)))
            pending = []
    return bins


def radius_curve(rows):
    """(multiple, share, low, high) in steps."""
    multiples = [float(row["position_error_m"]) / float(row["position_accuracy_m"])
                 for row in rows if is_right(row)]
    steps = [MAX_MULTIPLE * i / 40 for i in range(41)]
    return [(step, *wilson(sum(m <= step for m in multiples), len(multiples))) for step in steps]


class Chart:
    """A square chart whose y axis is a share."""

    def __init__(self, left, title, max_x, ticks):
        self.left, self.max_x = left, max_x
        self.marks = [f'<text x="{left}" y="{TOP - 34}" fill="{INK}" font-weight="bold">{title}</text>']
        for share in (0.0, 0.2, 0.4, 0.6, 0.8, 1.0):
            self.line(0.0, share, max_x, share, GRID)
            self.text(left - 8, self.y(share) + 4, f"{share:.1f}", "end")
        for tick in ticks:
            self.line(tick, 0.0, tick, 1.0, GRID)
            self.text(self.x(tick), TOP + SIDE + 18, f"{tick:g}", "middle")

    def x(self, value):
        return self.left + SIDE * value / self.max_x

    @staticmethod
    def y(share):
        return TOP + SIDE * (1.0 - share)

    def text(self, x, y, text, anchor="start", color=PALE):
        self.marks.append(f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" fill="{color}">{text}</text>')

    def line(self, x0, y0, x1, y1, color, style=""):
        self.marks.append(f'<line x1="{self.x(x0):.1f}" y1="{self.y(y0):.1f}" x2="{self.x(x1):.1f}" '
                          f'y2="{self.y(y1):.1f}" stroke="{color}" {style}/>')

    def dashed(self, x0, y0, x1, y1):
        self.line(x0, y0, x1, y1, PALE, 'stroke-dasharray="4 4"')

    def bar(self, point, color):
        x, share, low, high, number = point
        self.line(x, low, x, high, color, 'stroke-width="2"')
        self.marks.append(f'<circle cx="{self.x(x):.1f}" cy="{self.y(share):.1f}" '
                          f'r="{2.0 + min(4.0, math.log10(number) * 1.6):.1f}" fill="{color}"/>')

    def curve(self, points, color):
        def path(values):
            return " ".join(f"{self.x(x):.1f},{self.y(y):.1f}" for x, y in values)
        band = [(p[0], p[3]) for p in points] + [(p[0], p[2]) for p in reversed(points)]
        self.marks.append(f'<polygon points="{path(band)}" fill="{color}" opacity="0.18"/>')
        self.marks.append(f'<polyline points="{path([(p[0], p[1]) for p in points])}" fill="none" '
                          f'stroke="{color}" stroke-width="2"/>')


def draw(rows_of_kind):
    confidences = Chart(LEFT, "Share of right answers", 1.0, (0.0, 0.2, 0.4, 0.6, 0.8, 1.0))
    radii = Chart(LEFT + SIDE + 110, "Share within the radius", MAX_MULTIPLE, (0.0, 1.0, 2.0, 3.0, 4.0))
    confidences.dashed(0.0, 0.0, 1.0, 1.0)
    confidences.text(LEFT + SIDE / 2, TOP + SIDE + 38, "stated confidence", "middle")
    radii.dashed(0.0, 0.68, MAX_MULTIPLE, 0.68)
    radii.dashed(1.0, 0.0, 1.0, 1.0)
    radii.text(radii.left + SIDE / 2, TOP + SIDE + 38, "multiple of the stated 68 % radius", "middle")
    for i, (kind, rows) in enumerate(rows_of_kind.items()):
        for point in confidence_bins(rows):
            confidences.bar(point, COLORS[kind])
        radii.curve(radius_curve(rows), COLORS[kind])
        num_right = sum(map(is_right, rows))
        confidences.text(LEFT + 285 * i, TOP - 12, f"● {WORDS[kind]}: {num_right} of {len(rows)}",
                         color=COLORS[kind])
    return "\n".join([
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" width="{WIDTH}" '
        'font-family="system-ui, sans-serif" font-size="13" role="img" '
        'aria-label="Right answers over stated confidence, and errors over stated radius">',
        f'<rect width="{WIDTH}" height="{HEIGHT}" fill="#fcfbfa"/>',
        *confidences.marks, *radii.marks, "</svg>", ""])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("answers", nargs="+", type=pathlib.Path)
    parser.add_argument("--output", required=True, type=pathlib.Path)
    arguments = parser.parse_args()
    rows_of_kind = {}
    for path in arguments.answers:
        with open(path, newline="", encoding="utf-8") as file:
            for row in csv.DictReader(file):
                kind = row["kind"].replace("elsewhere-free", "free").replace("elsewhere", "known")
                if row["localized"] == "1" and kind in COLORS:
                    rows_of_kind.setdefault(kind, []).append(row)
    rows_of_kind = {kind: rows_of_kind[kind] for kind in COLORS if any(map(is_right, rows_of_kind.get(kind, [])))}
    if not rows_of_kind:
        sys.exit("no answer of a known kind is right")
    arguments.output.write_text(draw(rows_of_kind), encoding="utf-8")


if __name__ == "__main__":
    main()
