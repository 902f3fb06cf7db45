#include "ingest/session_digest.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdint>
#include <string_view>
#include <type_traits>

#include "core/logging.h"
#include "core/printable.h"
#include "ingest/ingest_option_visit.h"
#include "ingest/session_refused.h"
#include "storage/tile/content_digest.h"

namespace cairn {
namespace {

// Numbers and texts in a row. Numbers go in one by one, so that padding does not count.
class Hasher {
 public:
  template <typename T>
  requires(std::is_arithmetic_v<T> || std::is_enum_v<T>) void Add(const T& value) {
    hash_.Add({reinterpret_cast<const uint8_t*>(&value), sizeof(value)});
  }
  void Add(const std::string& text) {
    Add(text.size());
    hash_.Add({reinterpret_cast<const uint8_t*>(text.data()), text.size()});
  }
  template <typename Derived>
  void Add(const Eigen::DenseBase<Derived>& numbers) {
    Add(numbers.rows());
    for (Eigen::Index row = 0; row < numbers.rows(); ++row) {
      for (Eigen::Index col = 0; col < numbers.cols(); ++col) {
        Add(numbers(row, col));
      }
    }
  }
  void Add(const Rigid3d& pose) {
    Add(pose.rotation.coeffs());
    Add(pose.translation);
  }

  std::string Hex() const { return hash_.Hex(); }

 private:
  ContentHash hash_;
};

void AddImage(const ReconImage& image, Hasher* hasher) {
  hasher->Add(image.name);
  hasher->Add(image.camera_idx);
  hasher->Add(image.cam_from_world);
  hasher->Add(image.features.keypoints.size());
  for (const Keypoint& keypoint : image.features.keypoints) {
    hasher->Add(keypoint.x_px);
    hasher->Add(keypoint.y_px);
    hasher->Add(keypoint.scale_px);
    hasher->Add(keypoint.orientation_rad);
  }
  hasher->Add(image.features.descriptors.Unpacked());
}

// Adds options in the order of their description. A changed order would make a new ingest of every
// session in every map.
class OptionHasher {
 public:
  explicit OptionHasher(Hasher* hasher) : hasher_(*hasher) {}

  template <typename T>
  void Visit(std::string_view, const T& value, const OptionRange&, std::string_view) const {
    hasher_.Add(value);
  }
  template <typename Options>
  void Section(std::string_view, const Options& options, std::string_view) const {
    VisitOptions(options, *this);
  }

 private:
  Hasher& hasher_;
};

// The parts of a digest: the reconstruction, how it was ingested, and the photos.
constexpr size_t kRecordingDigits = 32, kIngestDigits = 48;
constexpr size_t kPhotoDigits = 8;
constexpr size_t kMaxPhotos = 1024;

// Fewer photos that two sessions share do little harm.
constexpr int kLeastShared = 3;
constexpr double kLeastShareOfPhotos = 0.05;

// The photos of a digest, ascending; none in a digest from before photos were a part of it.
std::vector<std::string_view> PhotosOf(std::string_view digest) {
  std::vector<std::string_view> photos;
  for (size_t at = kIngestDigits; at + kPhotoDigits <= digest.size(); at += kPhotoDigits) {
    photos.push_back(digest.substr(at, kPhotoDigits));
  }
  return photos;
}

}  // namespace

std::string DigestOf(const Reconstruction& reconstruction) {
  Hasher hasher;
  hasher.Add(reconstruction.descriptor_type);
  for (const Camera& camera : reconstruction.cameras) {
    hasher.Add(camera.model());
    for (const double number : camera.params()) {
      hasher.Add(number);
    }
  }
  for (const ReconImage& image : reconstruction.images) {
    AddImage(image, &hasher);
  }
  for (const ReconLandmark& landmark : reconstruction.landmarks) {
    hasher.Add(landmark.x_in_world);
    hasher.Add(landmark.observations.size());
    for (const ReconObservation& observation : landmark.observations) {
      hasher.Add(observation.image_idx);
      hasher.Add(observation.keypoint_idx);
    }
  }
  return hasher.Hex();
}

std::string DigestOf(const Sim3d& ecef_from_world, const IngestOptions& options) {
  Hasher hasher;
  hasher.Add(ecef_from_world.scale);
  hasher.Add(ecef_from_world.rotation.coeffs());
  hasher.Add(ecef_from_world.translation);
  hasher.Add(options.recorded_at);
  hasher.Add(options.joining);
  VisitOptions(options.selection, OptionHasher(&hasher));
  VisitOptions(options.appearance, OptionHasher(&hasher));
  hasher.Add(options.max_sigma_m);
  hasher.Add(options.max_reprojection_error_px);
  VisitOptions(options.upkeep, OptionHasher(&hasher));
  // Sessions of before that there was a choice keep their digests.
  if (options.fitting != SessionFitting::kBend) {
    hasher.Add(options.fitting);
  }
  return hasher.Hex().substr(16);
}

std::string PhotosDigestOf(const Reconstruction& reconstruction) {
  std::vector<std::string> photos;
  for (const ReconImage& image : reconstruction.images) {
    if (image.features.size() > 0) {
      Hasher hasher;
      hasher.Add(image.features.descriptors.Unpacked());
      photos.push_back(hasher.Hex().substr(0, kPhotoDigits));
    }
  }
  std::sort(photos.begin(), photos.end());
  photos.erase(std::unique(photos.begin(), photos.end()), photos.end());
  photos.resize(std::min(photos.size(), kMaxPhotos));
  return fmt::format("{}", fmt::join(photos, ""));
}

bool AreOneIngest(const std::string& digest_a, const std::string& digest_b) {
  return digest_a.substr(0, kIngestDigits) == digest_b.substr(0, kIngestDigits);
}

std::string IngestDigestOf(const SessionRecord& session) {
  return session.content_digest.substr(0, kIngestDigits);
}

bool AreOneRecording(const SessionRecord& a, const SessionRecord& b) {
  return !a.content_digest.empty() && a.content_digest.substr(0, kRecordingDigits) ==
                                          b.content_digest.substr(0, kRecordingDigits);
}

SharedPhotos CountSharedPhotos(const SessionRecord& session, const SessionRecord& other) {
  const std::vector<std::string_view> photos = PhotosOf(session.content_digest);
  const std::vector<std::string_view> others = PhotosOf(other.content_digest);
  SharedPhotos shared;
  if (photos.empty() || others.empty()) {
    return shared;
  }
  // Up to the last photo of a full list, both lists are complete.
  const auto is_known_of = [](const std::vector<std::string_view>& list, std::string_view photo) {
    return list.size() < kMaxPhotos || photo <= list.back();
  };
  for (const std::string_view photo : photos) {
    if (is_known_of(others, photo)) {
      ++shared.num_compared;
      shared.num_shared += std::binary_search(others.begin(), others.end(), photo) ? 1 : 0;
    }
  }
  return shared;
}

bool AreMostlyNew(const SharedPhotos& shared) {
  return shared.num_shared < kLeastShared ||
         shared.num_shared < kLeastShareOfPhotos * shared.num_compared;
}

void RequireNotElsewhere(const SessionRecord& session, SessionJoining joining,
                         const std::vector<SessionRecord>& sessions) {
  if (joining != SessionJoining::kJoin) {
    return;
  }
  for (const SessionRecord& other : sessions) {
    if (other.name == session.name) {
      continue;
    }
    if (AreOneRecording(session, other)) {
      throw SessionRefused(
          fmt::format("the map has the same reconstruction as session '{}'; keep it apart from "
                      "what the map knows (--apart) if it belongs there twice",
                      Excerpt(other.name)));
    }
    const SharedPhotos shared = CountSharedPhotos(session, other);
    if (!AreMostlyNew(shared)) {
      throw SessionRefused(
          fmt::format("{} of the {} photos that were compared are in the map already: session "
                      "'{}' has photos with the same features. Leave them out (--images), replace "
                      "that session (--session), or keep this one apart from what the map knows "
                      "(--apart) if they belong there twice",
                      shared.num_shared, shared.num_compared, Excerpt(other.name)));
    }
  }
}

void WarnOfSharedPhotos(const SessionRecord& session, const std::vector<SessionRecord>& sessions) {
  for (const SessionRecord& other : sessions) {
    const SharedPhotos shared = CountSharedPhotos(session, other);
    if (other.name != session.name && shared.num_shared > 0) {
      LogWarning("{} of the {} photos that were compared are in the map already, in session '{}'",
                 shared.num_shared, shared.num_compared, Excerpt(other.name));
    }
  }
}

}  // namespace cairn
