#include "ingest/colmap/colmap_database.h"

#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <utility>
#include <vector>

#include "core/error.h"
#include "core/keypoint_shape.h"
#include "core/logging.h"
#include "core/printable.h"
#include "ingest/colmap/colmap_columns.h"
#include "ingest/colmap/descriptor_information.h"
#include "storage/database/sqlite/connection.h"
#include "storage/database/sqlite/limit_values.h"

namespace cairn {
namespace {

constexpr int kBusyTimeoutMs = 2000;
// Smaller scales count as this one.
constexpr float kMinScalePx = 0.01f;
constexpr int64_t kMaxKeypoints = 2'000'000;
constexpr int kMaxBlobBytes = 2'000'000 * kColmapDim;

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
  // An image without features may have a matrix of 0 x 0.
  const bool in_range =
      matrix.rows >= 0 && matrix.rows <= kMaxKeypoints && matrix.cols >= 0 && matrix.cols <= 4096;
  if (!in_range ||
      matrix.bytes.size() != static_cast<uint64_t>(matrix.rows * matrix.cols * element_bytes)) {
    throw Error(ErrorCode::kBadInput,
                fmt::format("the {} of image {} should be {} x {}, but have {} bytes", table,
                            Excerpt(image_name), matrix.rows, matrix.cols, matrix.bytes.size()));
  }
}

// `row` has `cols` floats: x, y; or x, y, scale, orientation; or x, y, a11, a12, a21, a22.
Keypoint ToKeypoint(const float* row, int64_t cols) {
  if (cols == 2) {
    return KeypointWithoutShape(row[0], row[1]);
  }
  Keypoint keypoint{row[0], row[1], 0.0f, 0.0f};
  if (cols == 4) {
    keypoint.scale_px = row[2];
    keypoint.orientation_rad = row[3];
  } else {
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
  if (matrix.rows > 0 && matrix.cols != 2 && matrix.cols != 4 && matrix.cols != 6) {
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

// What byte b of a descriptor of the normalization L1_ROOT stands for.
std::vector<float> SquaresOfBytes() {
  std::vector<float> squares(256);
  for (int b = 0; b < 256; ++b) {
    squares[b] = static_cast<float>(b * b) / kColmapNorm;
  }
  return squares;
}

}  // namespace

ColmapDatabase::ColmapDatabase(const std::string& path) : path_(path) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) {
    const std::filesystem::path usual = std::filesystem::path(path) / "database.db";
    throw Error(
        ErrorCode::kBadInput,
        fmt::format("{}: this is a folder; name the file of the COLMAP database{}", path,
                    std::filesystem::is_regular_file(usual, ignored) ? ", " + usual.string() : ""));
  }
  if (!std::filesystem::is_regular_file(path, ignored)) {
    throw Error(ErrorCode::kNotFound, fmt::format("{}: no such COLMAP database", path));
  }
  WithDatabaseErrors(path_, [&] { Open(); });
}

void ColmapDatabase::Open() {
  try {
    OpenAs(sqlite::Access::kReadOnly);
    return;
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kIo) {
      throw;
    }
    if (RollBack()) {
      OpenAs(sqlite::Access::kReadOnly);
      return;
    }
    // COLMAP leaves its database in WAL mode, in which SQLite writes files beside it even to read.
    for (const char* suffix : {"-wal", "-journal"}) {
      std::error_code missing;
      if (std::filesystem::file_size(path_ + suffix, missing) > 0 && !missing) {
        throw Error(
            ErrorCode::kIo,
            fmt::format("{}. Beside it is {}{} with changes that are not in it yet, and the "
                        "folder cannot be written to; copy both files to a folder that can",
                        error.what(), path_, suffix));
      }
    }
  }
  OpenAs(sqlite::Access::kImmutable);
}

bool ColmapDatabase::RollBack() {
  std::error_code missing;
  if (!std::filesystem::exists(path_ + "-journal", missing)) {
    return false;
  }
  try {
    sqlite::Connection writer(path_, sqlite::Access::kReadWrite, kBusyTimeoutMs);
    writer.Execute("SELECT count(*) FROM sqlite_master");  // SQLite rolls back before it reads.
  } catch (const Error&) {
    return false;
  }
  LogWarning("{}: the program that wrote it was killed; its last changes are taken back", path_);
  return true;
}

void ColmapDatabase::OpenAs(sqlite::Access access) {
  connection_ = std::make_unique<sqlite::Connection>(path_, access, kBusyTimeoutMs);
  sqlite::LimitValues(connection_.get(), kMaxBlobBytes);
  for (const char* table : {"images", "keypoints", "descriptors"}) {
    if (!HasColumn(connection_.get(), table, "image_id")) {
      throw Error(ErrorCode::kBadInput, fmt::format("it has no table `{}`", table));
    }
  }
  has_descriptor_type_ = HasColumn(connection_.get(), "descriptors", "type");
}

ColmapDatabase::~ColmapDatabase() = default;

bool ColmapDatabase::HasImage(const std::string& image_name) {
  return WithDatabaseErrors(path_, [&] {
    sqlite::Statement statement = connection_->Prepare("SELECT 1 FROM images WHERE name = ?");
    statement.Bind(std::string_view(image_name));
    return statement.Step();
  });
}

std::vector<std::string> ColmapDatabase::ImageNames() {
  return WithDatabaseErrors(path_, [&] {
    std::vector<std::string> names;
    sqlite::Statement statement = connection_->Prepare("SELECT name FROM images ORDER BY image_id");
    while (statement.Step()) {
      names.push_back(statement.Text(0));
    }
    return names;
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

PackedDescriptors ColmapDatabase::ReadDescriptors(const std::string& image_name) {
  const auto [matrix, type] =
      ReadMatrix(connection_.get(), "descriptors", has_descriptor_type_, image_name);
  CheckSiftBlob(image_name, type, matrix.rows, matrix.cols, matrix.bytes.size());
  CheckSize(matrix, 1, "descriptors", image_name);
  if (matrix.rows > 0) {
    RequireVariedDescriptors(image_name, matrix.bytes, kColmapDim);
  }
  ByteDescriptorMatrix bytes =
      Eigen::Map<const ByteDescriptorMatrix>(matrix.bytes.data(), matrix.rows, matrix.cols);
  return NormalizationOfAll() == SiftNormalization::kL1Root
             ? PackedDescriptors(std::move(bytes), SquaresOfBytes())
             : PackedDescriptors(std::move(bytes));
}

PackedFeatures ColmapDatabase::ReadFeatures(const std::string& image_name) {
  return WithDatabaseErrors(path_, [&] {
    const MatrixBlob keypoints =
        ReadMatrix(connection_.get(), "keypoints", /*type_column=*/false, image_name).matrix;
    CheckSize(keypoints, sizeof(float), "keypoints", image_name);
    PackedFeatures features;
    features.descriptors = ReadDescriptors(image_name);
    if (keypoints.rows > 0 && features.descriptors.rows() == 0) {
      throw Error(ErrorCode::kBadInput,
                  fmt::format("image {} has {} keypoints, but its descriptors are empty, as tools "
                              "leave them that import matches alone; extract features with "
                              "COLMAP's SIFT",
                              Excerpt(image_name), keypoints.rows));
    }
    if (keypoints.rows != features.descriptors.rows()) {
      throw Error(ErrorCode::kBadInput,
                  fmt::format("image {} has {} keypoints but {} descriptors", Excerpt(image_name),
                              keypoints.rows, features.descriptors.rows()));
    }
    features.keypoints = ToKeypoints(keypoints, image_name);
    return features;
  });
}

ColmapPosePrior ColmapDatabase::ReadPosePrior(const std::string& image_name) {
  if (!pose_priors_) {
    pose_priors_ =
        WithDatabaseErrors(path_, [&] { return ReadColmapPosePriors(path_, connection_.get()); });
  }
  const auto prior = pose_priors_->find(image_name);
  return prior == pose_priors_->end() ? ColmapPosePrior{} : prior->second;
}

}  // namespace cairn
