#!/usr/bin/env python3
"""Compares `cairn` with COLMAP's image registrator on the same photos and features of one scene.

The photos of the scene are divided into folds. For each fold, all other photos make the map, and the
photos of the fold are queries for both programs:

  COLMAP  matches the query's features with every mapping photo (`matches_importer`) and registers the
          photo into the model without the queries (`image_registrator`);
  cairn   ingests the same model without the queries; `cairn eval` localizes the queries with the same
          features, a position prior (10 m) and the direction of gravity (1 degree off), as phones send
          them. --no-prior and --no-gravity leave these out.

Both programs use features of COLMAP's SIFT. The extraction of the features is not counted. Times are
processor times on one thread. For COLMAP, the time is that of the two programs above divided by the
number of queries; it includes the start of the programs. For cairn, the time is that of the stages of
each query, as `cairn eval` reports them; the time of the whole `cairn eval` is shown beside it.

Without --model, the scene is first reconstructed in --work (`feature_extractor`, `exhaustive_matcher`,
`mapper`). The model is placed at an arbitrary position on Earth, with a median depth of 20 m and the
mean up direction of the photos as the vertical. The reference pose of a query is the pose at which
COLMAP registers the query; its prior and gravity are drawn from this pose. Only for queries that COLMAP
does not register is the pose of the whole model used, because COLMAP misplaces photos when it maps:
20.jpg of street_lund is 45 m off its row.

Needs the packages `colmap` and `python3`. The exit code is 1 if cairn loses a photo that COLMAP
registers or takes more time than COLMAP, and 2 if a program or a file is missing.

Example:
  lab/peers/colmap_registrator.py --cairn build/release/cli/cairn --images lund/images \\
      --model lund/colmap_model --database lund/database.db --work /tmp/lund
"""

import argparse
import csv
import json
import math
import pathlib
import resource
import shutil
import sqlite3
import statistics
import subprocess
import sys

MAX_IMAGE_ID = 2147483647  # COLMAP's pair_id = id1 * MAX_IMAGE_ID + id2, id1 < id2.
MEDIAN_DEPTH_M = 20.0
MIN_MAPPING_PHOTOS = 3  # Needed to place a map on Earth.
ORIGIN_LAT_DEG, ORIGIN_LON_DEG, ORIGIN_H_M = 49.0, 8.4, 150.0


class MissingError(Exception):
    """A required program or file is missing."""


def parse_arguments():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cairn", required=True, help="the cairn binary")
    parser.add_argument("--images", required=True, type=pathlib.Path, help="folder of the photos")
    parser.add_argument("--model", type=pathlib.Path, help="COLMAP model of all photos")
    parser.add_argument("--database", type=pathlib.Path, help="COLMAP database of the model")
    parser.add_argument("--work", required=True, type=pathlib.Path, help="scratch folder")
    parser.add_argument("--folds", type=int, default=4, help="every n-th photo is a query")
    parser.add_argument("--no-prior", action="store_true", help="queries without position")
    parser.add_argument("--no-gravity", action="store_true", help="queries without gravity")
    parser.add_argument("--json", type=pathlib.Path, help="write the figures")
    arguments = parser.parse_args()
    if bool(arguments.model) != bool(arguments.database):
        parser.error("--model and --database belong together")
    return arguments


def run(command):
    """Runs a program and returns its processor time in seconds. An error contains its output."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    try:
        result = subprocess.run([str(part) for part in command], stdout=subprocess.PIPE,
                                stderr=subprocess.STDOUT, text=True, check=False)
    except FileNotFoundError as error:
        raise MissingError(f"{command[0]}: not found") from error
    if result.returncode != 0:
        raise RuntimeError(f"{' '.join(map(str, command))}\n{result.stdout[-2000:]}")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def reconstruct(images, work):
    """Makes the model and the database of all photos with COLMAP's defaults."""
    database, sparse = work / "database.db", work / "sparse"
    if not (sparse / "0").exists():
        sparse.mkdir(parents=True, exist_ok=True)
        database.unlink(missing_ok=True)
        run(["colmap", "feature_extractor", "--database_path", database, "--image_path", images,
             "--SiftExtraction.use_gpu", 0, "--ImageReader.camera_model", "SIMPLE_RADIAL"])
        run(["colmap", "exhaustive_matcher", "--database_path", database,
             "--SiftMatching.use_gpu", 0])
        run(["colmap", "mapper", "--database_path", database, "--image_path", images,
             "--output_path", sparse, "--Mapper.min_model_size", 3])
    return sparse / "0", database


def rotation_matrix(qw, qx, qy, qz):
    return [[1 - 2 * (qy * qy + qz * qz), 2 * (qx * qy - qw * qz), 2 * (qx * qz + qw * qy)],
            [2 * (qx * qy + qw * qz), 1 - 2 * (qx * qx + qz * qz), 2 * (qy * qz - qw * qx)],
            [2 * (qx * qz - qw * qy), 2 * (qy * qz + qw * qx), 1 - 2 * (qx * qx + qy * qy)]]


def read_model(model, text_folder):
    """{image name: (cam_from_world rotation, translation)} and {point id: xyz}, plus observations."""
    text_folder.mkdir(parents=True, exist_ok=True)
    run(["colmap", "model_converter", "--input_path", model, "--output_path", text_folder,
         "--output_type", "TXT"])
    images, seen = {}, {}
    lines = [line for line in (text_folder / "images.txt").read_text().splitlines()
             if not line.startswith("#")]
    for head, points in zip(lines[0::2], lines[1::2]):
        fields = head.split(maxsplit=9)
        name = fields[9]
        images[name] = (rotation_matrix(*map(float, fields[1:5])), list(map(float, fields[5:8])))
        seen[name] = [int(point) for point in points.split()[2::3] if point != "-1"]
    points = {}
    for line in (text_folder / "points3D.txt").read_text().splitlines():
        if not line.startswith("#"):
            fields = line.split(maxsplit=4)
            points[int(fields[0])] = list(map(float, fields[1:4]))
    return images, points, seen


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def unit(a):
    length = math.sqrt(dot(a, a))
    return [x / length for x in a]


def center(rotation, translation):
    return [-sum(rotation[row][column] * translation[row] for row in range(3))
            for column in range(3)]


def write_positions(model, work, path):
    """Writes camera positions at an arbitrary place on Earth as a CSV for `cairn --georef`."""
    images, points, seen = read_model(model, work / "text")
    depths = [dot(rotation[2], points[point]) + translation[2]
              for name, (rotation, translation) in images.items() for point in seen[name]]
    scale = MEDIAN_DEPTH_M / statistics.median(depths)
    up = unit([-sum(rotation[1][i] for rotation, _ in images.values()) for i in range(3)])
    east = unit(cross(up, [1, 0, 0] if abs(up[0]) < 0.9 else [0, 1, 0]))
    north = cross(up, east)
    centers = {name: center(*pose) for name, pose in images.items()}
    middle = [statistics.fmean(c[i] for c in centers.values()) for i in range(3)]
    # Radii of curvature of WGS84 at the origin.
    lat = math.radians(ORIGIN_LAT_DEG)
    a, e2 = 6378137.0, 0.00669437999014
    w = math.sqrt(1 - e2 * math.sin(lat) ** 2)
    meridian, normal = a * (1 - e2) / w ** 3 + ORIGIN_H_M, a / w + ORIGIN_H_M
    with open(path, "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["image", "lat_deg", "lon_deg", "h_m", "accuracy_m"])
        for name, c in sorted(centers.items()):
            offset = [scale * (c[i] - middle[i]) for i in range(3)]
            writer.writerow([
                name,
                f"{ORIGIN_LAT_DEG + math.degrees(dot(north, offset) / meridian):.10f}",
                f"{ORIGIN_LON_DEG + math.degrees(dot(east, offset) / (normal * math.cos(lat))):.10f}",
                f"{ORIGIN_H_M + dot(up, offset):.4f}", "0.1"])
    return sorted(images)


def database_without_queries_matches(database, queries, path):
    """Copies the database without the matches of the queries."""
    shutil.copyfile(database, path)
    connection = sqlite3.connect(path)
    ids = dict(connection.execute("SELECT name, image_id FROM images"))
    query_ids = {ids[name] for name in queries}
    for table in ("matches", "two_view_geometries"):
        doomed = [(pair,) for (pair,) in connection.execute(f"SELECT pair_id FROM {table}")
                  if pair // MAX_IMAGE_ID in query_ids or pair % MAX_IMAGE_ID in query_ids]
        connection.executemany(f"DELETE FROM {table} WHERE pair_id = ?", doomed)
    connection.commit()
    connection.close()


def run_colmap(arguments, model, database, mapped, queries, folder):
    """Returns the queries that COLMAP registers, the model with them, and the processor time."""
    pairs = folder / "pairs.txt"
    pairs.write_text("".join(f"{query} {name}\n" for query in queries for name in mapped))
    work_database = folder / "database.db"
    database_without_queries_matches(database, queries, work_database)
    map_model, out_model = folder / "map_model", folder / "out_model"
    for path in (map_model, out_model):
        path.mkdir(exist_ok=True)
    run(["colmap", "image_deleter", "--input_path", model, "--output_path", map_model,
         "--image_names_path", write_list(folder / "queries.txt", queries)])
    seconds = run(["colmap", "matches_importer", "--database_path", work_database,
                   "--match_list_path", pairs, "--match_type", "pairs",
                   "--SiftMatching.use_gpu", 0, "--SiftMatching.num_threads", 1])
    seconds += run(["colmap", "image_registrator", "--database_path", work_database,
                    "--input_path", map_model, "--output_path", out_model,
                    "--Mapper.num_threads", 1])
    registered = set(read_model(out_model, folder / "out_text")[0])
    return registered & set(queries), out_model, seconds


def write_list(path, names):
    path.write_text("\n".join(names) + "\n")
    return path


def run_cairn(arguments, model, database, positions, mapped, queries_of_model, folder):
    """Returns {query: its row of `cairn eval`} and the processor time of the whole program. The
    queries of each model in `queries_of_model` have their reference poses from that model."""
    map_path, rows_path = folder / "map.gpkg", folder / "answers.csv"
    map_path.unlink(missing_ok=True)
    run([arguments.cairn, "init", map_path])
    run([arguments.cairn, "ingest", map_path, "--model", model, "--database", database, "--georef",
         positions, "--images", write_list(folder / "mapped.txt", mapped)])
    options = ["--no-prior"] * arguments.no_prior + ["--no-gravity"] * arguments.no_gravity
    rows, seconds = {}, 0.0
    for reference, queries in queries_of_model:
        if queries:
            seconds += run([arguments.cairn, "eval", map_path, "--model", reference, "--database",
                            database, "--images", write_list(folder / "queried.txt", queries),
                            "--align-to", "map", "--csv", rows_path, *options])
            with open(rows_path, newline="") as file:
                rows |= {row["name"]: row for row in csv.DictReader(file)}
    return rows, seconds


def run_fold(arguments, model, database, positions, names, fold):
    queries = names[fold::arguments.folds]
    mapped = [name for name in names if name not in queries]
    folder = arguments.work / f"fold_{fold}"
    folder.mkdir(parents=True, exist_ok=True)
    registered, out_model, colmap_s = run_colmap(arguments, model, database, mapped, queries, folder)
    queries_of_model = [(out_model, sorted(registered)),
                        (model, sorted(set(queries) - registered))]
    rows, cairn_s = run_cairn(arguments, model, database, positions, mapped, queries_of_model,
                              folder)
    localized = {name for name, row in rows.items() if row["localized"] == "1"}
    right = {name for name in localized if float(rows[name]["position_error_m"]) <= 3.0
             and float(rows[name]["rotation_error_deg"]) <= 10.0}
    return {"queries": queries, "colmap": sorted(registered), "cairn": sorted(localized),
            "cairn_right": sorted(right), "lost": sorted(registered - right),
            "colmap_s": colmap_s, "cairn_program_s": cairn_s,
            "cairn_ms": [float(row["total_ms"]) for row in rows.values()],
            "reasons": {name: row["reason"] for name, row in rows.items() if name not in right}}


def report(folds):
    count = sum(len(fold["queries"]) for fold in folds)
    total = {key: sum(len(fold[key]) for fold in folds)
             for key in ("colmap", "cairn", "cairn_right", "lost")}
    colmap_ms = 1e3 * sum(fold["colmap_s"] for fold in folds) / count
    times = [ms for fold in folds for ms in fold["cairn_ms"]]
    cairn_ms = statistics.fmean(times)
    program_ms = 1e3 * sum(fold["cairn_program_s"] for fold in folds) / count
    print(f"queries                    {count}")
    print(f"COLMAP registers           {total['colmap']}")
    print(f"cairn localizes            {total['cairn']}, {total['cairn_right']} within 3 m, 10 deg")
    print(f"COLMAP's that cairn loses  {total['lost']}")
    for fold in folds:
        for name in fold["lost"]:
            print(f"  {name}: {fold['reasons'].get(name) or 'wrong'}")
    print(f"COLMAP per query           {colmap_ms:.1f} ms (matching and registration)")
    print(f"cairn per query            {cairn_ms:.1f} ms mean, {max(times):.1f} ms longest")
    print(f"cairn eval, whole program  {program_ms:.1f} ms per query (reads model, database, map)")
    print(f"ratio of the times         {cairn_ms / colmap_ms:.4f} "
          f"({program_ms / colmap_ms:.4f} with the whole program)")
    return {"queries": count, **total, "colmap_ms": colmap_ms, "cairn_ms": cairn_ms,
            "cairn_program_ms": program_ms, "folds": folds}


def main():
    arguments = parse_arguments()
    try:
        if not arguments.images.is_dir():
            raise MissingError(f"{arguments.images}: no such folder")
        arguments.work.mkdir(parents=True, exist_ok=True)
        model, database = arguments.model, arguments.database
        if model is None:
            model, database = reconstruct(arguments.images, arguments.work)
        positions = arguments.work / "positions.csv"
        names = write_positions(model, arguments.work, positions)
        num_queries = math.ceil(len(names) / arguments.folds)
        if len(names) - num_queries < MIN_MAPPING_PHOTOS:
            raise MissingError(f"{len(names)} photos make no map of at least {MIN_MAPPING_PHOTOS} "
                               f"and {num_queries} queries")
        figures = report([run_fold(arguments, model, database, positions, names, fold)
                          for fold in range(min(arguments.folds, len(names)))])
    except MissingError as error:
        print(f"colmap_registrator: {error}", file=sys.stderr)
        return 2
    if arguments.json:
        arguments.json.write_text(json.dumps(figures, indent=1) + "\n")
    return int(figures["lost"] > 0 or figures["cairn_ms"] >= figures["colmap_ms"])


if __name__ == "__main__":
    sys.exit(main())
