"""Cairn: where exactly was this photo taken, and in which direction?

    import cairn
    with cairn.Map("town.gpkg") as map:
        result = map.localize("photo.jpg", prior=(55.6985, 13.1950))
        print(result.geopose.lat_deg, result.geopose.lon_deg, result.confidence)

Angles named _deg are degrees, others radians; lengths are meters. Frames: cam is x right, y down,
z forward; enu is east-north-up; a_from_b is a 4 x 4 matrix that takes points from b to a.
"""

from cairn._building import ingest, map
from cairn._cairn import (
    Camera,
    Client,
    Error,
    Features,
    FusionClient,
    FusionEstimate,
    FusionQuery,
    GeoPose,
    Inliers,
    Map,
    Query,
    Report,
    Result,
    ResultIterator,
    Summary,
    __version__,
    extract,
    init,
    set_log_level,
)
from cairn._report import Recall, evaluate
from cairn._support import AnswerReport, Rows, Session

__all__ = [
    "AnswerReport",
    "Camera",
    "Client",
    "Error",
    "Features",
    "FusionClient",
    "FusionEstimate",
    "FusionQuery",
    "GeoPose",
    "Inliers",
    "Map",
    "Query",
    "Recall",
    "Report",
    "Result",
    "ResultIterator",
    "Rows",
    "Session",
    "Summary",
    "__version__",
    "evaluate",
    "extract",
    "ingest",
    "init",
    "map",
    "set_log_level",
]
