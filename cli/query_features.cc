#include "cli/query_features.h"

#include <fmt/format.h>

#include <cstdint>
#include <filesystem>
#include <system_error>

#include "cli/batch/photo_query.h"
#include "core/error.h"
#include "core/file_bytes.h"
#include "core/images/gray_image.h"
#include "core/printable.h"
#include "core/wire/feature_codec.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kMaxFileBytes = uint64_t{256} << 20;
constexpr int kMaxFeatures = 100'000;

void ReadFeatures(EvalQuery* query) {
  const std::vector<uint8_t> bytes = ReadFileBytes(query->features_path, kMaxFileBytes);
  try {
    WireFeatures wire = DecodeFeatures(bytes, kMaxFeatures);
    const Camera& camera = query->query.camera;
    if (wire.width_px != camera.width_px() || wire.height_px != camera.height_px()) {
      throw Error(
          ErrorCode::kBadInput,
          fmt::format("comes from an image of {} x {} pixels, but the camera's images have {} x {}",
                      wire.width_px, wire.height_px, camera.width_px(), camera.height_px()));
    }
    if (wire.features.size() == 0) {
      throw Error(ErrorCode::kBadInput, "has no features");
    }
    query->query.codec =
        wire.features.space == DescriptorSpace::kProjected ? wire.codec : std::string();
    query->query.features = std::move(wire.features);
  } catch (const std::runtime_error& error) {
    throw Error(ErrorCode::kBadInput, query->features_path + ": " + error.what());
  }
}

}  // namespace

void ReadQueryFeatures(std::vector<EvalQuery>* queries) {
  for (EvalQuery& query : *queries) {
    if (!query.features_path.empty()) {
      ReadFeatures(&query);
    }
  }
}

void RequirePhoto(const EvalQuery& query) {
  if (query.image_path.empty()) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("query {} needs its photo; give its folder (--image-dir, image_dir)",
                            Excerpt(query.name)));
  }
}

void ExtractQueryFeatures(const FeatureExtractor& extractor, EvalQuery* query) {
  RequirePhoto(*query);
  const GrayImage photo = ReadGrayImage(query->image_path);
  RequireSizeOf(query->query.camera, photo.picture_width_px(), photo.picture_height_px(),
                query->image_path);
  query->query.features = extractor.Extract(photo);
}

void WriteQueryListWithFeatures(const std::string& path, std::vector<EvalQuery>* queries) {
  const fs::path folder = fs::path(path).replace_extension().string() + "_features";
  std::error_code failure;
  fs::create_directories(folder, failure);
  for (EvalQuery& query : *queries) {
    query.features_path = (folder / (query.name + ".features")).string();
    WireFeatures wire;
    wire.features = query.query.features;
    wire.codec = query.query.codec;
    wire.width_px = query.query.camera.width_px();
    wire.height_px = query.query.camera.height_px();
    WriteFileBytes(query.features_path, EncodeFeatures(wire, LosslessEncoding(wire.features)));
  }
  WriteQueryList(path, *queries);
}

}  // namespace cairn
