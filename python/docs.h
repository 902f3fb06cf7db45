// The docstrings of the module: shapes, units, frames. docs/python.md is the page for readers.
#ifndef CAIRN_PYTHON_DOCS_H_
#define CAIRN_PYTHON_DOCS_H_

namespace cairn::python::docs {

inline constexpr char kCamera[] = R"(Camera(model, size, params, *, focal_sigma=None)

Intrinsics of a camera, as COLMAP writes them.

model: 'SIMPLE_PINHOLE', 'PINHOLE', 'SIMPLE_RADIAL', 'RADIAL', 'OPENCV', 'FULL_OPENCV',
    'OPENCV_FISHEYE', 'FOV' and the others of COLMAP that the error message lists.
size: (width, height) of its images, pixels.
params: the parameters in COLMAP's order, pixels. (0.5, 0.5) is the middle of the first pixel.
focal_sigma: relative standard deviation of the focal length, in [1e-4, 0.5]. The focal length is
    then estimated with the pose. None: it is right within 1 %.)";

inline constexpr char kCameraFromExif[] = R"(from_exif(path) -> Camera

The camera of an upright photo by its EXIF: the focal length within 5 %, or unknown() if the EXIF
states none.)";

inline constexpr char kCameraUnknown[] = R"(unknown(size) -> Camera

A camera of which only the size of its images is known; its focal length and distortion are
estimated with the pose.)";

inline constexpr char kFeatures[] = R"(Features(keypoints, descriptors, type='sift', size=None)

The features of one picture. They are copied once, here; queries use them without a copy.

keypoints: float32 or float64, (N, 2) for x, y in pixels, or (N, 4) with the scale in pixels and
    the orientation in radians; 0 and NaN say that they are unknown, as they are without these
    columns. (0.5, 0.5) is the middle of the first pixel.
descriptors: float32 or uint8, (N, D).
type: the extractor, which must be that of the map ('sift': SIFT as COLMAP writes it, values up to
    255), or Map.codec for descriptors that were projected for that map.
size: (width, height) of the picture, pixels; needed for queries without a camera.

Arrays must be C-contiguous and have the byte order of the machine.)";

inline constexpr char kFeaturesKeypoints[] =
    "float32 of shape (N, 4): x, y, scale in pixels, orientation in radians. A view that cannot\n"
    "be written to.";

inline constexpr char kExtract[] =
    R"(extract(image, camera=None, *, type='sift', options=None) -> Features

Extracts SIFT features from a picture.

image: a path, the bytes of an image file (JPEG, PNG, PNM), or pixels: uint8 of shape (H, W), gray,
    or (H, W, 3), red, green, blue.
camera: files are turned by their EXIF to the size of this camera; None turns them upright.
options: as of Map; the section 'sift' counts.)";

inline constexpr char kQuery[] =
    R"(Query(image, camera=None, *, prior=None, accuracy_m=15, gravity=None, rig=None,
      timeout_ms=None, exif_prior=True)

The arguments of Map.localize as a value, for Map.localize_many.)";

inline constexpr char kGeoPose[] =
    "The position and orientation of a camera, as an OGC GeoPose (Basic-Quaternion).";

inline constexpr char kInliers[] =
    "The matches that a pose explains, as arrays with a row for each.";

inline constexpr char kResult[] =
    "The answer to a query. Without a pose, `reason` says why, and what is about the pose is None.";

inline constexpr char kEcefFromCam[] =
    "float64 4 x 4, or None: camera (x right, y down, z forward) to ECEF, meters.";

inline constexpr char kEnuFromCam[] =
    "float64 4 x 4, or None: camera to east-north-up at the camera's own position, so that the\n"
    "translation is zero.";

inline constexpr char kCovariance[] =
    "float64 6 x 6, or None: covariance of (rotation, position) of the camera in east-north-up at\n"
    "the camera: rad^2, rad m, m^2. enu_from_cam = (Exp(rotation), position) applied to the\n"
    "estimate from the left. It is relative to the map; see map_accuracy_m.";

inline constexpr char kEstimatedCamera[] =
    "The camera as estimated with the pose, or None if the camera was kept as stated. The pose "
    "and\n"
    "the errors of the inliers are for this camera.";

inline constexpr char kReason[] =
    "None with a pose, or one of 'NO_COVERAGE', 'TOO_FEW_FEATURES', 'TOO_FEW_MATCHES',\n"
    "'TOO_FEW_INLIERS', 'AMBIGUOUS', 'PRIOR_MISMATCH', 'TIMEOUT'.";

inline constexpr char kStages[] =
    "Time of each stage, seconds: decode, extract, prior, tiles, matching, voting, pose,\n"
    "refinement, and total, which is all that the map or the server took.";

inline constexpr char kMap[] = R"(Map(path_or_url, cache_mb=1024, options=None)

A map that answers queries: a file, or a postgresql:// URL. All threads may use it at once. A query
answers by the version of the map that is current when it starts. Use it in a with statement, or
call close().

cache_mb: memory for decoded tiles, MiB.
options: a dict of options or the path of a JSON file, as --options of the command line:
    {'answer': {'min_score': 10}}. `cairn options` prints all of them.)";

inline constexpr char kMapClose[] =
    "close()\n\nLets go of the file and the tiles once the calls that run have ended. Later calls\n"
    "raise cairn.Error.";

inline constexpr char kLocalize[] =
    R"(localize(image, camera=None, *, prior=None, accuracy_m=15, gravity=None, rig=None,
         timeout_ms=None, exif_prior=True) -> Result

Computes where a photo was taken. Other threads run meanwhile. Ctrl-C takes effect when the answer
is there.

image: a path, the bytes of an image file, pixels (uint8 of shape (H, W) or (H, W, 3)), Features,
    or a Query with all the rest. The memory of an array must not change during the call.
camera: Camera of the picture as stored or as turned by its EXIF, whichever has its size. None:
    from the EXIF, for the upright picture; without a focal length there, estimated with the pose.
prior: rough position (latitude, longitude) or (latitude, longitude, height above the ellipsoid),
    degrees and meters. None: that of the EXIF, unless exif_prior is False; else the whole map is
    searched.
accuracy_m: 68 % radius of the prior, meters.
gravity: the direction down in the camera frame (x right, y down, z forward), of any length.
rig: a sequence of (image, camera, cam_from_first) of the other cameras of a rig; cam_from_first
    is 4 x 4, from the frame of the first camera, meters.
timeout_ms: from the start of the call, after which the best answer so far counts. The extraction
    of features is not cut short. None: no limit.)";

inline constexpr char kLocalizeMany[] = R"(localize_many(queries, threads=0) -> iterator of Result

Answers many queries on several threads. The results come in the order of the queries, which are
taken from the iterable as the work goes on. Ctrl-C stops at once.

queries: an iterable of Query, or of images or Features that need no further arguments. An item
    that is no query or cannot be read raises when its turn comes; the iterator goes on after it.
    What the iterable itself raises comes after the results before it.
threads: 0 means all cores.)";

inline constexpr char kLandmarks[] = R"(landmarks(where) -> structured array

The landmarks of a tile (its name, e.g. '32N-03104-35120', or its number), or of the tiles that
meet a box (west, south, east, north) in degrees, then only those within the box. A landmark that
several tiles hold has a row for each.

Fields: id and tile (uint64), ecef (3 float64, meters), lat_deg, lon_deg, h_m (above the
ellipsoid), sigma_m (standard deviation per axis), num_descriptors.)";

inline constexpr char kKeyframes[] = R"(keyframes() -> structured array

The mapping photos of the map.

Fields: id, session (as Session.id), tile (uint64), ecef_from_cam (4 x 4 float64, meters), image.)";

inline constexpr char kTiles[] = R"(tiles(bbox=None) -> structured array

The tiles of the map, or of those whose squares meet a box (west, south, east, north) in degrees.

Fields: id (uint64), num_landmarks, num_descriptors, num_keyframes, num_bytes, bounds_deg (west,
south, east, north), name.)";

inline constexpr char kSql[] = R"(sql(text, *, timeout_s=60) -> Rows

Runs read-only SQL on the map's file, as `cairn sql` does, and returns the rows of the last
statement that has any: a list of tuples with the attribute `columns`. Ctrl-C stops at the next
row.)";

inline constexpr char kSummary[] = "What became of a session, or of several.";

inline constexpr char kInit[] =
    "init(path)\n\nCreates an empty map: a file, or a postgresql:// URL.";

inline constexpr char kReport[] =
    "How well a map localizes queries with known poses. Intervals are 95 % bootstrap intervals.";

inline constexpr char kRecalls[] =
    "Recall of all queries within thresholds: (position_m, rotation_rad, value, low, high) each.";

inline constexpr char kClient[] = R"(Client(url, api_key=None, *, ca_file=None, timeout_ms=30000,
       allow_plain_key=False)

A server that answers queries: `cairn serve`. Keeps its connection. Threads that ask at once wait
for each other; use a Client for each.

url: 'http://host:port' or 'https://host:port', with a path if a front serves the API under it.
api_key: sent with each request; over plain http only to this machine, unless allow_plain_key.
ca_file: PEM file of the certificates to trust instead of the system's.
timeout_ms: for each exchange.)";

inline constexpr char kClientLocalize[] =
    R"(localize(image, camera=None, *, prior=None, accuracy_m=15, gravity=None, rig=None,
         timeout_ms=None, exif_prior=True) -> Result

As Map.localize, by the server. Files and pixels are sent as they are; Features are sent without
loss. Ctrl-C stops at once, or when the connection that is just being made stands or fails. Raises
cairn.Error with code 'unavailable' if no server answers.)";

inline constexpr char kFusionQuery[] = "A question to the map about one frame.";

inline constexpr char kFusionEstimate[] =
    "The state of a FusionClient at one time. Frames: imu (the inertial unit), local (level, "
    "starts\n"
    "where the device starts), global (east-north-up at the client's origin).";

inline constexpr char kFusionMode[] =
    "'initializing', 'tracking', 'aligning', 'localized', 'coasting' or 'lost'.";

inline constexpr char kFusionClient[] = R"(FusionClient(camera, cam_from_imu, origin, options=None)

Visual-inertial tracking that uses answers of the map. Feed it from one thread. Deterministic: the
same calls give the same estimates.

camera: Camera of the frames.
cam_from_imu: 4 x 4, from the frame of the inertial unit to that of the camera, meters.
origin: (latitude, longitude, height), degrees and meters, of the frame `global`.
options: a dict: gravity_m_s2, time_offset_s, max_clones, imu_noise, state, query, standstill,
    tracks, map, steady; docs/python.md lists them.)";

inline constexpr char kAddImu[] = R"(add_imu(timestamps_ns, gyro_rad_s, accel_m_s2) -> str

Takes inertial samples in order of time.

timestamps_ns: int64 (N,). gyro_rad_s: float64 (N, 3). accel_m_s2: float64 (N, 3), the specific
force, +g upward at rest.

Returns 'accepted', or what the first sample was that was not: 'bad_input', 'out_of_order',
'restarted'.)";

inline constexpr char kAddFrame[] = R"(add_frame(timestamp_ns, track_ids, pixels) -> str

Takes the tracked features of a frame; one id in several frames is one point.

timestamp_ns: in the clock of the camera. track_ids: uint64 (N,). pixels: float64 (N, 2).

Returns 'accepted', 'bad_input', 'out_of_order' or 'queue_full'.)";

inline constexpr char kPollQuery[] =
    "poll_query() -> FusionQuery or None\n\nThe query about the newest frame, if one is due. "
    "Answer\n"
    "it with Map.localize or Client.localize, with its gravity, and submit the result.";

inline constexpr char kSubmit[] = R"(submit(query, result) -> str

Takes an answer to a query; answers may be late and out of order, and any thread may call this.
Inliers within half a pixel of a track of the frame are taken for its point. Returns 'queued' or
'queue_full'.)";

inline constexpr char kTakeReports[] =
    "take_reports() -> list of AnswerReport\n\nWhat became of the answers since the last call.";

inline constexpr char kPredict[] =
    "predict(timestamp_ns) -> (status, FusionEstimate or None)\n\nThe state at a time of the "
    "IMU's\n"
    "clock. status: 'ok', 'no_state', 'too_far_ahead' (0.5 s), 'too_far_behind' (50 ms).";

inline constexpr char kSetLogLevel[] =
    "set_log_level(level)\n\nLeast severity of what is written to stderr: 'debug', 'info',\n"
    "'warning' (the default), 'error' or 'off'.";

}  // namespace cairn::python::docs

#endif  // CAIRN_PYTHON_DOCS_H_
