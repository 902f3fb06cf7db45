#include "mapping/session/stage_codec.h"

#include <utility>

#include "core/error.h"
#include "storage/tile/byte_io.h"
#include "storage/tile/camera_bytes.h"
#include "storage/tile/pose_bytes.h"

namespace cairn {
namespace {

[[noreturn]] void ThrowDamaged(const std::string& what) {
  throw Error(ErrorCode::kMapDamaged, what + ": does not fit the photos; remove the file");
}

int GetIndex(ByteReader* reader, size_t size, const std::string& what) {
  const uint32_t index = reader->Get<uint32_t>();
  if (index >= size) {
    ThrowDamaged(what);
  }
  return static_cast<int>(index);
}

void PutIndex(int index, ByteWriter* writer) {
  writer->Put<uint32_t>(static_cast<uint32_t>(index));
}

TwoView GetTwoView(const PhotoSet& set, ByteReader* reader, const std::string& what) {
  TwoView view;
  view.a = GetIndex(reader, set.photos.size(), what);
  view.b = GetIndex(reader, set.photos.size(), what);
  view.kind = reader->Get<uint8_t>() == 0 ? TwoViewKind::kGeneral : TwoViewKind::kRotationOnly;
  view.b_from_a = GetPose(reader);
  view.parallax_rad = reader->Get<double>();
  view.rotation_sigma_rad = reader->Get<double>();
  view.direction_sigma_rad = reader->Get<double>();
  view.focal_factor_a = reader->Get<double>();
  view.focal_factor_b = reader->Get<double>();
  const uint32_t count = reader->Get<uint32_t>();
  for (uint32_t i = 0; i < count; ++i) {
    FeatureMatch match;
    match.a_idx = GetIndex(reader, set.photos[view.a].keypoints.size(), what);
    match.b_idx = GetIndex(reader, set.photos[view.b].keypoints.size(), what);
    match.distance = reader->Get<float>();
    view.inliers.push_back(match);
  }
  return view;
}

void PutSegment(const Segment& segment, ByteWriter* writer) {
  const Reconstruction& model = segment.model;
  PutIndex(static_cast<int>(model.cameras.size()), writer);
  for (const Camera& camera : model.cameras) {
    PutCamera(camera, writer);
  }
  PutIndex(static_cast<int>(model.images.size()), writer);
  for (size_t i = 0; i < model.images.size(); ++i) {
    PutIndex(segment.photo_of_image[i], writer);
    PutIndex(model.images[i].camera_idx, writer);
    PutPose(model.images[i].cam_from_world, writer);
  }
  PutIndex(static_cast<int>(model.landmarks.size()), writer);
  for (const ReconLandmark& landmark : model.landmarks) {
    PutPoint(landmark.x_in_world, writer);
    PutIndex(static_cast<int>(landmark.observations.size()), writer);
    for (const ReconObservation& seen : landmark.observations) {
      PutIndex(seen.image_idx, writer);
      PutIndex(seen.keypoint_idx, writer);
    }
  }
}

ReconImage ImageOf(const MappingPhoto& photo) {
  ReconImage image;
  image.name = photo.name;
  image.features.keypoints = photo.keypoints;
  image.features.descriptors = PackedDescriptors(ByteDescriptorMatrix(photo.keypoints.size(), 0));
  image.gps = photo.gps;
  image.gps_accuracy_m = photo.gps_accuracy_m;
  return image;
}

Segment GetSegment(const PhotoSet& set, ByteReader* reader, const std::string& what) {
  Segment segment;
  Reconstruction& model = segment.model;
  if (reader->Get<uint32_t>() != set.cameras.size()) {
    ThrowDamaged(what);
  }
  for (size_t i = 0; i < set.cameras.size(); ++i) {
    model.cameras.push_back(GetCamera(reader));
  }
  const uint32_t num_images = reader->Get<uint32_t>();
  for (uint32_t i = 0; i < num_images; ++i) {
    const int photo = GetIndex(reader, set.photos.size(), what);
    ReconImage image = ImageOf(set.photos[photo]);
    image.camera_idx = GetIndex(reader, model.cameras.size(), what);
    image.cam_from_world = GetPose(reader);
    segment.photo_of_image.push_back(photo);
    model.images.push_back(std::move(image));
  }
  const uint32_t num_landmarks = reader->Get<uint32_t>();
  for (uint32_t i = 0; i < num_landmarks; ++i) {
    ReconLandmark landmark;
    landmark.x_in_world = GetPoint(reader);
    const uint32_t count = reader->Get<uint32_t>();
    for (uint32_t j = 0; j < count; ++j) {
      ReconObservation seen;
      seen.image_idx = GetIndex(reader, model.images.size(), what);
      seen.keypoint_idx =
          GetIndex(reader, model.images[seen.image_idx].features.keypoints.size(), what);
      landmark.observations.push_back(seen);
    }
    model.landmarks.push_back(std::move(landmark));
  }
  return segment;
}

}  // namespace

std::vector<uint8_t> EncodePairs(std::span<const std::pair<int, int>> pairs) {
  std::vector<uint8_t> bytes;
  ByteWriter writer(&bytes);
  PutIndex(static_cast<int>(pairs.size()), &writer);
  for (const auto& [a, b] : pairs) {
    PutIndex(a, &writer);
    PutIndex(b, &writer);
  }
  return bytes;
}

std::vector<std::pair<int, int>> DecodePairs(std::span<const uint8_t> bytes, const PhotoSet& set,
                                             const std::string& what) {
  ByteReader reader(bytes, what);
  const uint32_t count = reader.Get<uint32_t>();
  std::vector<std::pair<int, int>> pairs;
  for (uint32_t i = 0; i < count; ++i) {
    const int a = GetIndex(&reader, set.photos.size(), what);
    pairs.emplace_back(a, GetIndex(&reader, set.photos.size(), what));
  }
  return pairs;
}

std::vector<uint8_t> EncodeTwoViews(std::span<const TwoView> views) {
  std::vector<uint8_t> bytes;
  ByteWriter writer(&bytes);
  PutIndex(static_cast<int>(views.size()), &writer);
  for (const TwoView& view : views) {
    PutIndex(view.a, &writer);
    PutIndex(view.b, &writer);
    writer.Put<uint8_t>(view.kind == TwoViewKind::kGeneral ? 0 : 1);
    PutPose(view.b_from_a, &writer);
    for (const double value : {view.parallax_rad, view.rotation_sigma_rad, view.direction_sigma_rad,
                               view.focal_factor_a, view.focal_factor_b}) {
      writer.Put<double>(value);
    }
    PutIndex(static_cast<int>(view.inliers.size()), &writer);
    for (const FeatureMatch& match : view.inliers) {
      PutIndex(match.a_idx, &writer);
      PutIndex(match.b_idx, &writer);
      writer.Put<float>(match.distance);
    }
  }
  return bytes;
}

std::vector<TwoView> DecodeTwoViews(std::span<const uint8_t> bytes, const PhotoSet& set,
                                    const std::string& what) {
  ByteReader reader(bytes, what);
  const uint32_t count = reader.Get<uint32_t>();
  std::vector<TwoView> views;
  for (uint32_t i = 0; i < count; ++i) {
    views.push_back(GetTwoView(set, &reader, what));
  }
  return views;
}

std::vector<uint8_t> EncodeCameras(std::span<const MappingCamera> cameras) {
  std::vector<uint8_t> bytes;
  ByteWriter writer(&bytes);
  PutIndex(static_cast<int>(cameras.size()), &writer);
  for (const MappingCamera& camera : cameras) {
    PutCamera(camera.camera, &writer);
    writer.Put<double>(camera.focal.log_sigma);
    writer.Put<uint8_t>(camera.focal.with_distortion ? 1 : 0);
    writer.Put<uint8_t>(static_cast<uint8_t>(camera.source));
    writer.Put<uint8_t>(camera.may_be_cropped ? 1 : 0);
  }
  return bytes;
}

std::vector<MappingCamera> DecodeCameras(std::span<const uint8_t> bytes, const PhotoSet& set,
                                         const std::string& what) {
  ByteReader reader(bytes, what);
  if (reader.Get<uint32_t>() != set.cameras.size()) {
    ThrowDamaged(what);
  }
  std::vector<MappingCamera> cameras;
  for (const MappingCamera& known : set.cameras) {
    MappingCamera camera{GetCamera(&reader), {}, FocalSource::kGuess};
    camera.focal.log_sigma = reader.Get<double>();
    camera.focal.with_distortion = reader.Get<uint8_t>() != 0;
    const uint8_t source = reader.Get<uint8_t>();
    const uint8_t may_be_cropped = reader.Get<uint8_t>();
    if (source > static_cast<uint8_t>(FocalSource::kGrowth) || may_be_cropped > 1 ||
        camera.camera.width_px() != known.camera.width_px() ||
        camera.camera.height_px() != known.camera.height_px()) {
      ThrowDamaged(what);
    }
    camera.source = static_cast<FocalSource>(source);
    camera.may_be_cropped = may_be_cropped == 1;
    cameras.push_back(std::move(camera));
  }
  return cameras;
}

std::vector<uint8_t> EncodeGrowth(const Growth& growth) {
  std::vector<uint8_t> bytes;
  ByteWriter writer(&bytes);
  PutIndex(static_cast<int>(growth.verdict_of_photo.size()), &writer);
  for (const PhotoVerdict verdict : growth.verdict_of_photo) {
    writer.Put<uint8_t>(static_cast<uint8_t>(verdict));
  }
  PutIndex(static_cast<int>(growth.segments.size()), &writer);
  for (const Segment& segment : growth.segments) {
    PutSegment(segment, &writer);
  }
  return bytes;
}

Growth DecodeGrowth(std::span<const uint8_t> bytes, const PhotoSet& set, const std::string& what) {
  ByteReader reader(bytes, what);
  if (reader.Get<uint32_t>() != set.photos.size()) {
    ThrowDamaged(what);
  }
  Growth growth;
  for (size_t i = 0; i < set.photos.size(); ++i) {
    const uint8_t verdict = reader.Get<uint8_t>();
    if (verdict > static_cast<uint8_t>(PhotoVerdict::kLostSupport)) {
      ThrowDamaged(what);
    }
    growth.verdict_of_photo.push_back(static_cast<PhotoVerdict>(verdict));
  }
  const uint32_t num_segments = reader.Get<uint32_t>();
  for (uint32_t i = 0; i < num_segments; ++i) {
    growth.segments.push_back(GetSegment(set, &reader, what));
  }
  return growth;
}

std::vector<uint8_t> EncodeAdjusted(const AdjustedSegment& adjusted) {
  std::vector<uint8_t> bytes;
  ByteWriter writer(&bytes);
  const AdjustReport& report = adjusted.report;
  for (const double value : {adjusted.origin.lat_rad, adjusted.origin.lon_rad, adjusted.origin.h_m,
                             report.initial_cost, report.final_cost, report.rms_px}) {
    writer.Put<double>(value);
  }
  for (const int64_t count :
       {int64_t{report.num_rounds}, int64_t{report.num_iterations}, report.num_observations,
        report.num_observations_removed, report.num_landmarks_removed}) {
    writer.Put<int64_t>(count);
  }
  PutSegment(adjusted.segment, &writer);
  return bytes;
}

AdjustedSegment DecodeAdjusted(std::span<const uint8_t> bytes, const PhotoSet& set,
                               const std::string& what) {
  ByteReader reader(bytes, what);
  AdjustedSegment adjusted;
  AdjustReport& report = adjusted.report;
  for (double* value : {&adjusted.origin.lat_rad, &adjusted.origin.lon_rad, &adjusted.origin.h_m,
                        &report.initial_cost, &report.final_cost, &report.rms_px}) {
    *value = reader.Get<double>();
  }
  report.num_rounds = static_cast<int>(reader.Get<int64_t>());
  report.num_iterations = static_cast<int>(reader.Get<int64_t>());
  report.num_observations = reader.Get<int64_t>();
  report.num_observations_removed = reader.Get<int64_t>();
  report.num_landmarks_removed = reader.Get<int64_t>();
  adjusted.segment = GetSegment(set, &reader, what);
  return adjusted;
}

}  // namespace cairn
