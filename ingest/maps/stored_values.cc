#include "ingest/maps/stored_values.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

namespace cairn::stored {

void PutText(const std::string& text, ByteWriter* writer) {
  writer->Put(static_cast<uint32_t>(text.size()));
  writer->PutArray(std::span<const char>(text));
}

std::string GetText(ByteReader* reader) {
  const std::span<const uint8_t> bytes = reader->Take(reader->Get<uint32_t>());
  return {bytes.begin(), bytes.end()};
}

void PutCamera(const Camera& camera, ByteWriter* writer) {
  writer->Put(static_cast<int32_t>(camera.model()));
  writer->Put(static_cast<int32_t>(camera.width_px()));
  writer->Put(static_cast<int32_t>(camera.height_px()));
  writer->PutArray(std::span<const double>(camera.params()));
}

Camera GetCamera(ByteReader* reader) {
  const CameraModel model = CameraModelFromColmapId(reader->Get<int32_t>());
  const auto width_px = reader->Get<int32_t>();
  const auto height_px = reader->Get<int32_t>();
  return {model, width_px, height_px,
          reader->GetVector<double>(static_cast<size_t>(NumCameraParams(model)))};
}

bool AreBytes(const DescriptorMatrix& descriptors) {
  return std::all_of(descriptors.data(), descriptors.data() + descriptors.size(), [](float value) {
    return value >= 0.0f && value <= 255.0f && value == std::floor(value) && !std::signbit(value);
  });
}

void PutDescriptors(const DescriptorMatrix& descriptors, bool as_bytes, ByteWriter* writer) {
  const std::span<const float> values(descriptors.data(), descriptors.size());
  if (!as_bytes) {
    return writer->PutArray(values);
  }
  const std::vector<uint8_t> bytes(values.begin(), values.end());
  writer->PutArray(std::span<const uint8_t>(bytes));
}

DescriptorMatrix GetDescriptors(size_t num_rows, size_t dim, bool as_bytes, ByteReader* reader) {
  const size_t num_values = num_rows * dim;
  const std::span<const uint8_t> bytes =
      reader->Take(num_values * (as_bytes ? 1 : sizeof(float)));  // Before there is memory for it.
  DescriptorMatrix descriptors(static_cast<Eigen::Index>(num_rows), static_cast<Eigen::Index>(dim));
  if (as_bytes) {
    std::ranges::copy(bytes, descriptors.data());
  } else if (!bytes.empty()) {
    std::memcpy(descriptors.data(), bytes.data(), bytes.size());
  }
  return descriptors;
}

}  // namespace cairn::stored
