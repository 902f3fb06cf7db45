#include "ingest/readers/colmap_database.h"

#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <vector>

#include "core/error.h"
#include "core/logging.h"
#include "core/printable.h"
#include "storage/sqlite/connection.h"

namespace cairn {
namespace {

constexpr int kBusyTimeoutMs = 2000;
constexpr float kDescriptorUnit = 512.0f;
// Keypoints without a scale in the database count as small.
constexpr float kDefaultScalePx = 1.0f;
constexpr float kMinScalePx = 0.01f;
constexpr int64_t kMaxKeypoints = 10'000'000;

// COLMAP's PosePrior::CoordinateSystem and SensorType::CAMERA.
constexpr int64_t kWgs84 = 0;
constexpr int64_t kCartesian = 1;
constexpr int64_t kCameraSensor = 0;

// The statistics of descriptors use at most this many images.
constexpr int64_t kMaxStatisticsImages = 64;

// A matrix in COLMAP's storage form.
struct MatrixBlob {
  int64_t rows = 0;
  int64_t cols = 0;
  std::vector<uint8_t> bytes;
};

// The matrix of an image and, with `type_column`, the integer in the column beside it.
struct StoredMatrix {
  MatrixBlob matrix;
  std::optional<int64_t> type;
};

StoredMatrix ReadMatrix(sqlite::Connection* connection, const char* table, bool type_column,
                        const std::string& image_name) {
  sqlite::Statement statement = connection->Prepare(
      fmt::format("SELECT m.rows, m.cols, m.data, {} FROM {} AS m JOIN images AS i "
                  "ON i.image_id = m.image_id WHERE i.name = ?",
                  type_column ? "m.type" : "NULL", table));
  statement.Bind(std::string_view(image_name));
  if (!statement.Step()) {
    throw Error(
        ErrorCode::kBadInput,
        fmt::format("it has no {} for image {}; check that the model was built from this database "
                    "and that features were extracted",
                    table, Excerpt(image_name)));
  }
  StoredMatrix stored{.matrix = {statement.Int64(0), statement.Int64(1), {}}, .type = {}};
  if (!statement.IsNull(2)) {
    stored.matrix.bytes = statement.Blob(2);
  }
  if (!statement.IsNull(3)) {
    stored.type = statement.Int64(3);
  }
  return stored;
}

void CheckSize(const MatrixBlob& matrix, int64_t element_bytes, const char* table,
               const std::string& image_name) {
  const bool in_range =
      matrix.rows >= 0 && matrix.rows <= kMaxKeypoints && matrix.cols >= 1 && matrix.cols <= 4096;
  if (!in_range ||
      matrix.bytes.size() != static_cast<uint64_t>(matrix.rows * matrix.cols * element_bytes)) {
    throw Error(ErrorCode::kBadInput,
                fmt::format("the {} of image {} should be {} x {}, but have {} bytes", table,
                            Excerpt(image_name), matrix.rows, matrix.cols, matrix.bytes.size()));
  }
}

// `row` has `cols` floats: x, y; or x, y, scale, orientation; or x, y, a11, a12, a21, a22.
Keypoint ToKeypoint(const float* row, int64_t cols) {
  Keypoint keypoint{row[0], row[1], kDefaultScalePx, 0.0f};
  if (cols == 4) {
    keypoint.scale_px = row[2];
    keypoint.orientation_rad = row[3];
  } else if (cols == 6) {
    keypoint.scale_px = 0.5f * (std::hypot(row[2], row[4]) + std::hypot(row[3], row[5]));
    keypoint.orientation_rad = std::atan2(row[4], row[2]);
  }
  // This form of the test keeps NaN unchanged, so that validation can find it.
  if (keypoint.scale_px < kMinScalePx) {
    keypoint.scale_px = kMinScalePx;
  }
  return keypoint;
}

std::vector<Keypoint> ToKeypoints(const MatrixBlob& matrix, const std::string& image_name) {
  if (matrix.cols != 2 && matrix.cols != 4 && matrix.cols != 6) {
    throw Error(ErrorCode::kBadInput,
                fmt::format("the keypoints of image {} have {} columns; 2, 4 or 6 are supported",
                            Excerpt(image_name), matrix.cols));
  }
  std::vector<Keypoint> keypoints(matrix.rows);
  for (int64_t i = 0; i < matrix.rows; ++i) {
    float row[6];
    const size_t row_bytes = sizeof(float) * static_cast<size_t>(matrix.cols);
    std::memcpy(row, matrix.bytes.data() + static_cast<size_t>(i) * row_bytes, row_bytes);
    keypoints[i] = ToKeypoint(row, matrix.cols);
  }
  return keypoints;
}

bool HasColumn(sqlite::Connection* connection, const char* table, const char* column) {
  sqlite::Statement statement =
      connection->Prepare("SELECT COUNT(*) FROM pragma_table_info(?) WHERE name = ?");
  statement.Bind(std::string_view(table), std::string_view(column));
  return statement.Step() && statement.Int64(0) > 0;
}

// SQL for the prior of the image named ?, as columns lat_deg, lon_deg, h_m or as one blob of all
// three.
std::string GpsSql(sqlite::Connection* connection) {
  if (HasColumn(connection, "pose_priors", "corr_data_id")) {
    return fmt::format(
        "SELECT p.position FROM pose_priors AS p JOIN images AS i ON i.image_id = p.corr_data_id "
        "WHERE p.corr_sensor_type = {} AND p.coordinate_system = {} AND i.name = ?",
        kCameraSensor, kWgs84);
  }
  if (HasColumn(connection, "pose_priors", "image_id")) {
    return fmt::format(
        "SELECT p.position FROM pose_priors AS p JOIN images AS i ON i.image_id = p.image_id "
        "WHERE p.coordinate_system = {} AND i.name = ?",
        kWgs84);
  }
  if (HasColumn(connection, "images", "prior_tx")) {
    return "SELECT prior_tx, prior_ty, prior_tz FROM images WHERE prior_tx IS NOT NULL AND "
           "prior_ty IS NOT NULL AND name = ?";
  }
  return "";
}

// Warns about pose priors that are not geographic positions and are therefore skipped.
void WarnOfOtherPriors(const std::string& path, sqlite::Connection* connection) {
  if (!HasColumn(connection, "pose_priors", "coordinate_system")) {
    return;
  }
  sqlite::Statement statement =
      connection->Prepare("SELECT COUNT(*) FROM pose_priors WHERE coordinate_system = ?");
  statement.Bind(kCartesian);
  if (statement.Step() && statement.Int64(0) > 0) {
    LogWarning("COLMAP database {}: {} of its pose priors are ignored because they are not WGS84",
               path, statement.Int64(0));
  }
}

// Runs `read` and replaces the wrapper's messages about maps by messages about the database.
template <typename Read>
auto WithDatabaseErrors(const std::string& path, const Read& read) {
  try {
    return read();
  } catch (const Error& e) {
    const bool is_io = e.code() == ErrorCode::kIo || e.code() == ErrorCode::kConflict;
    throw Error(is_io ? e.code() : ErrorCode::kBadInput,
                fmt::format("COLMAP database {}: {}", path, e.what()));
  }
}

}  // namespace

ColmapDatabase::ColmapDatabase(const std::string& path) : path_(path) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) {
    throw Error(ErrorCode::kNotFound, fmt::format("{}: no such COLMAP database", path));
  }
  WithDatabaseErrors(path_, [&] {
    connection_ =
        std::make_unique<sqlite::Connection>(path, sqlite::Access::kReadOnly, kBusyTimeoutMs);
    for (const char* table : {"images", "keypoints", "descriptors"}) {
      if (!HasColumn(connection_.get(), table, "image_id")) {
        throw Error(ErrorCode::kBadInput, fmt::format("it has no table `{}`", table));
      }
    }
    gps_sql_ = GpsSql(connection_.get());
    has_descriptor_type_ = HasColumn(connection_.get(), "descriptors", "type");
    WarnOfOtherPriors(path_, connection_.get());
  });
}

ColmapDatabase::~ColmapDatabase() = default;

bool ColmapDatabase::HasImage(const std::string& image_name) {
  return WithDatabaseErrors(path_, [&] {
    sqlite::Statement statement = connection_->Prepare("SELECT 1 FROM images WHERE name = ?");
    statement.Bind(std::string_view(image_name));
    return statement.Step();
  });
}

SiftNormalization ColmapDatabase::NormalizationOfAll() {
  if (normalization_) {
    return *normalization_;
  }
  SiftStatistics statistics;
  sqlite::Statement statement = connection_->Prepare(
      "SELECT data FROM descriptors WHERE cols = ? AND data IS NOT NULL LIMIT ?");
  statement.Bind(int64_t{kColmapDim}, kMaxStatisticsImages);
  while (!statistics.IsEnough() && statement.Step()) {
    statistics.Add(statement.Blob(0));
  }
  normalization_ = statistics.Normalization();
  if (*normalization_ == SiftNormalization::kL2) {
    LogInfo("COLMAP database {}: its SIFT descriptors have the normalization L2, not L1_ROOT",
            path_);
  }
  return *normalization_;
}

DescriptorMatrix ColmapDatabase::ReadDescriptors(const std::string& image_name) {
  const auto [matrix, type] =
      ReadMatrix(connection_.get(), "descriptors", has_descriptor_type_, image_name);
  CheckSiftBlob(image_name, type, matrix.rows, matrix.cols, matrix.bytes.size());
  CheckSize(matrix, 1, "descriptors", image_name);
  using ByteMatrix = Eigen::Matrix<uint8_t, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const Eigen::Map<const ByteMatrix> bytes(matrix.bytes.data(), matrix.rows, matrix.cols);
  DescriptorMatrix descriptors = bytes.cast<float>();
  if (NormalizationOfAll() == SiftNormalization::kL1Root) {
    descriptors = descriptors.array().square() / kDescriptorUnit;
  }
  return descriptors;
}

FeatureSet ColmapDatabase::ReadFeatures(const std::string& image_name) {
  return WithDatabaseErrors(path_, [&] {
    const MatrixBlob keypoints =
        ReadMatrix(connection_.get(), "keypoints", /*type_column=*/false, image_name).matrix;
    CheckSize(keypoints, sizeof(float), "keypoints", image_name);
    FeatureSet features;
    features.descriptors = ReadDescriptors(image_name);
    if (keypoints.rows != features.descriptors.rows()) {
      throw Error(ErrorCode::kBadInput,
                  fmt::format("image {} has {} keypoints but {} descriptors", Excerpt(image_name),
                              keypoints.rows, features.descriptors.rows()));
    }
    features.keypoints = ToKeypoints(keypoints, image_name);
    return features;
  });
}

std::optional<Geodetic> ColmapDatabase::ReadGps(const std::string& image_name) {
  if (gps_sql_.empty()) {
    return std::nullopt;
  }
  return WithDatabaseErrors(path_, [&]() -> std::optional<Geodetic> {
    sqlite::Statement statement = connection_->Prepare(gps_sql_);
    statement.Bind(std::string_view(image_name));
    if (!statement.Step() || statement.IsNull(0)) {
      return std::nullopt;
    }
    double lat_lon_h[3];
    if (gps_sql_.find("pose_priors") != std::string::npos) {
      const std::vector<uint8_t> position = statement.Blob(0);
      if (position.size() != sizeof(lat_lon_h)) {
        return std::nullopt;
      }
      std::memcpy(lat_lon_h, position.data(), sizeof(lat_lon_h));
    } else {
      for (int i = 0; i < 3; ++i) {
        lat_lon_h[i] = statement.IsNull(i) ? 0.0 : statement.Number(i);
      }
    }
    const auto [lat_deg, lon_deg, h_m] = lat_lon_h;
    const bool is_place = std::abs(lat_deg) <= 90.0 && std::abs(lon_deg) <= 180.0 &&
                          std::abs(h_m) <= 12'000.0 && (lat_deg != 0.0 || lon_deg != 0.0);
    if (!is_place) {
      return std::nullopt;
    }
    return Geodetic::FromDegrees(lat_deg, lon_deg, h_m);
  });
}

}  // namespace cairn
