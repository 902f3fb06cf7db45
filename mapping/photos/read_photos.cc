#include "mapping/photos/read_photos.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <memory>
#include <mutex>
#include <string_view>
#include <tuple>
#include <utility>

#include "core/error.h"
#include "core/geoid.h"
#include "core/images/gray_image.h"
#include "core/parallel_for.h"
#include "core/printable.h"
#include "mapping/photos/group_cameras.h"
#include "mapping/photos/photo_files.h"
#include "mapping/photos/read_photo.h"
#include "mapping/photos/require_memory.h"
#include "storage/tile/content_digest.h"

namespace cairn {
namespace {

constexpr size_t kMaxReasons = 3;  // In a message.

// A photo after its file was read.
struct FileResult {
  std::string digest;                    // Of the bytes; empty if the file cannot be read.
  std::optional<ReadPhotoResult> photo;  // Without descriptors.
  StoredDescriptors descriptors;
  std::string reason;  // Why there is no photo.
  bool from_work = false;
};

std::span<const uint8_t> BytesOf(const std::string& text) {
  return {reinterpret_cast<const uint8_t*>(text.data()), text.size()};
}

// What a photo as it was read depends on. The number changes if the code of an extractor does, or
// what is read of the EXIF.
std::string ReadingKey(const FeatureExtractor& extractor) {
  return fmt::format("{} 4 {}", extractor.descriptor_type(), extractor.settings());
}

// Nothing, and the reason in `result`, if the file cannot be read.
std::optional<std::vector<uint8_t>> BytesOfFile(const std::string& path, FileResult* result) {
  try {
    return ReadImageBytes(path);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kBadInput && error.code() != ErrorCode::kNotFound &&
        error.code() != ErrorCode::kIo) {
      throw;
    }
    result->reason = error.what();
    return std::nullopt;
  }
}

// In the file, if there is one.
StoredDescriptors Keep(ByteDescriptorMatrix descriptors, DescriptorFile* file) {
  if (file == nullptr) {
    return descriptors;
  }
  try {
    return file->Append(descriptors);
  } catch (const Error& error) {
    throw Error(error.code(),
                fmt::format("{}. Name a folder on a disk with more space in the environment "
                            "variable TMPDIR",
                            error.what()));
  }
}

// Errors of the work folder are not the photo's, and end the reading.
FileResult ReadOne(const PhotoFile& file, const FeatureExtractor& extractor, const WorkFolder* work,
                   DescriptorFile* descriptor_file) {
  FileResult result;
  const std::optional<std::vector<uint8_t>> bytes = BytesOfFile(file.path, &result);
  if (!bytes) {
    return result;
  }
  result.digest = ContentDigest(*bytes);
  const std::string name = "photo-" + result.digest;
  const std::string key = ReadingKey(extractor);
  if (work != nullptr) {
    if (const auto stored = work->Load(name, key)) {
      result.photo = DecodeReadPhoto(*stored, extractor.descriptor_dim(), work->PathOf(name));
      result.descriptors = Keep(std::move(result.photo->descriptors), descriptor_file);
      result.from_work = true;
      return result;
    }
  }
  try {
    result.photo = ReadMappingPhoto(*bytes, extractor);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kBadInput) {
      throw;
    }
    result.reason = error.what();
    return result;
  }
  if (work != nullptr) {
    work->Store(name, key, EncodeReadPhoto(*result.photo));
  }
  result.descriptors = Keep(std::move(result.photo->descriptors), descriptor_file);
  return result;
}

std::vector<FileResult> ReadAll(const std::vector<PhotoFile>& files,
                                const FeatureExtractor& extractor, const ReadPhotosOptions& options,
                                const PhotosProgress& progress) {
  std::vector<FileResult> results(files.size());
  std::mutex mutex;
  ReadShare share = {.num_photos = static_cast<int>(files.size()),
                     .has_descriptors_on_disk =
                         options.descriptors != nullptr && options.descriptors->is_on_disk()};
  ParallelFor(share.num_photos, options.num_threads, [&](int i) {
    results[i] = ReadOne(files[i], extractor, options.work, options.descriptors.get());
    const std::lock_guard<std::mutex> lock(mutex);
    ++share.num_read;
    share.num_keypoints += results[i].photo ? std::ssize(results[i].photo->keypoints) : 0;
    if (options.available_bytes) {
      RequireMemory(share, *options.available_bytes);
    }
    if (progress) {
      progress(share.num_read, share.num_photos);
    }
  });
  return results;
}

// For each digest the file to keep.
std::map<std::string, size_t> FilesToKeep(const std::vector<PhotoFile>& files,
                                          const std::vector<FileResult>& results,
                                          const std::set<std::string>& names_to_keep) {
  const auto rank = [&](size_t i) {
    const std::string& name = files[i].name;
    return std::tuple(!names_to_keep.contains(name), name.size(), std::string_view(name));
  };
  std::map<std::string, size_t> file_of_digest;
  for (size_t i = 0; i < files.size(); ++i) {
    if (results[i].photo) {
      const auto [kept, is_new] = file_of_digest.try_emplace(results[i].digest, i);
      kept->second = rank(i) < rank(kept->second) ? i : kept->second;
    }
  }
  return file_of_digest;
}

// Leaves out what has no photo and what is there twice.
void LeaveOut(const std::vector<PhotoFile>& files, const std::set<std::string>& names_to_keep,
              std::vector<FileResult>* results, std::vector<LeftOutPhoto>* left_out) {
  const auto file_of_digest = FilesToKeep(files, *results, names_to_keep);
  for (size_t i = 0; i < files.size(); ++i) {
    FileResult& result = (*results)[i];
    if (!result.photo) {
      left_out->push_back({files[i].name, result.reason});
      continue;
    }
    const size_t kept = file_of_digest.at(result.digest);
    if (kept != i) {
      left_out->push_back({files[i].name, "is the same file as " + files[kept].name});
      result.photo.reset();
    }
  }
}

[[noreturn]] void ThrowNoPhotos(const std::vector<LeftOutPhoto>& left_out) {
  std::string reasons;
  for (size_t i = 0; i < std::min(left_out.size(), kMaxReasons); ++i) {
    reasons += fmt::format("; {}: {}", Excerpt(left_out[i].name), Excerpt(left_out[i].reason));
  }
  throw Error(ErrorCode::kBadInput,
              fmt::format("none of the {} photos can be read{}", left_out.size(), reasons));
}

// Heights stay above sea level, as MappingPhoto wants them.
std::optional<Geodetic> GpsOf(const ExifInfo& exif) {
  if (!exif.gps || exif.height_reference == HeightReference::kMeanSeaLevel || !exif.has_altitude) {
    return exif.gps;
  }
  Geodetic gps = *exif.gps;
  gps.h_m -=
      WithEllipsoidalHeight({gps.lat_rad, gps.lon_rad, 0.0}, HeightReference::kMeanSeaLevel).h_m;
  return gps;
}

MappingPhoto PhotoOf(const std::string& name, int camera_idx, ReadPhotoResult read,
                     StoredDescriptors descriptors) {
  MappingPhoto photo;
  photo.name = name;
  photo.camera_idx = camera_idx;
  photo.keypoints = std::move(read.keypoints);
  photo.descriptors = std::move(descriptors);
  photo.gps = GpsOf(read.exif);
  photo.gps_accuracy_m = read.exif.gps_error_m;
  photo.gps_has_height = read.exif.has_altitude;
  return photo;
}

}  // namespace

PhotoFolder ReadPhotos(const std::vector<std::string>& paths, const FeatureExtractor& extractor,
                       const ReadPhotosOptions& options, const PhotosProgress& progress) {
  const std::vector<PhotoFile> files = FindPhotoFiles(paths);
  std::vector<FileResult> results = ReadAll(files, extractor, options, progress);
  PhotoFolder folder;
  folder.set.descriptor_type = extractor.descriptor_type();
  LeaveOut(files, options.names_to_keep, &results, &folder.left_out);
  for (const MisnamedPhoto& misnamed : FindMisnamedPhotos(paths)) {
    folder.left_out.push_back({misnamed.name, misnamed.reason});
  }
  ContentHash hash;
  hash.Add(BytesOf(ReadingKey(extractor)));
  for (const Camera& camera : options.cameras) {
    hash.Add(BytesOf(fmt::format("{} {} {} {}", CameraModelName(camera.model()), camera.width_px(),
                                 camera.height_px(), fmt::join(camera.params(), " "))));
  }
  std::vector<PhotoLens> lenses;
  for (const FileResult& result : results) {
    if (result.photo) {
      lenses.push_back({result.photo->exif, result.photo->has_exif, result.photo->width_px,
                        result.photo->height_px});
    }
  }
  if (lenses.empty()) {
    ThrowNoPhotos(folder.left_out);
  }
  CameraGroups groups = GroupCameras(lenses, options.cameras);
  folder.set.cameras = std::move(groups.cameras);
  folder.notes = std::move(groups.notes);
  for (size_t i = 0; i < files.size(); ++i) {
    if (!results[i].photo) {
      continue;
    }
    hash.Add(BytesOf(files[i].name + "\n" + results[i].digest + "\n"));
    folder.num_from_work += results[i].from_work ? 1 : 0;
    const ExifInfo& exif = results[i].photo->exif;
    folder.num_without_hemisphere += exif.gps_lacks_hemisphere ? 1 : 0;
    folder.num_void_positions += exif.gps_is_void ? 1 : 0;
    const size_t idx = folder.set.photos.size();
    folder.orientation_of_photo.push_back(results[i].photo->has_exif
                                              ? std::optional(results[i].photo->exif.orientation)
                                              : std::nullopt);
    folder.set.photos.push_back(PhotoOf(files[i].name, groups.camera_of_photo[idx],
                                        std::move(*results[i].photo),
                                        std::move(results[i].descriptors)));
    results[i].photo.reset();
  }
  folder.digest = hash.Hex();
  folder.set.Validate();
  return folder;
}

}  // namespace cairn
