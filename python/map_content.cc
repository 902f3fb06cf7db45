// What is in a map: tiles, sessions, keyframes and landmarks, as arrays of numpy.
#include <pybind11/stl.h>

#include <array>
#include <charconv>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/angles.h"
#include "core/error.h"
#include "python/arguments.h"
#include "python/arrays.h"
#include "python/docs.h"
#include "python/interruptible.h"
#include "python/map.h"
#include "storage/map/map_store.h"
#include "storage/map/sql_shell.h"
#include "storage/tile/tile_codec.h"

namespace cairn::python {

// Rows of structured arrays. PYBIND11_NUMPY_DTYPE wants them outside of anonymous namespaces.
struct LandmarkRow {
  uint64_t id;
  uint64_t tile;
  double ecef[3];
  double lat_deg, lon_deg, h_m;
  float sigma_m;
  uint32_t num_descriptors;
};
struct KeyframeRow {
  int64_t id, session;
  uint64_t tile;
  double ecef_from_cam[4][4];
};
struct TileRow {
  uint64_t id;
  int64_t num_landmarks, num_descriptors, num_keyframes, num_bytes;
  double bounds_deg[4];
};

namespace {

constexpr int64_t kPage = 1000;

template <typename Row>
py::array_t<Row> ArrayOfRows(const std::vector<Row>& rows) {
  return py::array_t<Row>(static_cast<py::ssize_t>(rows.size()), rows.data());
}

// Adds a field of names to an array of rows.
py::object WithNames(const py::array& rows, const char* field,
                     const std::vector<std::string>& names) {
  py::list texts;
  for (const std::string& name : names) {
    texts.append(TextOut(name));
  }
  return py::module_::import("cairn._support").attr("with_names")(rows, field, texts);
}

std::array<double, 4> BoundsDeg(const GeoBox& box) {
  return {box.west_rad * kDegPerRad, box.south_rad * kDegPerRad, box.east_rad * kDegPerRad,
          box.north_rad * kDegPerRad};
}

bool Contains(const GeoBox& box, const Geodetic& position) {
  const bool is_between = position.lon_rad >= box.west_rad && position.lon_rad <= box.east_rad;
  const bool is_outside = position.lon_rad > box.east_rad && position.lon_rad < box.west_rad;
  return position.lat_rad >= box.south_rad && position.lat_rad <= box.north_rad &&
         (box.CrossesAntimeridian() ? !is_outside : is_between);
}

std::vector<TileRecord> TilesIn(const MapSnapshot& map, const std::optional<GeoBox>& box) {
  std::vector<TileRecord> tiles;
  TilePageRequest request{.box = box, .after = {}, .limit = kPage};
  do {
    TilePage page = map.FindTilePage(request);
    tiles.insert(tiles.end(), page.tiles.begin(), page.tiles.end());
    request.after = page.resume_after;
  } while (request.after);
  return tiles;
}

// Adds the landmarks of a tile, of those in the box if there is one.
void AddLandmarks(const Tile& tile, const std::optional<GeoBox>& box,
                  std::vector<LandmarkRow>* rows) {
  const Rigid3d ecef_from_tile = EcefFromEnu(tile.id.Anchor());
  for (size_t i = 0; i < tile.num_landmarks(); ++i) {
    const Eigen::Vector3d x_in_ecef = ecef_from_tile * tile.x_in_tile[i].cast<double>();
    const Geodetic position = GeodeticFromEcef(x_in_ecef);
    if (box && !Contains(*box, position)) {
      continue;
    }
    rows->push_back({Value(tile.landmark_ids[i]),
                     tile.id.value(),
                     {x_in_ecef.x(), x_in_ecef.y(), x_in_ecef.z()},
                     position.lat_deg(),
                     position.lon_deg(),
                     position.h_m,
                     static_cast<float>(SigmaFromCode(tile.sigma_codes[i])),
                     tile.descriptor_begin[i + 1] - tile.descriptor_begin[i]});
  }
}

// Whether the argument is a name or number, and not a box. Each array of numpy has `__index__`.
bool IsTile(py::handle where) {
  if (py::isinstance<py::array>(where)) {
    return py::reinterpret_borrow<py::array>(where).ndim() == 0;
  }
  return py::isinstance<py::str>(where) || PyIndex_Check(where.ptr()) != 0;
}

// A tile by its name or number.
TileId TileOf(py::handle where) {
  try {
    return py::isinstance<py::str>(where)
               ? TileId::Parse(where.cast<std::string>())
               : TileId::FromValue(static_cast<uint64_t>(
                     IntegerOf("where", where, 0, std::numeric_limits<int64_t>::max())));
  } catch (const Error& error) {
    if (error.code() == ErrorCode::kInvalidArgument) {
      throw;
    }
    RefuseArgument("where", error.what());
  }
}

py::array Landmarks(const PythonMap& map, const py::object& where) {
  const auto opened = map.Require();
  std::optional<GeoBox> box;
  std::optional<TileId> tile_id;
  if (IsTile(where)) {
    tile_id = TileOf(where);
  } else {
    box = BoxOf("where", where);
  }
  std::vector<LandmarkRow> rows;
  RunInterruptibly(py::none(), [&](const WorkProgress& report) {
    const MapSnapshot snapshot = opened->localizer.map().Snapshot();
    std::vector<TileRecord> tiles;
    if (!tile_id) {
      tiles = TilesIn(snapshot, box);
    } else if (const auto tile = snapshot.FindTile(*tile_id)) {
      tiles = {*tile};
    } else {
      throw Error(ErrorCode::kNotFound, "where: the map has no tile " + tile_id->ToString());
    }
    for (size_t i = 0; i < tiles.size(); ++i) {
      const auto payload = snapshot.LoadPayload(tiles[i].payload_id);
      AddLandmarks(DecodeTile({payload.data(), payload.size()}), box, &rows);
      report("landmarks", static_cast<int64_t>(i + 1), static_cast<int64_t>(tiles.size()));
    }
  });
  return ArrayOfRows(rows);
}

py::object Keyframes(const PythonMap& map) {
  const auto opened = map.Require();
  std::vector<KeyframeRow> rows;
  std::vector<std::string> names;
  {
    const py::gil_scoped_release release;
    const MapSnapshot snapshot = opened->localizer.map().Snapshot();
    for (const SessionRecord& session : snapshot.Sessions()) {
      for (const KeyframeRecord& keyframe : snapshot.KeyframesOfSession(session.id)) {
        KeyframeRow row{Value(keyframe.id), Value(session.id), keyframe.tile_id.value(), {}};
        Eigen::Map<Eigen::Matrix<double, 4, 4, Eigen::RowMajor>> pose(&row.ecef_from_cam[0][0]);
        pose.setIdentity();
        pose.topRows<3>() = keyframe.cam_from_ecef.Inverse().ToMatrix();
        rows.push_back(row);
        names.push_back(keyframe.image_name);
      }
    }
  }
  return WithNames(ArrayOfRows(rows), "image", names);
}

py::object Tiles(const PythonMap& map, const py::object& bbox) {
  const auto opened = map.Require();
  std::optional<GeoBox> box;
  if (!bbox.is_none()) {
    box = BoxOf("bbox", bbox);
  }
  std::vector<TileRow> rows;
  std::vector<std::string> names;
  {
    const py::gil_scoped_release release;
    for (const TileRecord& tile : TilesIn(opened->localizer.map().Snapshot(), box)) {
      const auto bounds = BoundsDeg(tile.tile_id.Bounds());
      rows.push_back({tile.tile_id.value(),
                      tile.num_landmarks,
                      tile.num_descriptors,
                      tile.num_keyframes,
                      tile.num_bytes,
                      {bounds[0], bounds[1], bounds[2], bounds[3]}});
      names.push_back(tile.tile_id.ToString());
    }
  }
  return WithNames(ArrayOfRows(rows), "name", names);
}

// A number as SQLite writes it; text that is no number stays text.
py::object ValueOfCell(const SqlCell& cell) {
  if (cell.is_null) {
    return py::none();
  }
  const char* end = cell.text.data() + cell.text.size();
  int64_t integer = 0;
  if (cell.is_number && std::from_chars(cell.text.data(), end, integer).ptr == end) {
    return py::int_(integer);
  }
  double number = 0.0;
  if (cell.is_number && std::from_chars(cell.text.data(), end, number).ptr == end) {
    return py::float_(number);
  }
  return py::reinterpret_steal<py::object>(
      PyUnicode_DecodeUTF8(cell.text.data(), static_cast<Py_ssize_t>(cell.text.size()), "replace"));
}

py::object Sql(const PythonMap& map, const py::object& text_argument, const py::object& timeout) {
  map.Require();
  const std::string text = TextOf("text", text_argument);
  SqlOptions options;
  options.timeout_s = NumberOf("timeout_s", timeout, 1e-3, 1e6);
  std::vector<std::string> columns;
  std::vector<std::vector<SqlCell>> rows;
  RunInterruptibly(py::none(), [&](const WorkProgress& report) {
    SqlSink sink;
    sink.on_columns = [&](const std::vector<std::string>& names) {
      columns = names;
      rows.clear();
    };
    sink.on_row = [&](const std::vector<SqlCell>& row) {
      rows.push_back(row);
      report("rows", static_cast<int64_t>(rows.size()), 0);
    };
    RunSql(map.path(), text, options, sink);
  });
  py::list values;
  for (const std::vector<SqlCell>& row : rows) {
    py::tuple cells(row.size());
    for (size_t i = 0; i < row.size(); ++i) {
      cells[i] = ValueOfCell(row[i]);
    }
    values.append(cells);
  }
  return py::module_::import("cairn._support").attr("Rows")(columns, values);
}

py::list Sessions(const PythonMap& map) {
  const py::object session = py::module_::import("cairn._support").attr("Session");
  py::list sessions;
  for (const SessionRecord& record : map.Require()->localizer.map().Snapshot().Sessions()) {
    sessions.append(session(Value(record.id), TextOut(record.name), TextOut(record.source),
                            record.recorded_at, record.created_at, record.num_images,
                            record.num_landmarks));
  }
  return sessions;
}

py::object Bounds(const PythonMap& map) {
  const auto bounds = map.Require()->localizer.map().Snapshot().Info().bounds;
  return bounds ? py::object(py::tuple(py::cast(BoundsDeg(*bounds)))) : py::none();
}

py::object Codec(const PythonMap& map) {
  const auto codebook = map.Require()->localizer.map().Snapshot().CurrentCodebook();
  return codebook ? py::cast(codebook->CodecName()) : py::none();
}

}  // namespace

void BindMapContent(py::class_<PythonMap>* map) {
  using py::arg;
  PYBIND11_NUMPY_DTYPE(LandmarkRow, id, tile, ecef, lat_deg, lon_deg, h_m, sigma_m,
                       num_descriptors);
  PYBIND11_NUMPY_DTYPE(KeyframeRow, id, session, tile, ecef_from_cam);
  PYBIND11_NUMPY_DTYPE(TileRow, id, num_landmarks, num_descriptors, num_keyframes, num_bytes,
                       bounds_deg);
  map->def("landmarks", &Landmarks, arg("where"), docs::kLandmarks)
      .def("keyframes", &Keyframes, docs::kKeyframes)
      .def("tiles", &Tiles, arg("bbox") = py::none(), docs::kTiles)
      .def("sql", &Sql, arg("text"), py::kw_only(), arg("timeout_s") = 60.0, docs::kSql)
      .def_property_readonly(
          "version",
          [](const PythonMap& self) {
            return Value(self.Require()->localizer.map().Snapshot().version());
          },
          "The number of the map's latest version.")
      .def_property_readonly("sessions", &Sessions, "The sessions of the map: cairn.Session.")
      .def_property_readonly("bounds", &Bounds,
                             "(west, south, east, north) around the tiles, degrees, or None.")
      .def_property_readonly("codec", &Codec,
                             "Name of the codec of projected descriptors, or None.");
}

}  // namespace cairn::python
