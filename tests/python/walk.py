"""Records a simulated walk down the street, as examples/python/fuse_walk.py reads it."""

import json
import os
import pathlib
import subprocess

import numpy as np

ORIGIN = [47.3769, 8.5417, 408.0]  # Of the street.
CAM_FROM_IMU = np.array([[0, -1, 0, 0], [0, 0, -1, 0], [1, 0, 0, 0], [0, 0, 0, 1.0]])
SECONDS, FRAME_HZ, IMU_HZ = 14.0, 10, 200


def pose_at(t):
    """Position in enu and yaw: at rest for two seconds, then 1.2 m/s with a swaying view."""
    s = np.maximum(t - 2.0, 0.0)
    ramp = s * s / (s + 1.5)  # Starts softly.
    position = np.stack([6.0 + 1.2 * ramp, 0.3 * np.sin(0.6 * ramp), 1.6 + 0.02 * np.sin(2 * ramp)],
                        axis=-1)
    return position, 0.12 * np.sin(0.7 * ramp)


def enu_from_imu(yaw):
    c, s = np.cos(yaw), np.sin(yaw)
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])


def inertial_samples():
    t = np.arange(0, SECONDS, 1 / IMU_HZ)
    h = 1e-3
    before, now, after = pose_at(t - h), pose_at(t), pose_at(t + h)
    acceleration = (before[0] - 2 * now[0] + after[0]) / h**2 + [0, 0, 9.81]
    rate = (after[1] - before[1]) / (2 * h)
    noise = np.random.default_rng(5)
    rows = np.zeros((len(t), 7))
    rows[:, 0] = np.round(1e9 * t)
    rows[:, 3] = rate
    for i in range(len(t)):
        rows[i, 4:7] = enu_from_imu(now[1][i]).T @ acceleration[i]
    rows[:, 1:4] += noise.normal(0, 1e-3, (len(t), 3))
    rows[:, 4:7] += noise.normal(0, 1e-2, (len(t), 3))
    return rows


def record(folder):
    """Writes the recording. Returns the true position in enu at each frame's time, ns."""
    times = np.arange(1, int(SECONDS * FRAME_HZ) - 1) / FRAME_HZ
    truth, lines = {}, []
    for t in times:
        position, yaw = pose_at(t)
        rotation = CAM_FROM_IMU[:3, :3] @ enu_from_imu(yaw).T
        lines.append(np.hstack([rotation, -(rotation @ position)[:, None]]).ravel())
        truth[int(round(1e9 * t))] = position
    np.savetxt(folder / "poses.txt", lines)
    raw = folder / "raw"
    raw.mkdir()
    subprocess.run([os.environ["CAIRN_MAKE_STREET"], raw, "--frames", folder / "poses.txt"],
                   check=True)
    (folder / "frames").mkdir()
    tracks = []
    for i, time_ns in enumerate(truth):
        keypoints = np.fromfile(raw / f"{i}.keypoints.f32", np.float32).reshape(-1, 4)
        descriptors = np.fromfile(raw / f"{i}.descriptors.f32", np.float32)
        landmarks = np.fromfile(raw / f"{i}.landmarks.i32", np.int32)
        for landmark, keypoint in zip(landmarks, keypoints):
            if landmark >= 0:
                tracks.append([time_ns, landmark, keypoint[0], keypoint[1]])
        if i % 10 == 0:
            np.savez(folder / "frames" / f"{time_ns}.npz", keypoints=keypoints,
                     descriptors=descriptors.reshape(len(keypoints), -1))
    np.savetxt(folder / "tracks.csv", tracks, delimiter=",", fmt=["%d", "%d", "%.6f", "%.6f"])
    np.savetxt(folder / "imu.csv", inertial_samples(), delimiter=",",
               fmt=["%d"] + ["%.9f"] * 6)
    rig = {"camera": {"model": "PINHOLE", "size": [640, 480], "params": [400, 400, 320, 240]},
           "cam_from_imu": CAM_FROM_IMU.tolist(), "origin": ORIGIN}
    pathlib.Path(folder / "rig.json").write_text(json.dumps(rig))
    return truth
