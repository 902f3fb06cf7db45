#include "cli/batch/photo_list.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <string_view>
#include <unordered_map>
#include <utility>

#include "core/error.h"
#include "core/file_bytes.h"
#include "core/logging.h"
#include "core/match_names.h"
#include "core/printable.h"
#include "ingest/place/georegister.h"
#include "mapping/photos/photo_files.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kMaxListBytes = uint64_t{256} << 20;
constexpr std::string_view kBlanks = " \t\r";

std::vector<std::string_view> WordsOf(std::string_view line) {
  std::vector<std::string_view> words;
  while (true) {
    const size_t begin = line.find_first_not_of(kBlanks);
    if (begin == std::string_view::npos) {
      return words;
    }
    line.remove_prefix(begin);
    const size_t size = std::min(line.find_first_of(kBlanks), line.size());
    words.push_back(line.substr(0, size));
    line.remove_prefix(size);
  }
}

std::optional<double> NumberIn(std::string_view word) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  return error == std::errc() && end == word.data() + word.size() ? std::optional(value)
                                                                  : std::nullopt;
}

bool LooksLikeModel(std::string_view word) {
  const auto is_of_name = [](char c) { return (c >= 'A' && c <= 'Z') || c == '_'; };
  return std::all_of(word.begin(), word.end(), is_of_name);
}

// A line ends with a camera if its last words are numbers, at least width, height and one
// parameter, after a word like a model's name. Returns the number of words before the camera; all
// words if there is none. Names of photos may hold blanks.
size_t NumWordsOfName(const std::vector<std::string_view>& words) {
  size_t first_number = words.size();
  while (first_number > 0 && NumberIn(words[first_number - 1])) {
    --first_number;
  }
  constexpr size_t kLeastNumbers = 3;
  const bool has_camera = words.size() - first_number >= kLeastNumbers && first_number >= 2 &&
                          LooksLikeModel(words[first_number - 1]);
  return has_camera ? first_number - 1 : words.size();
}

int PixelsIn(std::string_view word) {
  const double value = *NumberIn(word);
  if (!(value >= 1.0 && value <= Camera::kMaxSidePx && value == std::floor(value))) {
    throw Error(ErrorCode::kBadInput,
                fmt::format("'{}' is not a whole number of pixels", Excerpt(word)));
  }
  return static_cast<int>(value);
}

Camera CameraOfWords(const std::vector<std::string_view>& words, size_t model_idx) {
  std::vector<double> params;
  for (size_t i = model_idx + 3; i < words.size(); ++i) {
    params.push_back(*NumberIn(words[i]));
  }
  return Camera(CameraModelFromName(words[model_idx]), PixelsIn(words[model_idx + 1]),
                PixelsIn(words[model_idx + 2]), std::move(params));
}

ListedPhoto PhotoOfLine(std::string_view line, const fs::path& folder) {
  const std::vector<std::string_view> words = WordsOf(line);
  const size_t num_words = NumWordsOfName(words);
  const char* const end = words[num_words - 1].data() + words[num_words - 1].size();
  ListedPhoto photo;
  photo.name = std::string(words.front().data(), end);
  photo.path = (folder / photo.name).string();
  if (num_words < words.size()) {
    photo.camera = CameraOfWords(words, num_words);
  }
  return photo;
}

// Calls visit(line, number) for the lines that count.
template <typename Visit>
void ForEachLine(std::string_view text, const Visit& visit) {
  for (int64_t number = 1; !text.empty(); ++number) {
    const size_t size = std::min(text.find('\n'), text.size());
    const std::string_view line = text.substr(0, size);
    const size_t begin = line.find_first_not_of(kBlanks);
    if (begin != std::string_view::npos && line[begin] != '#') {
      visit(line, number);
    }
    text.remove_prefix(std::min(size + 1, text.size()));
  }
}

// The files of the folder; none if it cannot be read.
std::vector<PhotoFile> FilesIn(const fs::path& folder) {
  try {
    return FindPhotoFiles({folder.empty() ? "." : folder.string()});
  } catch (const Error&) {
    return {};
  }
}

// Gives photos that are not there the files whose names are written in another way.
void FindNamesInFolder(const fs::path& folder, std::vector<ListedPhoto>* photos) {
  const auto is_there = [](const ListedPhoto& photo) {
    std::error_code ignored;
    return fs::exists(photo.path, ignored);
  };
  if (std::all_of(photos->begin(), photos->end(), is_there)) {
    return;
  }
  std::vector<std::string> wanted, known;
  for (const ListedPhoto& photo : *photos) {
    wanted.push_back(photo.name);
  }
  const std::vector<PhotoFile> files = FilesIn(folder);
  for (const PhotoFile& file : files) {
    known.push_back(file.name);
  }
  const NameMatches matches = MatchNames(wanted, known);
  for (size_t i = 0; i < photos->size(); ++i) {
    const int file_idx = matches.known_of_wanted[i];
    if (file_idx >= 0 && !is_there((*photos)[i])) {
      (*photos)[i].path = files[static_cast<size_t>(file_idx)].path;
    }
  }
  if (matches.num_inexact > 0) {
    LogInfo("{} names of the list are written in another way in the folder, e.g. {}",
            matches.num_inexact, InexactExample(matches, wanted, known));
  }
}

std::vector<ListedPhoto> PhotosOfFile(const std::string& path, const std::string& image_dir) {
  const std::string text = ReadTextFile(path, kMaxListBytes);
  const fs::path folder = image_dir.empty() ? fs::path(path).parent_path() : fs::path(image_dir);
  std::vector<ListedPhoto> photos;
  std::unordered_map<std::string, int64_t> line_of_name;
  ForEachLine(text, [&](std::string_view line, int64_t number) {
    try {
      ListedPhoto photo = PhotoOfLine(line, folder);
      const auto [first, is_new] = line_of_name.try_emplace(photo.name, number);
      if (!is_new) {
        throw Error(ErrorCode::kBadInput, fmt::format("the photo {} is also in line {}",
                                                      Excerpt(photo.name), first->second));
      }
      photos.push_back(std::move(photo));
    } catch (const Error& error) {
      throw Error(error.code(),
                  fmt::format("{}: line {}: {}", Printable(path), number, error.what()));
    }
  });
  if (photos.empty()) {
    throw Error(ErrorCode::kBadInput, fmt::format("{}: the list names no photo", Printable(path)));
  }
  FindNamesInFolder(folder, &photos);
  return photos;
}

}  // namespace

std::vector<ListedPhoto> ReadPhotoList(const std::string& path, const std::string& image_dir) {
  std::error_code ignored;
  if (!fs::is_directory(path, ignored)) {
    return PhotosOfFile(path, image_dir);
  }
  if (!image_dir.empty()) {
    throw Error(ErrorCode::kInvalidArgument,
                "--image-dir is the folder of the photos of a list, but --images is a folder");
  }
  std::vector<ListedPhoto> photos;
  for (PhotoFile& file : FindPhotoFiles({path})) {
    photos.push_back({.name = std::move(file.name), .path = std::move(file.path)});
  }
  for (const MisnamedPhoto& misnamed : FindMisnamedPhotos({path})) {
    LogWarning("{} {}", Excerpt(misnamed.name), misnamed.reason);
  }
  return photos;
}

void AddTablePriors(const std::string& table_path, std::optional<HeightReference> height,
                    double default_accuracy_m, std::vector<ListedPhoto>* photos) {
  std::vector<std::string> names;
  std::unordered_map<std::string, size_t> photo_of_name;
  for (size_t i = 0; i < photos->size(); ++i) {
    names.push_back((*photos)[i].name);
    photo_of_name.emplace((*photos)[i].name, i);
  }
  std::vector<std::string> notes;
  std::vector<CameraPosition> rows =
      ReadPositionsOfPhotos(table_path, names, &notes, default_accuracy_m);
  MakeHeightsEllipsoidal(height, HeightReference::kEllipsoid, &rows);
  for (const CameraPosition& row : rows) {
    if (row.position.lat_rad == 0.0 && row.position.lon_rad == 0.0) {
      continue;
    }
    PositionPrior prior;
    prior.position = row.position;
    prior.accuracy_m = std::min(row.accuracy_m, PositionPrior::kMaxAccuracyM);
    (*photos)[photo_of_name.at(row.image_name)].prior = prior;
  }
  for (const std::string& note : notes) {
    LogInfo("{}: {}", Printable(table_path), note);
  }
}

}  // namespace cairn
