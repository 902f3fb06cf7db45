#!/usr/bin/env python3
"""Fits the engine's EvidenceModel (engine/pose/evidence_model.h) to inliers of answers.

Reads files of `cairn eval --matches-csv`. The --right files come from queries that show places of the map. The
--chance files come from queries from elsewhere (`--elsewhere` or `--permute-descriptors`). Both must be made with
`--min-score -5`, so that weak poses count, too. Every --right file has the same weight; only its poses within 1 m
and 5 degrees are used. Their inliers are right or accidental. Expectation maximization decides which: it fits the
reprojection errors of right inliers by maximum likelihood, and the other traits by logistic regression against the
--chance inliers.

Needs python3 with numpy and scipy. The exit code is 2 if a file is missing or has no inlier.

Example:
  lab/peers/fit_evidence.py --right city.csv lund.csv --chance elsewhere.csv
"""

import argparse
import csv
import sys

try:
    import numpy
    from scipy.optimize import minimize
except ImportError as missing:
    print(f"{missing}: install python3-numpy and python3-scipy", file=sys.stderr)
    sys.exit(2)

MAX_ERROR_M, MAX_ERROR_DEG = 1.0, 5.0
NUM_ROUNDS = 12
ERROR_PX_AT_500, MIN_ERROR_PX = 4.0, 2.0  # PoseOptions::max_error_px.
COLUMNS = ("error_px", "keypoint_scale_px", "landmark_sigma_px", "sq_distance", "log_size",
           "orientation_rad", "azimuth_rad", "focal_px")
SIZE_OFFSET = 1.1  # EvidenceModel::size_offset.
START_ERROR = numpy.log([0.5, 0.1, 0.1, 1.5])
START_TRAITS = numpy.concatenate([numpy.log([2.0, 4.0, 1.0, 1.0, 0.5, 0.2, 3.0]), [6.0, 3.0]])


class FailedError(Exception):
    """A file is missing or has no data to fit."""


def read_inliers(path, only_right):
    """Returns the columns COLUMNS of each inlier and the number of its answer."""
    values, answers, names = [], [], {}
    try:
        with open(path, newline="", encoding="utf-8") as file:
            for row in csv.DictReader(file):
                if only_right and not (float(row["position_error_m"]) < MAX_ERROR_M
                                       and float(row["rotation_error_deg"]) < MAX_ERROR_DEG):
                    continue
                values.append([float(row[column]) for column in COLUMNS])
                answers.append(names.setdefault(row["name"], len(names)))
    except (OSError, KeyError, ValueError) as error:
        raise FailedError(f"{path}: {error}") from error
    if not values:
        raise FailedError(f"{path}: no inlier to fit to")
    inliers = dict(zip(COLUMNS, numpy.array(values).T))
    inliers["answer"] = numpy.array(answers)
    return inliers


def join(parts):
    """Returns the inliers of several files. All files have the same total weight."""
    first_answer, answers = 0, []
    for part in parts:
        answers.append(part["answer"] + first_answer)
        first_answer += part["answer"].max() + 1
    joined = {column: numpy.concatenate([part[column] for part in parts]) for column in COLUMNS}
    joined["answer"] = numpy.concatenate(answers)
    joined["weight"] = numpy.concatenate(
        [numpy.full(len(part["answer"]), 1.0 / (len(parts) * len(part["answer"])))
         for part in parts])
    return joined


def log_error_density(inliers, parameters):
    error, per_scale, share, freedom = numpy.exp(parameters)
    sq_scale = (error**2 + (per_scale * inliers["keypoint_scale_px"])**2 +
                (share * inliers["landmark_sigma_px"])**2)
    return (-numpy.log(2 * numpy.pi * sq_scale) -
            (freedom + 2) / 2 * numpy.log1p(inliers["error_px"]**2 / (freedom * sq_scale)))


def log_trait_ratio(inliers, parameters):
    distance, size, orientation, azimuth = numpy.exp(parameters[:4])
    size_scale, orientation_scale, azimuth_scale = numpy.exp(parameters[4:7])
    offset, orientation_offset = parameters[7:]
    of_size = numpy.where(numpy.isnan(inliers["log_size"]), -SIZE_OFFSET,
                          -size * numpy.log1p((inliers["log_size"] / size_scale)**2))
    known = inliers["orientation_rad"] >= 0
    of_orientation = orientation_offset - orientation * numpy.log1p(
        (inliers["orientation_rad"] / orientation_scale)**2)
    return (offset - distance * inliers["sq_distance"] + of_size +
            numpy.where(known, of_orientation, 0.0) -
            azimuth * numpy.log1p((inliers["azimuth_rad"] / azimuth_scale)**2))


def uniform_area(inliers):
    """Returns the area, in square pixels, of the disk within which a match is an inlier."""
    radius = numpy.maximum(MIN_ERROR_PX, ERROR_PX_AT_500 * inliers["focal_px"] / 500)
    widened = numpy.minimum(3 * inliers["landmark_sigma_px"], 3**0.5 * radius)
    return numpy.pi * (radius**2 + widened**2)


def fit_error(right, likely):
    def loss(parameters):
        return -(likely * right["weight"] * log_error_density(right, parameters)).sum()
    return minimize(loss, START_ERROR, method="BFGS").x


def fit_traits(right, likely, chance, start):
    weight = likely * right["weight"]

    def loss(parameters):
        of_right = numpy.logaddexp(0, -log_trait_ratio(right, parameters))
        of_chance = numpy.logaddexp(0, log_trait_ratio(chance, parameters))
        held = 1e-3 * ((parameters - START_TRAITS)**2).sum()
        return (weight * of_right).sum() / weight.sum() + (chance["weight"] * of_chance).sum() + held
    return minimize(loss, start, method="BFGS").x


def probabilities(right, likely, error, traits):
    """Returns the probability that each inlier is right. Each answer has its own share of right ones."""
    log_ratio = (log_error_density(right, error) + numpy.log(uniform_area(right)) +
                 log_trait_ratio(right, traits))
    count = numpy.bincount(right["answer"])
    for _ in range(5):
        share = numpy.clip(numpy.bincount(right["answer"], likely) / count, 0.02, 0.98)
        odds = (share / (1 - share))[right["answer"]] * numpy.exp(numpy.clip(log_ratio, -50, 50))
        likely = odds / (1 + odds)
    return likely


def fit(right, chance):
    likely, traits = numpy.full(len(right["weight"]), 0.8), START_TRAITS
    for _ in range(NUM_ROUNDS):
        error = fit_error(right, likely)
        traits = fit_traits(right, likely, chance, traits)
        likely = probabilities(right, likely, error, traits)
    return error, traits, likely


def print_model(error, traits):
    names = ("error_px", "error_per_scale", "landmark_share", "error_degrees_of_freedom")
    for name, value in zip(names, numpy.exp(error)):
        print(f"{name:26} {value:.3f}")
    weights, scales = numpy.exp(traits[:4]), numpy.exp(traits[4:7])
    print(f"{'offset':26} {traits[7]:.2f}")
    print(f"{'distance_weight':26} {weights[0]:.2f}")
    for i, name in enumerate(("size", "orientation", "azimuth")):
        print(f"{name:26} {{{weights[i + 1]:.2f}, {scales[i]:.3f}}}")
    print(f"{'orientation_offset':26} {traits[8]:.2f}")


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--right", required=True, nargs="+", metavar="CSV")
    parser.add_argument("--chance", required=True, nargs="+", metavar="CSV")
    arguments = parser.parse_args()
    right = join([read_inliers(path, only_right=True) for path in arguments.right])
    chance = join([read_inliers(path, only_right=False) for path in arguments.chance])
    error, traits, likely = fit(right, chance)
    print_model(error, traits)
    ratio = log_trait_ratio(chance, traits)
    print(f"\nmean log ratio of traits: right "
          f"{numpy.average(log_trait_ratio(right, traits), weights=likely * right['weight']):.2f}, "
          f"chance {numpy.average(ratio, weights=chance['weight']):.2f}; mean ratio of chance "
          f"{numpy.average(numpy.exp(ratio), weights=chance['weight']):.2f} (1 is right)")


if __name__ == "__main__":
    try:
        main()
    except FailedError as failure:
        print(failure, file=sys.stderr)
        sys.exit(2)
