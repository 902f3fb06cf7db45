"""cairn.evaluate and what a report shows of itself."""

from typing import Any, NamedTuple, Optional

from cairn import _cairn
from cairn._building import Options, Path, Progress


class Recall(NamedTuple):
    """The share of all queries that are answered within a threshold, with a 95 % interval."""

    position_m: float
    rotation_rad: float
    value: float
    low: float
    high: float


def evaluate(
    path: Path,
    queries: Optional[Path] = None,
    *,
    model: Optional[Path] = None,
    database: Optional[Path] = None,
    gps: bool = False,
    georef: Optional[Path] = None,
    images: Optional[Path] = None,
    image_dir: Optional[Path] = None,
    with_prior: bool = True,
    with_gravity: bool = True,
    given_priors: bool = False,
    threads: int = 0,
    options: Options = None,
    progress: Progress = None,
) -> "_cairn.Report":
    """Measures how well a map localizes queries with known poses, as `cairn eval` does.

    queries: a query list (docs/formats/query_list_v1.md); or
    model, database: a COLMAP model whose images that the map does not have are the queries. It is
        placed by the images that it shares with the map, or else by gps or georef. Without a
        database, the features are extracted from the photos in image_dir.
    images: file with the names of the images to ask; image_dir: folder of the photos.
    with_prior, with_gravity: whether queries have a rough position and gravity, made from the true
        poses with noise (options: {'noise': ...}); given_priors: those of the list, unchanged.
    threads: 0 means all cores. progress: as for cairn.ingest.
    """
    return _cairn._evaluate(
        path, queries=queries, model=model, database=database, gps=gps, georef=georef,
        images=images, image_dir=image_dir, with_prior=with_prior, with_gravity=with_gravity,
        given_priors=given_priors, threads=threads, options=options, progress=progress)


def _to_pandas(self: "_cairn.Report") -> Any:
    """A pandas.DataFrame with a row for each query. Needs pandas."""
    import pandas

    return pandas.DataFrame({
        "localized": self.localized,
        "position_error_m": self.position_error_m,
        "rotation_error_rad": self.rotation_error_rad,
        "position_accuracy_m": self.position_accuracy_m,
        "confidence": self.confidence,
        "score": self.score,
        "seconds": self.seconds,
    }, index=self.names)


def _plot(self: "_cairn.Report", axes: Any = None) -> Any:
    """Draws the share of queries within each position error, and returns the axes. Needs
    matplotlib. axes: where to draw; None: a new figure."""
    import numpy as np

    if axes is None:
        from matplotlib import pyplot

        axes = pyplot.figure().add_subplot()
    errors = np.sort(self.position_error_m[self.localized])
    shares = np.arange(1, len(errors) + 1) / max(1, self.num_queries)
    axes.step(errors, shares, where="post")
    axes.set_xscale("log")
    axes.set_ylim(0.0, 1.0)
    axes.set_xlabel("position error [m]")
    axes.set_ylabel("share of queries")
    axes.set_title(f"{self.num_localized} of {self.num_queries} queries localized")
    return axes


_cairn.Report.to_pandas = _to_pandas
_cairn.Report.plot = _plot
