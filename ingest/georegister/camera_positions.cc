#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <map>
#include <sstream>
#include <string_view>

#include "core/error.h"
#include "core/file_bytes.h"
#include "core/printable.h"
#include "ingest/georegister/georegister.h"

namespace cairn {
namespace {

std::string_view Trimmed(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\r";
  const size_t begin = text.find_first_not_of(kBlanks);
  if (begin == std::string_view::npos) {
    return {};
  }
  return text.substr(begin, text.find_last_not_of(kBlanks) + 1 - begin);
}

std::vector<std::string_view> SplitCells(std::string_view line) {
  std::vector<std::string_view> cells;
  while (true) {
    const size_t comma = line.find(',');
    cells.push_back(Trimmed(line.substr(0, comma)));
    if (comma == std::string_view::npos) {
      return cells;
    }
    line.remove_prefix(comma + 1);
  }
}

constexpr uint64_t kMaxTableBytes = uint64_t{256} << 20;

// One CSV file. Its errors name the place of the fault.
class PositionTable {
 public:
  explicit PositionTable(const std::string& path)
      : path_(path), file_(ReadTextFile(path, kMaxTableBytes)) {
    if (!NextLine()) {
      Throw("the header is missing");
    }
    for (size_t i = 0; i < cells_.size(); ++i) {
      column_of_name_.emplace(cells_[i], i);
    }
    for (const char* name : {"image", "lat_deg", "lon_deg", "h_m"}) {
      if (!Has(name)) {
        Throw(
            fmt::format("the header has no column '{}'; expected image, lat_deg, lon_deg, h_m and "
                        "optionally accuracy_m",
                        name));
      }
    }
    num_columns_ = cells_.size();
  }

  // Moves to the next non-blank line.
  bool NextLine() {
    while (std::getline(file_, line_)) {
      ++line_number_;
      if (Trimmed(line_).empty()) {
        continue;
      }
      cells_ = SplitCells(line_);
      if (num_columns_ != 0 && cells_.size() != num_columns_) {
        Throw(fmt::format("{} columns, but the header has {}", cells_.size(), num_columns_));
      }
      return true;
    }
    return false;
  }

  bool Has(const char* name) const { return column_of_name_.contains(name); }

  std::string_view Text(const char* name) const {
    return cells_[column_of_name_.find(name)->second];
  }

  double Number(const char* name) const {
    const std::string_view text = Text(name);
    double value = 0.0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) {
      Throw(fmt::format("column {}: '{}' is not a number", name, Excerpt(text)));
    }
    return value;
  }

  [[noreturn]] void Throw(const std::string& what) const {
    throw Error(ErrorCode::kBadInput, fmt::format("{}: line {}: {}", path_, line_number_, what));
  }

 private:
  std::string path_;
  std::istringstream file_;
  std::string line_;
  int64_t line_number_ = 0;
  std::vector<std::string_view> cells_;  // Views of line_.
  std::map<std::string, size_t, std::less<>> column_of_name_;
  size_t num_columns_ = 0;
};

}  // namespace

std::vector<CameraPosition> ReadCameraPositions(const std::string& path) {
  PositionTable table(path);
  std::vector<CameraPosition> positions;
  while (table.NextLine()) {
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
  return positions;
}

std::vector<CameraPosition> GpsPositions(const Reconstruction& reconstruction, double accuracy_m) {
  std::vector<CameraPosition> positions;
  for (const ReconImage& image : reconstruction.images) {
    if (image.gps) {
      positions.push_back({image.name, *image.gps, accuracy_m});
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
