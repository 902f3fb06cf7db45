#include "ingest/maps/archive_codec.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include "core/error.h"
#include "ingest/maps/archive_blocks.h"
#include "ingest/maps/stored_values.h"
#include "storage/map/utc_time.h"
#include "storage/tile/byte_io.h"
#include "storage/tile/checksum.h"
#include "storage/tile/pose_bytes.h"

namespace cairn {
namespace {

using archive::ThrowDamaged;
using stored::GetText;
using stored::PutText;

constexpr uint32_t kMagic = 0x53455343;  // "CSES".
constexpr uint16_t kVersion = 1;
constexpr size_t kHeaderSize = 24;
constexpr size_t kChecksumOffset = 16;
constexpr uint32_t kMaxManifestBytes = uint32_t{1} << 20;
constexpr size_t kSessionDigestSize = 48;
constexpr size_t kMaxTypeLength = 32;
constexpr uint32_t kMaxDescriptorDim = 4096;

constexpr uint64_t kMaxId = uint64_t{1} << 48;

void PutIds(const FirstIds& ids, ByteWriter* writer) {
  for (const uint64_t id :
       {static_cast<uint64_t>(Value(ids.codebook)), static_cast<uint64_t>(Value(ids.session)),
        static_cast<uint64_t>(Value(ids.keyframe)), Value(ids.landmark)}) {
    writer->Put(id);
  }
}

FirstIds GetIds(const std::string& what, ByteReader* reader) {
  uint64_t ids[4];
  reader->GetArray(std::span<uint64_t>(ids));
  if (std::ranges::any_of(ids, [](uint64_t id) { return id > kMaxId; })) {
    ThrowDamaged(what, "an id is out of range");
  }
  return {CodebookId(static_cast<int64_t>(ids[0])), SessionId(static_cast<int64_t>(ids[1])),
          KeyframeId(static_cast<int64_t>(ids[2])), LandmarkId(ids[3])};
}

void PutKey(const SessionKey& key, ByteWriter* writer) {
  PutText(key.name, writer);
  PutText(key.content_digest, writer);
}

SessionKey GetKey(ByteReader* reader) {
  SessionKey key;
  key.name = GetText(reader);
  key.content_digest = GetText(reader);
  return key;
}

std::vector<uint8_t> EncodeManifest(const ArchiveManifest& manifest,
                                    const Reconstruction& reconstruction) {
  std::vector<uint8_t> bytes;
  ByteWriter writer(&bytes);
  PutText(manifest.session.name, &writer);
  PutText(manifest.source, &writer);
  PutText(manifest.given_recorded_at, &writer);
  PutText(manifest.recorded_at, &writer);
  PutText(manifest.session.content_digest, &writer);
  PutText(manifest.options_json, &writer);
  PutText(manifest.map_created_at, &writer);
  PutIds(manifest.first_ids, &writer);
  writer.Put(static_cast<uint8_t>(manifest.is_apart ? 1 : 0));
  writer.Put(manifest.georef_median_residual_m);
  writer.Put(manifest.ecef_from_world.scale);
  PutRotation(manifest.ecef_from_world.rotation, &writer);
  PutPoint(manifest.ecef_from_world.translation, &writer);
  PutText(reconstruction.descriptor_type, &writer);
  writer.Put(static_cast<uint32_t>(reconstruction.descriptor_dim()));
  writer.Put(static_cast<uint32_t>(reconstruction.cameras.size()));
  writer.Put(static_cast<uint32_t>(reconstruction.images.size()));
  writer.Put(static_cast<uint32_t>(reconstruction.landmarks.size()));
  writer.Put(static_cast<uint32_t>(manifest.earlier_sessions.size()));
  for (const SessionKey& key : manifest.earlier_sessions) {
    PutKey(key, &writer);
  }
  return bytes;
}

std::vector<uint8_t> EncodeHeader(const std::vector<uint8_t>& manifest) {
  if (manifest.size() > kMaxManifestBytes) {
    throw Error(ErrorCode::kBadInput,
                fmt::format("the names and options of a session have {} bytes; an archive takes {}",
                            manifest.size(), kMaxManifestBytes));
  }
  std::vector<uint8_t> bytes;
  ByteWriter writer(&bytes);
  writer.Put(kMagic);
  writer.Put(kVersion);
  writer.Put(uint16_t{0});
  writer.Put(static_cast<uint32_t>(manifest.size()));
  writer.Put(uint32_t{0});
  writer.Put(uint64_t{0});
  writer.PutArray(std::span<const uint8_t>(manifest));
  const uint64_t checksum = ChecksumOf(bytes, kChecksumOffset);
  std::memcpy(bytes.data() + kChecksumOffset, &checksum, sizeof(checksum));
  return bytes;
}

// Returns the manifest's bytes.
std::vector<uint8_t> ReadHeader(std::istream* bytes, const std::string& what) {
  std::vector<uint8_t> header = archive::ReadExactly(bytes, kHeaderSize, what);
  ByteReader reader(header, what);
  if (reader.Get<uint32_t>() != kMagic) {
    ThrowDamaged(what, "does not start with CSES");
  }
  if (const auto version = reader.Get<uint16_t>(); version != kVersion) {
    ThrowDamaged(what, fmt::format("format version {} is unknown, expected {}", version, kVersion));
  }
  const auto reserved = reader.Get<uint16_t>();
  const auto size = reader.Get<uint32_t>();
  if (reader.Get<uint32_t>() != 0 || reserved != 0 || size > kMaxManifestBytes) {
    ThrowDamaged(what, "a number in the header is out of range");
  }
  const auto checksum = reader.Get<uint64_t>();
  const std::vector<uint8_t> manifest = archive::ReadExactly(bytes, size, what);
  header.insert(header.end(), manifest.begin(), manifest.end());
  if (checksum != ChecksumOf(header, kChecksumOffset)) {
    ThrowDamaged(what, "the checksum of the header does not match");
  }
  return manifest;
}

bool IsPlacement(const Sim3d& ecef_from_world) {
  return std::isfinite(ecef_from_world.scale) && ecef_from_world.scale > 0.0 &&
         ecef_from_world.translation.allFinite() &&
         std::abs(ecef_from_world.rotation.norm() - 1.0) < 1e-6;
}

bool IsSessionDigest(const std::string& text) {
  return text.size() == kSessionDigestSize &&
         text.find_first_not_of("0123456789abcdef") == std::string::npos;
}

bool HasTimes(const ArchiveManifest& manifest) {
  const std::string& given = manifest.given_recorded_at;
  return IsUtcTime(manifest.recorded_at) && IsUtcTime(manifest.map_created_at) &&
         (given.empty() || IsUtcTime(given));
}

std::string FindProblem(const ArchiveManifest& manifest) {
  if (manifest.session.name.empty()) {
    return "the session has no name";
  }
  if (!IsSessionDigest(manifest.session.content_digest)) {
    return "the content digest is malformed";
  }
  if (!HasTimes(manifest)) {
    return "a time is not like 2026-01-31T12:00:00Z";
  }
  if (!std::isfinite(manifest.georef_median_residual_m) || !IsPlacement(manifest.ecef_from_world)) {
    return "the placement is no similarity";
  }
  if (manifest.descriptor_type.empty() || manifest.descriptor_type.size() > kMaxTypeLength) {
    return "the descriptor type has a wrong length";
  }
  return "";
}

ArchiveManifest ParseManifest(const std::vector<uint8_t>& bytes, const std::string& what) {
  ByteReader reader(bytes, what);
  ArchiveManifest manifest;
  manifest.session.name = GetText(&reader);
  manifest.source = GetText(&reader);
  manifest.given_recorded_at = GetText(&reader);
  manifest.recorded_at = GetText(&reader);
  manifest.session.content_digest = GetText(&reader);
  manifest.options_json = GetText(&reader);
  manifest.map_created_at = GetText(&reader);
  manifest.first_ids = GetIds(what, &reader);
  const auto is_apart = reader.Get<uint8_t>();
  manifest.is_apart = is_apart == 1;
  manifest.georef_median_residual_m = reader.Get<double>();
  manifest.ecef_from_world.scale = reader.Get<double>();
  manifest.ecef_from_world.rotation = GetRotation(&reader);
  manifest.ecef_from_world.translation = GetPoint(&reader);
  manifest.descriptor_type = GetText(&reader);
  const auto descriptor_dim = reader.Get<uint32_t>();
  manifest.num_cameras = reader.Get<uint32_t>();
  manifest.num_images = reader.Get<uint32_t>();
  manifest.num_landmarks = reader.Get<uint32_t>();
  for (auto num_earlier = reader.Get<uint32_t>(); num_earlier > 0; --num_earlier) {
    manifest.earlier_sessions.push_back(GetKey(&reader));
  }
  if (reader.remaining() != 0 || is_apart > 1 || descriptor_dim > kMaxDescriptorDim) {
    ThrowDamaged(what, "a number in the manifest is out of range");
  }
  manifest.descriptor_dim = static_cast<int>(descriptor_dim);
  if (const std::string problem = FindProblem(manifest); !problem.empty()) {
    ThrowDamaged(what, problem);
  }
  return manifest;
}

Reconstruction ReadReconstruction(const ArchiveManifest& manifest, const ArchiveLimits& limits,
                                  std::istream* bytes, const std::string& what) {
  const auto next_block = [&] { return archive::ReadBlock(bytes, limits.max_block_bytes, what); };
  Reconstruction reconstruction;
  reconstruction.descriptor_type = manifest.descriptor_type;
  reconstruction.cameras = archive::DecodeCameras(next_block(), manifest.num_cameras, what);
  for (size_t i = 0; i < manifest.num_images; ++i) {
    reconstruction.images.push_back(
        archive::DecodeImage(next_block(), manifest.descriptor_dim, what));
  }
  std::vector<ReconLandmark>& landmarks = reconstruction.landmarks;
  while (landmarks.size() < manifest.num_landmarks) {
    const size_t count =
        std::min(archive::kLandmarksPerBlock, manifest.num_landmarks - landmarks.size());
    archive::DecodeLandmarks(next_block(), count, what, &landmarks);
  }
  return reconstruction;
}

}  // namespace

void EncodeSession(const ArchiveManifest& manifest, const Reconstruction& reconstruction,
                   const ByteSink& sink) {
  sink(EncodeHeader(EncodeManifest(manifest, reconstruction)));
  sink(archive::EncodeBlock(archive::EncodeCameras(reconstruction.cameras)));
  for (const ReconImage& image : reconstruction.images) {
    sink(archive::EncodeBlock(archive::EncodeImage(image)));
  }
  const std::span<const ReconLandmark> landmarks = reconstruction.landmarks;
  for (size_t begin = 0; begin < landmarks.size(); begin += archive::kLandmarksPerBlock) {
    const size_t count = std::min(archive::kLandmarksPerBlock, landmarks.size() - begin);
    sink(archive::EncodeBlock(archive::EncodeLandmarks(landmarks.subspan(begin, count))));
  }
}

ArchiveManifest DecodeManifest(std::istream* bytes, const std::string& what) {
  return ParseManifest(ReadHeader(bytes, what), what);
}

ArchivedSession DecodeSession(std::istream* bytes, const std::string& what,
                              const ArchiveLimits& limits) {
  ArchivedSession session;
  session.manifest = DecodeManifest(bytes, what);
  session.reconstruction = ReadReconstruction(session.manifest, limits, bytes, what);
  const bool is_longer = bytes->peek() != std::istream::traits_type::eof();
  archive::RequireReadable(*bytes, what);
  if (is_longer) {
    ThrowDamaged(what, "is longer than its content");
  }
  try {
    session.reconstruction.Validate();
  } catch (const Error& error) {
    ThrowDamaged(what, error.what());
  }
  return session;
}

}  // namespace cairn
