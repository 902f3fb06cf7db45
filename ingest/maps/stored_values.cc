#include "ingest/maps/stored_values.h"

#include <cstdint>
#include <cstring>
#include <span>

namespace cairn::stored {

void PutText(const std::string& text, ByteWriter* writer) {
  writer->Put(static_cast<uint32_t>(text.size()));
  writer->PutArray(std::span<const char>(text));
}

std::string GetText(ByteReader* reader) {
  const std::span<const uint8_t> bytes = reader->Take(reader->Get<uint32_t>());
  return {bytes.begin(), bytes.end()};
}

void PutDescriptors(const PackedDescriptors& descriptors, bool as_bytes, ByteWriter* writer) {
  const auto put = [writer](const auto& values) {
    writer->PutArray(std::span(values.data(), static_cast<size_t>(values.size())));
  };
  if (as_bytes) {
    put(*descriptors.as_bytes()->Load());
  } else {
    put(descriptors.Unpacked());
  }
}

PackedDescriptors GetDescriptors(size_t num_rows, size_t dim, bool as_bytes, ByteReader* reader) {
  const size_t num_values = num_rows * dim;
  const std::span<const uint8_t> stored =
      reader->Take(num_values * (as_bytes ? 1 : sizeof(float)));  // Before there is memory for it.
  const auto rows = static_cast<Eigen::Index>(num_rows), cols = static_cast<Eigen::Index>(dim);
  if (as_bytes) {
    return PackedDescriptors(
        ByteDescriptorMatrix(Eigen::Map<const ByteDescriptorMatrix>(stored.data(), rows, cols)));
  }
  DescriptorMatrix values(rows, cols);
  if (!stored.empty()) {
    std::memcpy(values.data(), stored.data(), stored.size());
  }
  return values;
}

}  // namespace cairn::stored
