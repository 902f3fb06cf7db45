#include "mapping/photo_set.h"

#include <fmt/format.h>

#include <optional>
#include <set>
#include <string_view>

#include "core/error.h"

namespace cairn {

void PhotoSet::Validate() const {
  std::set<std::string_view> names;
  std::optional<Eigen::Index> descriptor_dim;
  for (const MappingPhoto& photo : photos) {
    const auto require = [&](bool condition, const char* problem) {
      if (!condition) {
        throw Error(ErrorCode::kBadInput, fmt::format("photo {}: {}", photo.name, problem));
      }
    };
    require(names.insert(photo.name).second, "a second photo has this name; rename one");
    require(photo.camera_idx >= 0 && photo.camera_idx < static_cast<int>(cameras.size()),
            "its camera is not in the set");
    require(static_cast<int64_t>(photo.keypoints.size()) == photo.descriptors.rows(),
            "keypoints and descriptors differ in number");
    if (!photo.keypoints.empty()) {
      require(descriptor_dim.value_or(photo.descriptors.cols()) == photo.descriptors.cols(),
              "its descriptors have another length than those of the photos before it");
      descriptor_dim = photo.descriptors.cols();
    }
  }
}

}  // namespace cairn
