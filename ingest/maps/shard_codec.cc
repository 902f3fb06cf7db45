#include "ingest/maps/shard_codec.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <utility>

#include "ingest/maps/image_row.h"
#include "ingest/maps/require_input.h"
#include "ingest/maps/stored_values.h"
#include "storage/tile/byte_io.h"
#include "storage/tile/pose_bytes.h"

namespace cairn {
namespace {

constexpr uint32_t kShardMagic = 0x44485343;  // "CSHD".
constexpr uint32_t kShardVersion = 1;
constexpr uint32_t kMaxDescriptorDim = 4096;
constexpr uint32_t kFloatDescriptors = 0, kByteDescriptors = 1;
constexpr size_t kLandmarkBytes = 44;

int64_t CountObservations(const TileShard& shard) {
  int64_t count = 0;
  for (const auto& observations : shard.session.observations_of_image) {
    count += std::ssize(observations);
  }
  return count;
}

PackedDescriptors GetDescriptors(size_t num_rows, uint32_t dim, uint32_t encoding,
                                 ByteReader* reader) {
  const size_t element_bytes = encoding == kFloatDescriptors ? sizeof(float) : 1;
  RequireInput(num_rows <= reader->remaining() / (dim * element_bytes),
               "ends before its descriptors");
  PackedDescriptors descriptors =
      stored::GetDescriptors(num_rows, dim, encoding == kByteDescriptors, reader);
  RequireInput(descriptors.as_bytes() != nullptr || descriptors.Unpacked().allFinite(),
               "a descriptor is not finite");
  return descriptors;
}

void PutImage(const TileShard& shard, size_t image_idx, uint32_t encoding, ByteWriter* writer) {
  const ReconImage& image = shard.reconstruction.images[image_idx];
  KeyframeRecord row;
  row.id = shard.keyframe_ids[image_idx];
  row.image_name = image.name;
  row.camera = shard.reconstruction.cameras[image.camera_idx];
  row.cam_from_ecef = shard.session.cam_from_ecef[image_idx];
  PutImageRow(row, writer);
  const auto& observations = shard.session.observations_of_image[image_idx];
  writer->Put(static_cast<uint32_t>(observations.size()));
  for (const PlacedObservation& observation : observations) {
    writer->Put(observation.landmark_idx);
  }
  for (const Keypoint& keypoint : image.features.keypoints) {
    for (const float value :
         {keypoint.x_px, keypoint.y_px, keypoint.scale_px, keypoint.orientation_rad}) {
      writer->Put(value);
    }
  }
  stored::PutDescriptors(image.features.descriptors, encoding == kByteDescriptors, writer);
}

std::vector<PlacedObservation> GetObservations(size_t count, size_t num_landmarks,
                                               ByteReader* reader) {
  std::vector<PlacedObservation> observations;
  for (const uint32_t landmark_idx : reader->GetVector<uint32_t>(count)) {
    RequireInput(landmark_idx < num_landmarks, "an observation names an unknown landmark");
    observations.push_back({landmark_idx, static_cast<int>(observations.size())});
  }
  return observations;
}

std::vector<Keypoint> GetKeypoints(size_t count, ByteReader* reader) {
  RequireInput(count <= reader->remaining() / (4 * sizeof(float)), "ends before its keypoints");
  const std::vector<float> values = reader->GetVector<float>(4 * count);
  std::vector<Keypoint> keypoints;
  for (size_t i = 0; i < values.size(); i += 4) {
    const Keypoint keypoint = {values[i], values[i + 1], values[i + 2], values[i + 3]};
    RequireInput(std::isfinite(keypoint.x_px) && std::isfinite(keypoint.y_px) &&
                     std::isfinite(keypoint.scale_px) && !std::isinf(keypoint.orientation_rad),
                 "a keypoint is not finite");
    keypoints.push_back(keypoint);
  }
  return keypoints;
}

void GetImage(uint32_t dim, uint32_t encoding, ByteReader* reader, TileShard* shard) {
  KeyframeRecord row = GetImageRow(reader);
  const auto num_observations = reader->Get<uint32_t>();
  ReconImage image;
  image.name = std::move(row.image_name);
  image.camera_idx = static_cast<int>(shard->reconstruction.cameras.size());
  shard->session.observations_of_image.push_back(
      GetObservations(num_observations, shard->session.landmarks.size(), reader));
  image.features.keypoints = GetKeypoints(num_observations, reader);
  image.features.descriptors = GetDescriptors(num_observations, dim, encoding, reader);
  shard->reconstruction.cameras.push_back(row.camera);
  shard->reconstruction.images.push_back(std::move(image));
  shard->session.cam_from_ecef.push_back(row.cam_from_ecef);
  shard->keyframe_ids.push_back(row.id);
}

void PutLandmarks(const TileShard& shard, ByteWriter* writer) {
  for (size_t i = 0; i < shard.landmark_ids.size(); ++i) {
    const PlacedLandmark& landmark = shard.session.landmarks[i];
    writer->Put(Value(shard.landmark_ids[i]));
    PutPoint(landmark.x_in_ecef, writer);
    writer->Put(landmark.sigma_m);
    writer->Put(landmark.num_observations);
  }
}

void GetLandmarks(size_t count, ByteReader* reader, TileShard* shard) {
  RequireInput(count <= reader->remaining() / kLandmarkBytes, "ends before its landmarks");
  for (size_t i = 0; i < count; ++i) {
    PlacedLandmark landmark;
    shard->landmark_ids.push_back(LandmarkId(reader->Get<uint64_t>()));
    landmark.x_in_ecef = GetPoint(reader);
    landmark.sigma_m = reader->Get<double>();
    landmark.num_observations = reader->Get<uint32_t>();
    RequireInput(landmark.x_in_ecef.allFinite() && std::isfinite(landmark.sigma_m) &&
                     landmark.sigma_m >= 0.0,
                 "a landmark is not finite");
    shard->session.landmarks.push_back(landmark);
  }
}

uint32_t EncodingOf(const TileShard& shard) {
  const bool are_bytes = std::all_of(
      shard.reconstruction.images.begin(), shard.reconstruction.images.end(),
      [](const ReconImage& image) { return image.features.descriptors.as_bytes() != nullptr; });
  return are_bytes ? kByteDescriptors : kFloatDescriptors;
}

}  // namespace

std::vector<uint8_t> EncodeShard(const TileShard& shard) {
  const size_t num_images = shard.reconstruction.images.size();
  const int64_t dim = shard.reconstruction.descriptor_dim();
  const uint32_t encoding = EncodingOf(shard);
  std::vector<uint8_t> bytes;
  bytes.reserve(shard.base.size() +
                static_cast<size_t>(CountObservations(shard) * (20 + dim) +
                                    std::ssize(shard.landmark_ids) * int64_t{kLandmarkBytes}));
  ByteWriter writer(&bytes);
  writer.Put(kShardMagic);
  writer.Put(kShardVersion);
  writer.Put(shard.tile_id.value());
  writer.Put(static_cast<uint64_t>(shard.base.size()));
  writer.Put(static_cast<uint32_t>(num_images));
  writer.Put(static_cast<uint32_t>(shard.landmark_ids.size()));
  writer.Put(static_cast<uint32_t>(dim));
  writer.Put(encoding);
  PutLandmarks(shard, &writer);
  for (size_t i = 0; i < num_images; ++i) {
    PutImage(shard, i, encoding, &writer);
  }
  writer.PutArray(std::span<const uint8_t>(shard.base));
  return bytes;
}

TileShard DecodeShard(std::span<const uint8_t> bytes) {
  ByteReader reader(bytes, "shard");
  RequireInput(reader.Get<uint32_t>() == kShardMagic && reader.Get<uint32_t>() == kShardVersion,
               "does not start as a shard of version 1");
  TileShard shard;
  shard.tile_id = TileId::FromValue(reader.Get<uint64_t>());
  const auto num_base_bytes = reader.Get<uint64_t>();
  const auto num_images = reader.Get<uint32_t>();
  const auto num_landmarks = reader.Get<uint32_t>();
  const auto dim = reader.Get<uint32_t>();
  const auto encoding = reader.Get<uint32_t>();
  RequireInput(dim <= kMaxDescriptorDim && (dim > 0 || num_images == 0) &&
                   (encoding == kFloatDescriptors || encoding == kByteDescriptors),
               "a number in the header is out of range");
  GetLandmarks(num_landmarks, &reader, &shard);
  for (uint32_t i = 0; i < num_images; ++i) {
    GetImage(dim, encoding, &reader, &shard);
  }
  RequireInput(reader.remaining() == num_base_bytes, "has another length than its header says");
  const std::span<const uint8_t> base = reader.Take(num_base_bytes);
  shard.base.assign(base.begin(), base.end());
  if (num_images > 0) {
    std::vector<int>& images = shard.session.images_of_tile[shard.tile_id];
    images.resize(num_images);
    std::iota(images.begin(), images.end(), 0);
  }
  return shard;
}

}  // namespace cairn
