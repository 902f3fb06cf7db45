#!/usr/bin/env python3
"""Fuses a recorded walk with a map: fuse_walk.py RECORDING MAP.gpkg

A recording is a folder with
    rig.json        camera: {model, size, params}, cam_from_imu: 4 x 4, origin: [lat, lon, h]
    imu.csv         timestamp_ns, angular rate x, y, z (rad/s), specific force x, y, z (m/s^2)
    tracks.csv      timestamp_ns, track id, x, y (pixels): what a tracker followed
    frames/         <timestamp_ns>.npz with keypoints and descriptors of frames to ask the map with
Prints the pose of the inertial unit in east-north-up at the origin, a line for each frame.
"""

import json
import pathlib
import sys

import numpy as np

import cairn


def main(recording: pathlib.Path, map_path: pathlib.Path) -> None:
    rig = json.loads((recording / "rig.json").read_text())
    camera = cairn.Camera(**rig["camera"])
    client = cairn.FusionClient(camera, np.array(rig["cam_from_imu"]), rig["origin"],
                                options=rig.get("options", {}))
    imu = np.loadtxt(recording / "imu.csv", delimiter=",")
    tracks = np.loadtxt(recording / "tracks.csv", delimiter=",")
    imu_times = imu[:, 0].astype(np.int64)
    begin = 0
    with cairn.Map(map_path) as town:
        for time_ns in np.unique(tracks[:, 0].astype(np.int64)):
            end = int(np.searchsorted(imu_times, time_ns, side="right"))
            client.add_imu(imu_times[begin:end], imu[begin:end, 1:4].copy(),
                           imu[begin:end, 4:7].copy())
            begin = end
            seen = tracks[tracks[:, 0] == time_ns]
            client.add_frame(int(time_ns), seen[:, 1].astype(np.uint64), seen[:, 2:4].copy())
            frame = recording / "frames" / f"{time_ns}.npz"
            query = client.poll_query() if frame.exists() else None
            if query is not None:
                features = np.load(frame)
                client.submit(query, town.localize(
                    cairn.Features(features["keypoints"], features["descriptors"]), camera,
                    prior=rig["origin"][:2], accuracy_m=50, gravity=query.gravity))
            estimate = client.latest()
            pose = estimate.global_from_imu
            where = "" if pose is None else " ".join(f"{x:.3f}" for x in pose[:3, 3])
            print(f"{time_ns} {estimate.mode} {where}")


if __name__ == "__main__":
    main(pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2]))
