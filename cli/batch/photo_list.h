// The photos of a folder or of a list, with what is known of each.
#ifndef CAIRN_CLI_BATCH_PHOTO_LIST_H_
#define CAIRN_CLI_BATCH_PHOTO_LIST_H_

#include <optional>
#include <string>
#include <vector>

#include "core/camera.h"
#include "core/geoid.h"
#include "engine/query/localize_query.h"

namespace cairn {

struct ListedPhoto {
  std::string name;  // As results call it.
  std::string path;
  std::optional<Camera> camera = {};
  std::optional<PositionPrior> prior = {};
};

// Reads the photos of a folder (FindPhotoFiles; FindMisnamedPhotos are logged), or those of a list:
// a text file with a photo a line, in its order. A line is the name of a photo, or hloc's `name
// MODEL width height param...` with COLMAP's models. A name is a path below `image_dir`; if that is
// empty, below the folder of the list. Blank lines and lines that begin with '#' do not count.
// Photos that are not there have the paths of those that MatchNames finds for them in that folder,
// or else keep a path that leads nowhere.
//
// Throws as FindPhotoFiles; Error(kBadInput), with file and line, for a malformed camera and for
// a name that comes twice, and if the list is empty.
std::vector<ListedPhoto> ReadPhotoList(const std::string& path, const std::string& image_dir);

// Gives the photos the positions of a table (ReadPositionsOfPhotos) as priors. A photo without a
// row keeps its prior. Positions at 0, 0 do not count. Heights are above `height`, else above what
// the table states, else above the ellipsoid.
void AddTablePriors(const std::string& table_path, std::optional<HeightReference> height,
                    double default_accuracy_m, std::vector<ListedPhoto>* photos);

}  // namespace cairn

#endif  // CAIRN_CLI_BATCH_PHOTO_LIST_H_
