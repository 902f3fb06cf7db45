#include "ingest/maps/archive_blocks.h"

#include <fmt/format.h>
#include <zstd.h>

#include <algorithm>
#include <cstring>
#include <utility>

#include "core/error.h"
#include "core/printable.h"
#include "ingest/maps/stored_values.h"
#include "storage/tile/camera_bytes.h"
#include "storage/tile/checksum.h"
#include "storage/tile/pose_bytes.h"

namespace cairn::archive {
namespace {

constexpr int kZstdLevel = 3;  // Zstandard's default.
constexpr size_t kBlockHeaderSize = 16;
constexpr size_t kBlockChecksumOffset = 8;

// How descriptors are stored.
constexpr uint8_t kFloat32 = 0;
constexpr uint8_t kUint8 = 1;

void RequireEnd(const ByteReader& reader, const std::string& what) {
  if (reader.remaining() != 0) {
    ThrowDamaged(what, "a block is longer than its content");
  }
}

void PutDescriptors(const PackedDescriptors& descriptors, ByteWriter* writer) {
  const bool as_bytes = descriptors.as_bytes() != nullptr;
  writer->Put(as_bytes ? kUint8 : kFloat32);
  stored::PutDescriptors(descriptors, as_bytes, writer);
}

PackedDescriptors GetDescriptors(size_t num_rows, int dim, const std::string& what,
                                 ByteReader* reader) {
  const auto kind = reader->Get<uint8_t>();
  const size_t num_values = num_rows * static_cast<size_t>(dim);
  if (kind != kFloat32 && kind != kUint8) {
    ThrowDamaged(what, "descriptors are of an unknown kind");
  }
  const size_t value_size = kind == kUint8 ? 1 : sizeof(float);
  if (reader->remaining() != num_values * value_size) {
    ThrowDamaged(what, "the descriptors of an image contradict its keypoints");
  }
  return stored::GetDescriptors(num_rows, static_cast<size_t>(dim), kind == kUint8, reader);
}

void PutKeypoints(const std::vector<Keypoint>& keypoints, ByteWriter* writer) {
  writer->Put(static_cast<uint32_t>(keypoints.size()));
  for (float Keypoint::*member :
       {&Keypoint::x_px, &Keypoint::y_px, &Keypoint::scale_px, &Keypoint::orientation_rad}) {
    for (const Keypoint& keypoint : keypoints) {
      writer->Put(keypoint.*member);
    }
  }
}

std::vector<Keypoint> GetKeypoints(const std::string& what, ByteReader* reader) {
  const auto count = reader->Get<uint32_t>();
  if (count > reader->remaining() / sizeof(Keypoint)) {
    ThrowDamaged(what, "an image ends too early");
  }
  std::vector<Keypoint> keypoints(count);
  for (float Keypoint::*member :
       {&Keypoint::x_px, &Keypoint::y_px, &Keypoint::scale_px, &Keypoint::orientation_rad}) {
    for (Keypoint& keypoint : keypoints) {
      keypoint.*member = reader->Get<float>();
    }
  }
  return keypoints;
}

Camera GetValidCamera(const std::string& what, ByteReader* reader) {
  try {
    return GetCamera(reader);
  } catch (const Error& error) {
    ThrowDamaged(what, error.what());
  }
}

}  // namespace

void ThrowDamaged(const std::string& what, const std::string& problem) {
  throw Error(ErrorCode::kMapDamaged, what + ": " + problem);
}

void RequireReadable(const std::istream& bytes, const std::string& what) {
  if (bytes.bad()) {
    throw Error(ErrorCode::kIo, what + ": cannot be read");
  }
}

std::vector<uint8_t> ReadExactly(std::istream* bytes, size_t size, const std::string& what) {
  constexpr size_t kStep = size_t{1} << 20;  // A file may be shorter than its header says.
  std::vector<uint8_t> read;
  while (read.size() < size) {
    const size_t begin = read.size();
    read.resize(std::min(size, begin + kStep));
    bytes->read(reinterpret_cast<char*>(read.data() + begin),
                static_cast<std::streamsize>(read.size() - begin));
    RequireReadable(*bytes, what);
    if (!*bytes) {
      ThrowDamaged(what, "ends too early");
    }
  }
  return read;
}

std::vector<uint8_t> EncodeBlock(std::span<const uint8_t> content) {
  if (content.size() > kMaxBlockBytes) {
    throw Error(ErrorCode::kBadInput,
                fmt::format("an image or a block of landmarks has {} bytes; an archive takes {}",
                            content.size(), kMaxBlockBytes));
  }
  std::vector<uint8_t> block(kBlockHeaderSize + ZSTD_compressBound(content.size()));
  const size_t stored_size =
      ZSTD_compress(block.data() + kBlockHeaderSize, block.size() - kBlockHeaderSize,
                    content.data(), content.size(), kZstdLevel);
  if (ZSTD_isError(stored_size)) {
    throw Error(ErrorCode::kInternal, std::string("zstd: ") + ZSTD_getErrorName(stored_size));
  }
  block.resize(kBlockHeaderSize + stored_size);
  const uint32_t sizes[] = {static_cast<uint32_t>(content.size()),
                            static_cast<uint32_t>(stored_size)};
  std::memcpy(block.data(), sizes, sizeof(sizes));
  const uint64_t checksum = ChecksumOf(block, kBlockChecksumOffset);
  std::memcpy(block.data() + kBlockChecksumOffset, &checksum, sizeof(checksum));
  return block;
}

std::vector<uint8_t> ReadBlock(std::istream* bytes, uint32_t max_block_bytes,
                               const std::string& what) {
  std::vector<uint8_t> block = ReadExactly(bytes, kBlockHeaderSize, what);
  ByteReader header(block, what);
  const auto size = header.Get<uint32_t>();
  const auto stored_size = header.Get<uint32_t>();
  const auto checksum = header.Get<uint64_t>();
  if (size > max_block_bytes || stored_size > ZSTD_compressBound(size)) {
    ThrowDamaged(what, "the size of a block is out of range");
  }
  const std::vector<uint8_t> stored = ReadExactly(bytes, stored_size, what);
  block.insert(block.end(), stored.begin(), stored.end());
  if (checksum != ChecksumOf(block, kBlockChecksumOffset)) {
    ThrowDamaged(what, "the checksum of a block does not match");
  }
  if (ZSTD_getFrameContentSize(stored.data(), stored.size()) != size) {
    ThrowDamaged(what, "a block has another size than it says");
  }
  std::vector<uint8_t> content(size);
  if (ZSTD_decompress(content.data(), size, stored.data(), stored.size()) != size) {
    ThrowDamaged(what, "a block does not decompress");
  }
  return content;
}

std::vector<uint8_t> EncodeCameras(const std::vector<Camera>& cameras) {
  std::vector<uint8_t> content;
  ByteWriter writer(&content);
  for (const Camera& camera : cameras) {
    PutCamera(camera, &writer);
  }
  return content;
}

std::vector<Camera> DecodeCameras(std::span<const uint8_t> content, size_t num_cameras,
                                  const std::string& what) {
  ByteReader reader(content, what);
  std::vector<Camera> cameras;
  for (size_t i = 0; i < num_cameras; ++i) {
    cameras.push_back(GetValidCamera(what, &reader));
  }
  RequireEnd(reader, what);
  return cameras;
}

std::vector<uint8_t> EncodeImage(const ReconImage& image) {
  std::vector<uint8_t> content;
  ByteWriter writer(&content);
  stored::PutText(image.name, &writer);
  writer.Put(static_cast<uint32_t>(image.camera_idx));
  PutPose(image.cam_from_world, &writer);
  PutKeypoints(image.features.keypoints, &writer);
  PutDescriptors(image.features.descriptors, &writer);
  return content;
}

ReconImage DecodeImage(std::span<const uint8_t> content, int descriptor_dim,
                       const std::string& what) {
  ByteReader reader(content, what);
  ReconImage image;
  image.name = stored::GetText(&reader);
  image.camera_idx = reader.Get<int32_t>();
  image.cam_from_world = GetPose(&reader);
  image.features.keypoints = GetKeypoints(what, &reader);
  const size_t num_keypoints = image.features.keypoints.size();
  image.features.descriptors =
      GetDescriptors(num_keypoints, num_keypoints == 0 ? 0 : descriptor_dim, what, &reader);
  return image;
}

std::vector<uint8_t> EncodeLandmarks(std::span<const ReconLandmark> landmarks) {
  std::vector<uint8_t> content;
  ByteWriter writer(&content);
  for (const ReconLandmark& landmark : landmarks) {
    PutPoint(landmark.x_in_world, &writer);
    writer.PutVarint(static_cast<uint32_t>(landmark.observations.size()));
    for (const ReconObservation& observation : landmark.observations) {
      writer.PutVarint(static_cast<uint32_t>(observation.image_idx));
      writer.PutVarint(static_cast<uint32_t>(observation.keypoint_idx));
    }
  }
  return content;
}

void DecodeLandmarks(std::span<const uint8_t> content, size_t num_landmarks,
                     const std::string& what, std::vector<ReconLandmark>* landmarks) {
  ByteReader reader(content, what);
  for (size_t i = 0; i < num_landmarks; ++i) {
    ReconLandmark landmark;
    landmark.x_in_world = GetPoint(&reader);
    const uint32_t num_observations = reader.GetVarint();
    if (num_observations > reader.remaining() / 2) {
      ThrowDamaged(what, "a landmark ends too early");
    }
    landmark.observations.resize(num_observations);
    for (ReconObservation& observation : landmark.observations) {
      observation.image_idx = static_cast<int>(reader.GetVarint());
      observation.keypoint_idx = static_cast<int>(reader.GetVarint());
    }
    landmarks->push_back(std::move(landmark));
  }
  RequireEnd(reader, what);
}

}  // namespace cairn::archive
