// What the reading of a folder of photos gives, and all later stages of mapping take.
#ifndef CAIRN_MAPPING_PHOTO_SET_H_
#define CAIRN_MAPPING_PHOTO_SET_H_

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/camera.h"
#include "core/features.h"
#include "core/focal_length.h"
#include "core/geodesy.h"
#include "core/stored_descriptors.h"

namespace cairn {

enum class FocalSource {
  kCalibration,  // The user gave the intrinsics; they stay.
  kExif,         // Correct within about 5 %.
  kGuess,        // Nobody knows.
  kPhotos,       // Nobody knew, or EXIF was wrong: the two views of the set told it.
  kGrowth,       // As kPhotos, but a segment told it, about as well as EXIF does.
};

// The camera of one or more photos.
struct MappingCamera {
  Camera camera;
  // Of the camera before any adjustment. Without meaning if the source is kCalibration.
  FocalPrior focal;
  FocalSource source = FocalSource::kGuess;
  // True if something says that the picture may be a part of another, whose principal point may be
  // anywhere.
  bool may_be_cropped = false;

  // How little is known of the intrinsics: that of a camera whose principal point is unknown is as
  // a guess.
  FocalSource Certainty() const { return may_be_cropped ? FocalSource::kGuess : source; }
};

struct MappingPhoto {
  std::string name;  // Unique in the set.
  int camera_idx = 0;
  std::vector<Keypoint> keypoints;
  StoredDescriptors descriptors;  // A row a keypoint; SIFT's are whole numbers up to 255.
  // As ReconImage::gps and ReconImage::gps_accuracy_m.
  std::optional<Geodetic> gps;
  std::optional<double> gps_accuracy_m;
  bool gps_has_height = true;  // If false, `gps` has some height near that of the others, or 0.
};

struct PhotoSet {
  std::string descriptor_type = "sift";  // FeatureExtractor::descriptor_type.
  std::vector<MappingCamera> cameras;
  std::vector<MappingPhoto> photos;

  // Throws Error(kBadInput), naming the photo, if a camera index is out of range, keypoints and
  // descriptors differ in number, descriptors differ in length, or two photos have one name.
  void Validate() const;
};

}  // namespace cairn

#endif  // CAIRN_MAPPING_PHOTO_SET_H_
