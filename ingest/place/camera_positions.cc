#include <fmt/format.h>

#include <cmath>
#include <map>
#include <optional>

#include "core/csv.h"
#include "core/error.h"
#include "core/file_bytes.h"
#include "core/logging.h"
#include "core/match_names.h"
#include "core/printable.h"
#include "ingest/place/georegister.h"

namespace cairn {
namespace {

constexpr uint64_t kMaxTableBytes = uint64_t{256} << 20;

// Runs `read` and prefixes the path to the message of an error.
template <typename Read>
auto WithTablePath(const std::string& path, const Read& read) {
  try {
    return read();
  } catch (const Error& error) {
    throw Error(error.code(), fmt::format("{}: {}", path, error.what()));
  }
}

// One CSV file. Its errors name the place of the fault.
class PositionTable {
 public:
  explicit PositionTable(const std::string& path)
      : path_(path),
        text_(ReadTextFile(path, kMaxTableBytes)),
        rows_(WithTablePath(path, [&] { return CsvReader(text_); })) {
    if (!NextRow()) {
      Throw("the header is missing");
    }
    for (size_t i = 0; i < rows_.cells().size(); ++i) {
      column_of_name_.emplace(rows_.cells()[i], i);
    }
    for (const char* name : {"image", "lat_deg", "lon_deg", "h_m"}) {
      if (!Has(name)) {
        Throw(
            fmt::format("the header has no column '{}'; expected image, lat_deg, lon_deg, h_m and "
                        "optionally accuracy_m",
                        name));
      }
    }
    num_columns_ = rows_.cells().size();
  }
  PositionTable(const PositionTable&) = delete;  // rows_ views text_.

  // Moves to the next row.
  bool NextRow() {
    if (!WithTablePath(path_, [&] { return rows_.Next(); })) {
      return false;
    }
    if (num_columns_ != 0 && rows_.cells().size() != num_columns_) {
      Throw(fmt::format("{} columns, but the header has {}; put a name with a '{}' in quotes",
                        rows_.cells().size(), num_columns_, rows_.separator()));
    }
    return true;
  }

  bool Has(const char* name) const { return column_of_name_.contains(name); }

  const std::string& Text(const char* name) const { return rows_.cells()[ColumnOf(name)]; }

  double Number(const char* name) const {
    const std::optional<double> value = rows_.Number(ColumnOf(name));
    if (!value || !std::isfinite(*value)) {
      Throw(fmt::format("column {}: '{}' is not a number", name, Excerpt(Text(name))));
    }
    return *value;
  }

  [[noreturn]] void Throw(const std::string& what) const {
    throw Error(ErrorCode::kBadInput, fmt::format("{}: line {}: {}", path_, rows_.line(), what));
  }

 private:
  size_t ColumnOf(const char* name) const { return column_of_name_.find(name)->second; }

  std::string path_;
  std::string text_;
  CsvReader rows_;
  std::map<std::string, size_t, std::less<>> column_of_name_;
  size_t num_columns_ = 0;
};

}  // namespace

std::vector<CameraPosition> ReadCameraPositions(const std::string& path) {
  PositionTable table(path);
  std::vector<CameraPosition> positions;
  while (table.NextRow()) {
    CameraPosition position;
    position.image_name = table.Text("image");
    position.position = Geodetic::FromDegrees(table.Number("lat_deg"), table.Number("lon_deg"),
                                              table.Number("h_m"));
    if (table.Has("accuracy_m")) {
      position.accuracy_m = table.Number("accuracy_m");
    }
    if (!(position.accuracy_m > 0.0)) {
      table.Throw("column accuracy_m: must be positive");
    }
    try {
      ValidateGeodetic(position.position, Excerpt(position.image_name).c_str());
    } catch (const Error& e) {
      table.Throw(e.what());
    }
    positions.push_back(std::move(position));
  }
  if (positions.empty()) {
    throw Error(ErrorCode::kBadInput,
                fmt::format("{}: there is no position below the header", path));
  }
  return positions;
}

void NameAfterImages(const Reconstruction& reconstruction, std::vector<CameraPosition>* positions) {
  std::vector<std::string> image_names;
  for (const ReconImage& image : reconstruction.images) {
    image_names.push_back(image.name);
  }
  std::vector<std::string> names;
  for (const CameraPosition& position : *positions) {
    names.push_back(position.image_name);
  }
  const NameMatches matches = MatchNames(names, image_names);
  int num_matches = 0;
  for (size_t i = 0; i < names.size(); ++i) {
    if (const int image_idx = matches.known_of_wanted[i]; image_idx >= 0) {
      (*positions)[i].image_name = image_names[image_idx];
      ++num_matches;
    }
  }
  if (num_matches == 0) {
    throw Error(ErrorCode::kBadInput,
                fmt::format("none of the {} known positions belongs to one of the {} images: the "
                            "positions are those of {}, the images are {}",
                            names.size(), image_names.size(), ExampleNames(names),
                            ExampleNames(image_names)));
  }
  if (matches.num_inexact > 0) {
    LogInfo("{} positions have names that are written in another way in the model, e.g. '{}'",
            matches.num_inexact, Excerpt(names[matches.inexact_example]));
  }
}

std::vector<CameraPosition> GpsPositions(const Reconstruction& reconstruction, double accuracy_m) {
  std::vector<CameraPosition> positions;
  for (const ReconImage& image : reconstruction.images) {
    if (image.gps) {
      positions.push_back({image.name, *image.gps, image.gps_accuracy_m.value_or(accuracy_m)});
    }
  }
  return positions;
}

void MakeHeightsEllipsoidal(HeightReference reference, std::vector<CameraPosition>* positions) {
  for (CameraPosition& position : *positions) {
    position.position = WithEllipsoidalHeight(position.position, reference);
  }
}

}  // namespace cairn
