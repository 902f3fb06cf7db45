"""cairn.ingest and cairn.map: the keywords of the verbs of these names, with their defaults."""

import os
from typing import Any, Callable, Mapping, Optional, Sequence, Union

from cairn import _cairn

Path = Union[str, "os.PathLike[str]"]
Options = Union[Mapping[str, Any], Path, None]
Progress = Optional[Callable[[str, int, int], object]]


def ingest(
    path: Path,
    *,
    model: Path,
    database: Path,
    gps: bool = False,
    georef: Optional[Path] = None,
    control: Optional[Path] = None,
    frame: Optional[str] = None,
    origin: Optional[Sequence[float]] = None,
    gps_accuracy_m: float = 5.0,
    height: Optional[str] = None,
    camera_height_m: Optional[float] = None,
    photos: Optional[Path] = None,
    images: Optional[Path] = None,
    session: Optional[str] = None,
    recorded_at: Optional[str] = None,
    apart: bool = False,
    force: bool = False,
    wait_s: float = 30.0,
    threads: int = 0,
    archive: Optional[Path] = None,
    options: Options = None,
    progress: Progress = None,
) -> "_cairn.Summary":
    """Adds a reconstruction of COLMAP to a map as one session, as `cairn ingest` does.

    path: the map, which exists (cairn.init).
    model, database: the folder of the sparse model and COLMAP's database.
    gps, georef: where the positions come from: the GPS priors of the database, or a CSV with
        image,lat_deg,lon_deg,h_m[,accuracy_m]. One of gps, georef, control and frame is needed.
    control: CSV of surveyed points that photos show, a row for each photo:
        point,lat_deg,lon_deg,h_m,image,x_px,y_px[,accuracy_m].
    frame, origin: the model stands on Earth already, in meters: 'ecef', or 'enu' at the origin
        (latitude, longitude, height above the ellipsoid), degrees and meters.
    gps_accuracy_m: 68 % radius of the GPS priors.
    height: 'ellipsoid' or 'msl', the reference of the heights; None: msl for gps, else ellipsoid.
    camera_height_m: height of cameras whose positions have none.
    photos: folder of the photos, whose EXIF says how they were held.
    images: file with the names of the images to use.
    session: its name; a session of the same name is replaced. None: the database's folder.
    recorded_at: when the photos were taken, e.g. '2026-01-31T12:00:00Z'.
    apart, force, wait_s, archive: as --apart, --force, --wait, --archive.
    threads: 0 means all cores. The result does not depend on it.
    progress: called with (phase, done, total) on the calling thread. If it raises, or at Ctrl-C,
        the work ends at its next step, and the map is as before unless the session was just being
        published.
    """
    return _cairn._ingest(
        path, model=model, database=database, gps=gps, georef=georef, control=control,
        frame=frame, origin=origin, gps_accuracy_m=gps_accuracy_m, height=height, camera_height_m=camera_height_m,
        photos=photos, images=images, session=session, recorded_at=recorded_at, apart=apart,
        force=force, wait_s=wait_s, threads=threads, archive=archive, options=options,
        progress=progress)


def map(
    path: Path,
    photos: Union[Path, Sequence[Path]],
    *,
    gps: Optional[Path] = None,
    gps_accuracy_m: float = 5.0,
    height: Optional[str] = None,
    camera_height_m: Optional[float] = None,
    cameras: Sequence["_cairn.Camera"] = (),
    work: Optional[Path] = None,
    session: Optional[str] = None,
    recorded_at: Optional[str] = None,
    apart: bool = False,
    force: bool = False,
    wait_s: float = 30.0,
    threads: int = 0,
    archive: Optional[Path] = None,
    options: Options = None,
    progress: Progress = None,
) -> "_cairn.Summary":
    """Makes a map from photos, or adds photos to one, as `cairn map` does.

    path: the map; it is made if there is none.
    photos: a folder, or a sequence of folders and files. Several folders without a `session` are a
        session each, with the names of the folders; they are mapped one by one and join the map in
        an order that does not depend on that of the sequence. A folder that makes no map and a
        session that the map refuses keep no other out: `sessions` of the summary tells each, with
        its `problem`. If the map takes none, an error says why.
    gps: CSV of positions, image,lat_deg,lon_deg,h_m[,accuracy_m]; None: the EXIF of the photos.
    gps_accuracy_m: 68 % radius of EXIF positions that state none.
    height: 'ellipsoid' or 'msl', the reference of the heights; None: msl for EXIF, else ellipsoid.
    cameras: calibrated cameras, for photos of their sizes. Others are estimated.
    work: a folder that keeps the results of stages, with which a run that was ended goes on.
    session: the name of one session of all photos; None: the name of the folder, for each folder.
    The rest is as for cairn.ingest.
    """
    return _cairn._map(
        path, photos, gps=gps, gps_accuracy_m=gps_accuracy_m, height=height,
        camera_height_m=camera_height_m, cameras=cameras, work=work, session=session,
        recorded_at=recorded_at, apart=apart, force=force, wait_s=wait_s, threads=threads,
        archive=archive, options=options, progress=progress)
