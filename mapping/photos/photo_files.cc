#include "mapping/photos/photo_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <string_view>
#include <system_error>

#include "core/error.h"
#include "core/printable.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;

// Also pictures that Cairn cannot decode, so that the report names them.
constexpr std::array<std::string_view, 18> kEndings = {
    ".jpg", ".jpeg", ".png",  ".pgm",  ".ppm", ".pnm", ".heic", ".heif", ".tif",
    ".bmp", ".tiff", ".webp", ".avif", ".gif", ".dng", ".cr2",  ".nef",  ".jxl"};

// Of network disks and archives: thumbnails, deleted files, resources. As hidden as those with a
// dot.
constexpr std::array<std::string_view, 5> kHiddenFolders = {"@eaDir", "@Recycle", "#recycle",
                                                            "$RECYCLE.BIN", "__MACOSX"};

bool IsHidden(const fs::directory_entry& entry) {
  const std::string name = entry.path().filename().string();
  std::error_code ignored;
  return name.starts_with('.') ||
         (std::find(kHiddenFolders.begin(), kHiddenFolders.end(), name) != kHiddenFolders.end() &&
          entry.is_directory(ignored));
}

bool IsPhotoName(const fs::path& path) {
  std::string ending = path.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return std::find(kEndings.begin(), kEndings.end(), ending) != kEndings.end();
}

// A link that leads nowhere counts as a photo: reading it fails, so the report names it.
bool IsFileOrDeadLink(const fs::directory_entry& entry) {
  std::error_code ignored;
  return entry.is_regular_file(ignored) ||
         (entry.is_symlink(ignored) && !fs::exists(entry.path(), ignored));
}

// Without a slash at the end.
fs::path Named(const fs::path& path) { return path.has_filename() ? path : path.parent_path(); }

void AddFolder(const fs::path& folder, const std::string& prefix, std::vector<PhotoFile>* files) {
  std::error_code error;
  fs::recursive_directory_iterator entry(folder, error), end;
  for (; !error && entry != end; entry.increment(error)) {
    if (IsHidden(*entry)) {
      entry.disable_recursion_pending();
      continue;
    }
    if (IsPhotoName(entry->path()) && IsFileOrDeadLink(*entry)) {
      files->push_back({prefix + entry->path().lexically_relative(folder).generic_string(),
                        entry->path().string()});
    }
  }
  if (error) {
    throw Error(ErrorCode::kIo, fmt::format("{}: {}", Printable(folder.string()), error.message()));
  }
}

}  // namespace

std::vector<PhotoFile> FindPhotoFiles(const std::vector<std::string>& paths) {
  std::vector<PhotoFile> files;
  for (const std::string& given : paths) {
    const fs::path path = fs::path(given).lexically_normal();
    std::error_code error;
    if (!fs::exists(path, error)) {
      throw Error(ErrorCode::kNotFound,
                  fmt::format("{}: there is no such folder", Printable(given)));
    }
    if (!fs::is_directory(path, error)) {
      files.push_back({path.filename().string(), path.string()});
      continue;
    }
    AddFolder(Named(path), paths.size() > 1 ? PrefixOfPhotos(given) : "", &files);
  }
  if (files.empty()) {
    throw Error(ErrorCode::kBadInput,
                fmt::format("{}: no photos (.jpg, .png) are in this folder or below it",
                            Printable(paths.empty() ? "" : paths.front())));
  }
  std::sort(files.begin(), files.end(),
            [](const PhotoFile& a, const PhotoFile& b) { return a.name < b.name; });
  const auto twice =
      std::adjacent_find(files.begin(), files.end(),
                         [](const PhotoFile& a, const PhotoFile& b) { return a.name == b.name; });
  if (twice != files.end()) {
    throw Error(ErrorCode::kBadInput,
                fmt::format("two folders have a photo of the name {}; give the folder above them, "
                            "or rename one of them",
                            Excerpt(twice->name)));
  }
  return files;
}

std::string PrefixOfPhotos(const std::string& folder) {
  const fs::path named = Named(fs::path(folder).lexically_normal());
  return fs::absolute(named).lexically_normal().filename().string() + "/";
}

}  // namespace cairn
