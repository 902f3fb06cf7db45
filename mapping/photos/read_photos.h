// Folders of photos become a PhotoSet: the first stage of mapping.
#ifndef CAIRN_MAPPING_PHOTOS_READ_PHOTOS_H_
#define CAIRN_MAPPING_PHOTOS_READ_PHOTOS_H_

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/camera.h"
#include "core/descriptor_file.h"
#include "core/features/feature_extractor.h"
#include "mapping/photo_set.h"
#include "mapping/work_folder.h"

namespace cairn {

struct ReadPhotosOptions {
  std::vector<Camera> cameras = {};  // Known intrinsics; see GroupCameras.
  // Keeps features, so that a second run need not extract them; null: none. Not owned.
  const WorkFolder* work = nullptr;
  int num_threads = 1;                               // The result does not depend on it.
  std::optional<uint64_t> available_bytes = {};      // Of memory, for all stages of mapping.
  std::shared_ptr<DescriptorFile> descriptors = {};  // Takes the descriptors; null: memory does.
  // Of several copies of a photo, the one of such a name is kept: those of a table of positions.
  std::set<std::string> names_to_keep = {};
};

struct LeftOutPhoto {
  std::string name;
  std::string reason;  // For people.
};

struct PhotoFolder {
  PhotoSet set;  // In the order of the names. Positions are those of the EXIF.
  // Of each photo: how to turn its pixels upright; nothing without EXIF.
  std::vector<std::optional<int>> orientation_of_photo;
  std::vector<LeftOutPhoto> left_out;
  std::vector<std::string> notes;  // For people.
  // Names the content of all photos, the extractor and the options: the same digest, the same set.
  std::string digest;
  // Photos whose EXIF states no hemisphere, and those whose position is void: ExifInfo.
  int num_without_hemisphere = 0, num_void_positions = 0;
  int num_from_work = 0;  // Photos whose features the work folder had.
};

using PhotosProgress = std::function<void(int done, int total)>;

// Photos that cannot be read, whose names do not end as that of a picture, or that are there twice
// are left out, each with a reason. Of copies, the one of `names_to_keep` stays, or else the one of
// the shortest name. `progress` is called by one thread at a time. Throws as FindPhotoFiles;
// Error(kBadInput), with reasons, if no photo can be read, or if mapping them would take more
// memory than there is; Error(kIo) if the work folder or the file of the descriptors cannot be
// written.
PhotoFolder ReadPhotos(const std::vector<std::string>& paths, const FeatureExtractor& extractor,
                       const ReadPhotosOptions& options, const PhotosProgress& progress = {});

}  // namespace cairn

#endif  // CAIRN_MAPPING_PHOTOS_READ_PHOTOS_H_
