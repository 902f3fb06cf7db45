// COLMAP's text model files: blank-separated, '#' starts a comment line.
//
//   cameras.txt   CAMERA_ID MODEL WIDTH HEIGHT PARAMS[]
//   images.txt    IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME, then a line of X Y POINT3D_ID
//                 triples; the line is empty for an image without keypoints
//   points3D.txt  POINT3D_ID X Y Z R G B ERROR, then IMAGE_ID POINT2D_IDX pairs on the same line
#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <limits>
#include <optional>
#include <string_view>
#include <type_traits>

#include "core/error.h"
#include "core/printable.h"
#include "ingest/colmap/colmap_model.h"
#include "ingest/colmap/model_bytes.h"

namespace cairn {
namespace {

constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
// The keypoints of an image are one line.
constexpr size_t kMaxLineBytes = size_t{512} << 20;

// The rest of a whole number that a program wrote as 1024.0.
template <typename T>
bool IsZeroFraction(std::string_view rest) {
  return std::is_integral_v<T> && rest.starts_with('.') &&
         rest.find_first_not_of('0', 1) == rest.npos;
}

// Reads the lines of a file and the words of the current line.
class TextFile {
 public:
  TextFile(const std::string& model_dir, const char* name)
      : path_(model_dir + "/" + name), bytes_(path_) {
    if (bytes_.Peek(kByteOrderMark.size()).starts_with(kByteOrderMark)) {
      bytes_.Skip(kByteOrderMark.size());
    }
  }

  [[noreturn]] void Throw(const std::string& what) const {
    throw Error(ErrorCode::kBadInput, fmt::format("{}: line {}: {}", path_, line_number_, what));
  }

  // Moves to the next line of any kind. Returns false at the end of the file.
  bool NextLine() {
    bytes_.Skip(num_line_bytes_);  // The words of the last line have been read.
    num_line_bytes_ = 0;
    if (bytes_.remaining() == 0) {
      return false;
    }
    ++line_number_;
    line_ = PeekLine();
    num_line_bytes_ = line_.size();
    if (line_.ends_with('\n')) {
      line_.remove_suffix(1);
    }
    if (line_.ends_with('\r')) {
      line_.remove_suffix(1);
    }
    if (line_.find('\r') != line_.npos) {
      Throw("the lines end with CR alone; make the file anew with line feeds");
    }
    return true;
  }

  // Moves to the next line that is neither blank nor a comment.
  bool NextRecord() {
    while (NextLine()) {
      SkipBlanks();
      if (!line_.empty() && !line_.starts_with('#')) {
        return true;
      }
    }
    return false;
  }

  bool AtEndOfLine() {
    SkipBlanks();
    return line_.empty();
  }

  std::string_view Word(const char* what) {
    SkipBlanks();
    if (line_.empty()) {
      Throw(fmt::format("{} is missing", what));
    }
    const std::string_view word = line_.substr(0, line_.find_first_of(" \t"));
    line_.remove_prefix(word.size());
    return word;
  }

  // The rest of the line, without surrounding blanks.
  std::string Rest(const char* what) {
    if (AtEndOfLine()) {
      Throw(fmt::format("{} is missing", what));
    }
    return std::string(line_.substr(0, line_.find_last_not_of(" \t") + 1));
  }

  template <typename T>
  T Number(const char* what) {
    const std::string_view word = Word(what);
    const bool has_plus = word.size() > 1 && word[0] == '+' && word[1] != '-';
    const char* const word_end = word.data() + word.size();
    T value{};
    const auto [end, error] = std::from_chars(word.data() + (has_plus ? 1 : 0), word_end, value);
    if (error != std::errc() || !(end == word_end || IsZeroFraction<T>({end, word_end}))) {
      Throw(fmt::format("'{}' is not a valid {}", Excerpt(word), what));
    }
    if constexpr (std::is_floating_point_v<T>) {
      if (!std::isfinite(value)) {
        Throw(fmt::format("the {} is not finite", what));
      }
    }
    return value;
  }

 private:
  // Returns the line up to its end, with the line feed unless the file ends before.
  std::string_view PeekLine() {
    size_t num_searched = 0;
    for (size_t num_bytes = 256;; num_bytes *= 2) {
      const std::string_view bytes = bytes_.Peek(num_bytes);
      const size_t end = bytes.find('\n', num_searched);
      const std::string_view line = bytes.substr(0, end == bytes.npos ? end : end + 1);
      if (line.find('\0', num_searched) != line.npos) {
        Throw("the file is not UTF-8 text: it has zero bytes");
      }
      if (end != bytes.npos || bytes.size() < num_bytes) {
        return line;
      }
      if (bytes.size() > kMaxLineBytes) {
        Throw(fmt::format("the line is longer than {} MiB", kMaxLineBytes >> 20));
      }
      num_searched = bytes.size();
    }
  }

  void SkipBlanks() {
    const size_t begin = line_.find_first_not_of(" \t");
    line_.remove_prefix(begin == std::string_view::npos ? line_.size() : begin);
  }

  std::string path_;
  ModelBytes bytes_;
  std::string_view line_;  // What remains to be read of the line.
  size_t num_line_bytes_ = 0;
  int64_t line_number_ = 0;
};

void ReadCamera(TextFile* file, ColmapModel* model) {
  const auto camera_id = file->Number<uint32_t>("camera id");
  const std::string model_name(file->Word("camera model"));
  CameraModel camera_model{};
  try {
    camera_model = CameraModelFromName(model_name);
  } catch (const Error& e) {
    model->unsupported_cameras.insert_or_assign(camera_id, e.what());
    return;
  }
  const int width_px = file->Number<int>("width");
  const int height_px = file->Number<int>("height");
  std::vector<double> params;
  while (!file->AtEndOfLine()) {
    params.push_back(file->Number<double>("camera parameter"));
  }
  try {
    model->cameras.insert_or_assign(camera_id,
                                    Camera(camera_model, width_px, height_px, std::move(params)));
  } catch (const Error& e) {
    file->Throw(fmt::format("camera {}: {}", camera_id, e.what()));
  }
}

void ReadCameras(const std::string& model_dir, ColmapModel* model) {
  TextFile file(model_dir, "cameras.txt");
  while (file.NextRecord()) {
    ReadCamera(&file, model);
  }
}

Rigid3d ReadPose(TextFile* file) {
  double values[7];
  for (double& value : values) {
    value = file->Number<double>("pose");
  }
  const Eigen::Quaterniond rotation(values[0], values[1], values[2], values[3]);
  if (!(rotation.norm() > 1e-6)) {
    file->Throw("the rotation quaternion is zero");
  }
  return {rotation, Eigen::Vector3d(values[4], values[5], values[6])};
}

void ReadImages(const std::string& model_dir, ColmapModel* model) {
  TextFile file(model_dir, "images.txt");
  while (file.NextRecord()) {
    ColmapImage image;
    image.image_id = file.Number<uint32_t>("image id");
    image.cam_from_world = ReadPose(&file);
    image.camera_id = file.Number<uint32_t>("camera id");
    image.name = file.Rest("image name");
    if (!file.NextLine()) {
      file.Throw("the line of keypoints is missing");
    }
    while (!file.AtEndOfLine()) {
      if (image.pixels.size() == kMaxColmapKeypoints) {
        file.Throw(fmt::format("more than {} keypoints", kMaxColmapKeypoints));
      }
      const double x_px = file.Number<double>(
          "keypoint: each image needs a second line, that of its keypoints, which may be empty");
      const double y_px = file.Number<double>("keypoint");
      image.pixels.push_back(Eigen::Vector2d(x_px, y_px).cast<float>());
      file.Word("point id");  // points3D.txt has the same information.
    }
    model->images.push_back(std::move(image));
  }
}

void ReadPoints(const std::string& model_dir, ColmapModel* model) {
  TextFile file(model_dir, "points3D.txt");
  while (file.NextRecord()) {
    ColmapPoint point;
    file.Word("point id");
    for (double& coordinate : point.x_in_world) {
      coordinate = file.Number<double>("coordinate");
    }
    for (const char* skipped : {"red", "green", "blue", "reprojection error"}) {
      file.Word(skipped);
    }
    while (!file.AtEndOfLine()) {
      const auto image_id = file.Number<uint32_t>("image id");
      const auto keypoint_idx = file.Number<uint32_t>("keypoint index");
      point.track.emplace_back(image_id, keypoint_idx);
    }
    if (!point.track.empty()) {  // A point that no image sees is of no use.
      model->points.push_back(std::move(point));
    }
  }
}

}  // namespace

uint64_t CountImagesOfTextModel(const std::string& model_dir) {
  TextFile file(model_dir, "images.txt");
  uint64_t num_images = 0;
  while (file.NextRecord() && file.NextLine()) {
    ++num_images;
  }
  return num_images;
}

ColmapModel ReadTextColmapModel(const std::string& model_dir) {
  ColmapModel model;
  ReadCameras(model_dir, &model);
  ReadImages(model_dir, &model);
  ReadPoints(model_dir, &model);
  return model;
}

}  // namespace cairn
