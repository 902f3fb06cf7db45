#include "mapping/photos/photo_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <string_view>
#include <system_error>

#include "core/error.h"
#include "core/printable.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;

// Also pictures that Cairn cannot decode, so that the report names them.
constexpr std::array<std::string_view, 21> kEndings = {
    ".jpg", ".jpeg", ".jfif", ".jpe",  ".mpo",  ".png", ".pgm", ".ppm", ".pnm", ".heic", ".heif",
    ".tif", ".bmp",  ".tiff", ".webp", ".avif", ".gif", ".dng", ".cr2", ".nef", ".jxl"};

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

// Copies that programs keep of files that they change.
constexpr std::array<std::string_view, 3> kBackupEndings = {"_original", "~", ".bak"};

std::string EndingOf(const fs::path& path) {
  std::string ending = path.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return ending;
}

bool IsPhotoName(const fs::path& path) {
  const std::string ending = EndingOf(path);
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

// What a file without the ending of a picture is by its first bytes: ".jpg", ".png", or nothing.
std::string EndingByContent(const fs::directory_entry& entry) {
  std::error_code ignored;
  const std::string name = entry.path().filename().string();
  const bool is_backup =
      std::any_of(kBackupEndings.begin(), kBackupEndings.end(),
                  [&](std::string_view ending) { return name.ends_with(ending); });
  if (is_backup || !entry.is_regular_file(ignored)) {
    return "";
  }
  std::array<char, 4> bytes = {};
  std::ifstream(entry.path(), std::ios::binary).read(bytes.data(), bytes.size());
  const std::string_view start(bytes.data(), bytes.size());
  if (start.starts_with("\xff\xd8\xff")) {
    return ".jpg";
  }
  return start == "\x89PNG" ? ".png" : "";
}

// Calls visit(entry, name) for all entries that are not hidden.
template <typename Visit>
void ForEachEntry(const fs::path& folder, const std::string& prefix, const Visit& visit) {
  std::error_code error;
  fs::recursive_directory_iterator entry(folder, error), end;
  for (; !error && entry != end; entry.increment(error)) {
    if (IsHidden(*entry)) {
      entry.disable_recursion_pending();
      continue;
    }
    visit(*entry, prefix + entry->path().lexically_relative(folder).generic_string());
  }
  if (error) {
    throw Error(ErrorCode::kIo, fmt::format("{}: {}", Printable(folder.string()), error.message()));
  }
}

void AddFolder(const fs::path& folder, const std::string& prefix, std::vector<PhotoFile>* files) {
  ForEachEntry(folder, prefix, [&](const fs::directory_entry& entry, const std::string& name) {
    if (IsPhotoName(entry.path()) && IsFileOrDeadLink(entry)) {
      files->push_back({name, entry.path().string()});
    }
  });
}

[[noreturn]] void ThrowNoFiles(const std::vector<std::string>& paths) {
  const std::vector<MisnamedPhoto> misnamed = FindMisnamedPhotos(paths);
  throw Error(ErrorCode::kBadInput,
              fmt::format("{}: no photos (.jpg, .png) are in this folder or below it{}",
                          Printable(paths.empty() ? "" : paths.front()),
                          misnamed.empty() ? ""
                                           : fmt::format("; {} {}", Excerpt(misnamed.front().name),
                                                         misnamed.front().reason)));
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
    ThrowNoFiles(paths);
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

std::vector<MisnamedPhoto> FindMisnamedPhotos(const std::vector<std::string>& paths) {
  std::vector<MisnamedPhoto> misnamed;
  for (const std::string& given : paths) {
    const fs::path path = fs::path(given).lexically_normal();
    std::error_code ignored;
    if (!fs::is_directory(path, ignored)) {
      continue;
    }
    const std::string prefix = paths.size() > 1 ? PrefixOfPhotos(given) : "";
    ForEachEntry(Named(path), prefix, [&](const fs::directory_entry& entry, const auto& name) {
      const std::string ending = IsPhotoName(entry.path()) ? "" : EndingByContent(entry);
      if (!ending.empty()) {
        misnamed.push_back({name, fmt::format("is a photo, but its name does not say so; rename "
                                              "the file so that its name ends in {}",
                                              ending)});
      }
    });
  }
  std::sort(misnamed.begin(), misnamed.end(),
            [](const MisnamedPhoto& a, const MisnamedPhoto& b) { return a.name < b.name; });
  return misnamed;
}

std::string PrefixOfPhotos(const std::string& folder) {
  const fs::path named = Named(fs::path(folder).lexically_normal());
  return fs::absolute(named).lexically_normal().filename().string() + "/";
}

}  // namespace cairn
