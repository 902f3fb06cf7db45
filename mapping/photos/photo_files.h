// Finds the photos in folders.
#ifndef CAIRN_MAPPING_PHOTOS_PHOTO_FILES_H_
#define CAIRN_MAPPING_PHOTOS_PHOTO_FILES_H_

#include <string>
#include <vector>

namespace cairn {

struct PhotoFile {
  std::string name;  // Unique: the path below the folder, with '/'.
  std::string path;
};

// All files in the folders and below whose name ends as that of a picture (.jpg, .png, .heic and
// so on), in the order of their names. Hidden files and folders do not count, as @eaDir, the
// thumbnails of network disks, nor do links to folders; links that lead nowhere do, so that the
// report names them. A path may also be a file. With several paths, a name begins with the folder's
// own. Throws Error(kNotFound) if a path does not exist, and Error(kBadInput), with what to do, if
// there is no such file, or if two folders have one name.
std::vector<PhotoFile> FindPhotoFiles(const std::vector<std::string>& paths);

struct MisnamedPhoto {
  std::string name;    // As PhotoFile::name.
  std::string reason;  // With what to do.
};

// The other files in the folders and below that are JPEG or PNG by their first bytes, in the order
// of their names. Hidden files, links to folders and backup copies (.jpg_original, ~, .bak) do not
// count.
std::vector<MisnamedPhoto> FindMisnamedPhotos(const std::vector<std::string>& paths);

// What the names of a folder's photos begin with if there are several paths: "monday/".
std::string PrefixOfPhotos(const std::string& folder);

}  // namespace cairn

#endif  // CAIRN_MAPPING_PHOTOS_PHOTO_FILES_H_
