#include "storage/codebook/codebook.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <span>

#include "core/error.h"
#include "storage/tile/byte_io.h"
#include "storage/tile/checksum.h"
#include "storage/tile/tile_checks.h"

namespace cairn {
namespace {

constexpr uint32_t kMagic = 0x4b424343;  // "CCBK".
constexpr uint16_t kVersion = 1;
constexpr size_t kHeaderSize = 40;
constexpr size_t kChecksumOffset = 32;
constexpr int kMaxRawDim = 4096;
constexpr int kMaxProjectedDim = 512;
constexpr size_t kMaxTypeLength = 32;
constexpr size_t kMaxQuantiles = 1000;

bool IsTypeName(const std::string& name) {
  return !name.empty() && name.size() <= kMaxTypeLength &&
         std::all_of(name.begin(), name.end(), [](char c) {
           return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_' || c == '.';
         });
}

bool AllFinite(std::span<const float> values) {
  return std::all_of(values.begin(), values.end(),
                     [](float value) { return std::isfinite(value); });
}

bool AreQuantiles(const std::vector<float>& values) {
  return values.size() <= kMaxQuantiles && AllFinite(values) &&
         std::is_sorted(values.begin(), values.end()) && (values.empty() || values.front() >= 0.0f);
}

// Returns the first problem with the sizes, or an empty string.
std::string FindShapeProblem(const Codebook& codebook) {
  if (codebook.raw_dim() < 1 || codebook.raw_dim() > kMaxRawDim) {
    return "descriptor dimension " + std::to_string(codebook.raw_dim()) + " is out of range";
  }
  if (codebook.projected_dim() < 1 || codebook.projected_dim() > kMaxProjectedDim) {
    return "projected dimension " + std::to_string(codebook.projected_dim()) + " is out of range";
  }
  if (codebook.projection.cols() != codebook.raw_dim()) {
    return "the projection does not fit the mean";
  }
  if (codebook.num_subspaces < 1 || codebook.num_subspaces > kMaxCodeSize ||
      codebook.projected_dim() % codebook.num_subspaces != 0) {
    return std::to_string(codebook.num_subspaces) + " subspaces do not divide " +
           std::to_string(codebook.projected_dim()) + " dimensions";
  }
  if (codebook.words.size() != size_t{Codebook::kNumWords} * codebook.projected_dim()) {
    return "the number of words is wrong";
  }
  return "";
}

std::string FindProblem(const Codebook& codebook) {
  if (!IsTypeName(codebook.descriptor_type)) {
    return "the descriptor type must be 1 to 32 characters of a-z, 0-9, '_' and '.'";
  }
  if (codebook.normalization != DescriptorNormalization::kNone &&
      codebook.normalization != DescriptorNormalization::kRootSift) {
    return "the normalization is unknown";
  }
  if (const std::string problem = FindShapeProblem(codebook); !problem.empty()) {
    return problem;
  }
  if (!codebook.mean.allFinite() || !codebook.projection.allFinite() ||
      !AllFinite(codebook.words)) {
    return "a number is not finite";
  }
  if (!AreQuantiles(codebook.same_landmark_distance_quantiles) ||
      !AreQuantiles(codebook.other_landmark_distance_quantiles)) {
    return "distance quantiles must be finite, not negative and ascending";
  }
  return "";
}

[[noreturn]] void ThrowDamaged(const std::string& problem) {
  throw Error(ErrorCode::kMapDamaged, "codebook: " + problem);
}

struct Header {
  uint8_t normalization = 0;
  uint8_t type_length = 0;
  uint32_t raw_dim = 0;
  uint32_t projected_dim = 0;
  uint32_t num_subspaces = 0;
  uint32_t num_same_quantiles = 0;
  uint32_t num_other_quantiles = 0;

  size_t TotalSize() const {
    const size_t num_floats = raw_dim + size_t{projected_dim} * raw_dim +
                              size_t{Codebook::kNumWords} * projected_dim + num_same_quantiles +
                              num_other_quantiles;
    return kHeaderSize + type_length + sizeof(float) * num_floats;
  }
};

Header GetHeader(std::span<const uint8_t> bytes) {
  ByteReader reader(bytes, "codebook");
  if (reader.Get<uint32_t>() != kMagic) {
    ThrowDamaged("does not start with CCBK");
  }
  if (const auto version = reader.Get<uint16_t>(); version != kVersion) {
    ThrowDamaged("format version " + std::to_string(version) + " is unknown, expected 1");
  }
  Header header;
  header.normalization = reader.Get<uint8_t>();
  header.type_length = reader.Get<uint8_t>();
  header.raw_dim = reader.Get<uint32_t>();
  header.projected_dim = reader.Get<uint32_t>();
  header.num_subspaces = reader.Get<uint32_t>();
  header.num_same_quantiles = reader.Get<uint32_t>();
  header.num_other_quantiles = reader.Get<uint32_t>();
  const auto reserved = reader.Get<uint32_t>();
  const auto checksum = reader.Get<uint64_t>();
  if (header.raw_dim > kMaxRawDim || header.projected_dim > kMaxProjectedDim ||
      header.num_subspaces > kMaxCodeSize || header.num_same_quantiles > kMaxQuantiles ||
      header.num_other_quantiles > kMaxQuantiles || reserved != 0) {
    ThrowDamaged("a number in the header is out of range");
  }
  if (bytes.size() != header.TotalSize()) {
    ThrowDamaged("is " + std::to_string(bytes.size()) + " bytes long, but its header says " +
                 std::to_string(header.TotalSize()));
  }
  if (checksum != ChecksumOf(bytes, kChecksumOffset)) {
    ThrowDamaged("checksum does not match");
  }
  return header;
}

}  // namespace

std::string Codebook::CodecName() const {
  return descriptor_type + "-" + std::to_string(raw_dim()) + "-" + std::to_string(projected_dim()) +
         "-" + std::to_string(Value(id));
}

void Codebook::Validate() const {
  if (const std::string problem = FindProblem(*this); !problem.empty()) {
    throw Error(ErrorCode::kBadInput, "codebook: " + problem);
  }
}

std::vector<uint8_t> EncodeCodebook(const Codebook& codebook) {
  codebook.Validate();
  std::vector<uint8_t> bytes;
  ByteWriter writer(&bytes);
  writer.Put(kMagic);
  writer.Put(kVersion);
  writer.Put(static_cast<uint8_t>(codebook.normalization));
  writer.Put(static_cast<uint8_t>(codebook.descriptor_type.size()));
  writer.Put(static_cast<uint32_t>(codebook.raw_dim()));
  writer.Put(static_cast<uint32_t>(codebook.projected_dim()));
  writer.Put(static_cast<uint32_t>(codebook.num_subspaces));
  writer.Put(static_cast<uint32_t>(codebook.same_landmark_distance_quantiles.size()));
  writer.Put(static_cast<uint32_t>(codebook.other_landmark_distance_quantiles.size()));
  writer.Put(uint32_t{0});
  writer.Put(uint64_t{0});  // Placeholder for the checksum.
  const std::string& type = codebook.descriptor_type;
  writer.PutArray(std::span<const char>(type));
  writer.PutArray(std::span<const float>(codebook.mean.data(), codebook.mean.size()));
  writer.PutArray(std::span<const float>(codebook.projection.data(), codebook.projection.size()));
  writer.PutArray(std::span<const float>(codebook.words));
  writer.PutArray(std::span<const float>(codebook.same_landmark_distance_quantiles));
  writer.PutArray(std::span<const float>(codebook.other_landmark_distance_quantiles));
  const uint64_t checksum = ChecksumOf(bytes, kChecksumOffset);
  std::memcpy(bytes.data() + kChecksumOffset, &checksum, sizeof(checksum));
  return bytes;
}

Codebook DecodeCodebook(const uint8_t* data, size_t size, CodebookId id) {
  const std::span<const uint8_t> bytes(data, size);
  const Header header = GetHeader(bytes);
  ByteReader reader(bytes.subspan(kHeaderSize), "codebook");
  Codebook codebook;
  codebook.id = id;
  codebook.normalization = static_cast<DescriptorNormalization>(header.normalization);
  codebook.num_subspaces = static_cast<int>(header.num_subspaces);
  codebook.descriptor_type.resize(header.type_length);
  reader.GetArray(std::span<char>(codebook.descriptor_type));
  codebook.mean.resize(header.raw_dim);
  reader.GetArray(std::span<float>(codebook.mean.data(), codebook.mean.size()));
  codebook.projection.resize(header.projected_dim, header.raw_dim);
  reader.GetArray(std::span<float>(codebook.projection.data(), codebook.projection.size()));
  codebook.words = reader.GetVector<float>(size_t{Codebook::kNumWords} * header.projected_dim);
  codebook.same_landmark_distance_quantiles = reader.GetVector<float>(header.num_same_quantiles);
  codebook.other_landmark_distance_quantiles = reader.GetVector<float>(header.num_other_quantiles);
  if (const std::string problem = FindProblem(codebook); !problem.empty()) {
    ThrowDamaged(problem);
  }
  return codebook;
}

}  // namespace cairn
