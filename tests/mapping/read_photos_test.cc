#include "mapping/photos/read_photos.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>

#include "core/error.h"
#include "core/features/sift/sift_extractor.h"
#include "core/keypoint_shape.h"
#include "mapping/photos/photo_files.h"
#include "support/file_size_limit.h"
#include "support/temp_dir.h"
#include "support/test_data.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;

void Write(const fs::path& path, const std::string& bytes) {
  fs::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary) << bytes;
}

// Soft discs at random places.
std::string Picture(uint64_t seed, int num_discs = 150) {
  constexpr int kSide = 200;
  std::mt19937_64 rng(seed);
  std::vector<double> pixels(kSide * kSide, 100.0);
  for (int i = 0; i < num_discs; ++i) {
    const double x = rng() % kSide, y = rng() % kSide;
    const double radius = 2.0 + rng() % 6, height = (rng() % 2 == 0 ? 80.0 : -80.0);
    for (int v = 0; v < kSide; ++v) {
      for (int u = 0; u < kSide; ++u) {
        const double sq = (std::pow(u - x, 2) + std::pow(v - y, 2)) / (radius * radius);
        pixels[v * kSide + u] += height * std::exp(-sq);
      }
    }
  }
  std::string bytes = "P5\n200 200\n255\n";
  for (const double pixel : pixels) {
    bytes += static_cast<char>(std::clamp(pixel, 0.0, 255.0));
  }
  return bytes;
}

std::string ReasonFor(const PhotoFolder& folder, const std::string& name) {
  for (const LeftOutPhoto& photo : folder.left_out) {
    if (photo.name == name) {
      return photo.reason;
    }
  }
  return "";
}

TEST(ReadPhotos, LeavesOutWhatItCannotUseWithAReason) {
  const testing::TempDir dir;
  Write(dir.path() / "a.pgm", Picture(1));
  Write(dir.path() / "b/c.pgm", Picture(2));
  Write(dir.path() / "blank.pgm", Picture(3, 0));
  Write(dir.path() / "copy.pgm", Picture(1));
  Write(dir.path() / "cut.pgm", Picture(4).substr(0, 1000));
  Write(dir.path() / "phone.heic", std::string("\0\0\0\x18"
                                               "ftypheic0000",
                                               16));
  Write(dir.path() / "notes.txt", "no photo");
  Write(dir.path() / ".thumbs/a.pgm", Picture(5));
  fs::create_symlink("unplugged/d.jpg", dir.path() / "d.jpg");
  const PhotoFolder folder = ReadPhotos({dir.path()}, SiftExtractor(), {});
  ASSERT_EQ(folder.set.photos.size(), 2u);
  EXPECT_EQ(folder.set.photos[0].name, "a.pgm");
  EXPECT_EQ(folder.set.photos[1].name, "b/c.pgm");
  EXPECT_EQ(folder.set.cameras.size(), 1u);
  EXPECT_GE(folder.set.photos[0].keypoints.size(), 20u);
  EXPECT_FALSE(folder.orientation_of_photo[0]);
  EXPECT_EQ(folder.left_out.size(), 5u);
  EXPECT_NE(ReasonFor(folder, "d.jpg").find("d.jpg"), std::string::npos);
  EXPECT_NE(ReasonFor(folder, "blank.pgm").find("blank or blurred"), std::string::npos);
  EXPECT_EQ(ReasonFor(folder, "copy.pgm"), "is the same file as a.pgm");
  EXPECT_FALSE(ReasonFor(folder, "cut.pgm").empty());
  EXPECT_NE(ReasonFor(folder, "phone.heic").find("JPEG"), std::string::npos);
}

TEST(ReadPhotos, NamesVideosAndEmptyFiles) {
  const testing::TempDir dir;
  Write(dir.path() / "a.pgm", Picture(1));
  Write(dir.path() / "empty.jpg", "");
  Write(dir.path() / "film.jpg", std::string("\0\0\0\x14"
                                             "ftypqt  0000",
                                             16));
  const PhotoFolder folder = ReadPhotos({dir.path()}, SiftExtractor(), {});
  EXPECT_NE(ReasonFor(folder, "empty.jpg").find("empty"), std::string::npos);
  EXPECT_NE(ReasonFor(folder, "film.jpg").find("is a video"), std::string::npos);
}

TEST(ReadPhotos, KeepsTheCopyOfTheTableOrOfTheShortestName) {
  const testing::TempDir dir;
  for (const char* name : {"05 (1).pgm", "05.pgm", "Copy of 05.pgm"}) {
    Write(dir.path() / name, Picture(1));
  }
  const PhotoFolder folder = ReadPhotos({dir.path()}, SiftExtractor(), {});
  ASSERT_EQ(folder.set.photos.size(), 1u);
  EXPECT_EQ(folder.set.photos[0].name, "05.pgm");
  EXPECT_EQ(ReasonFor(folder, "05 (1).pgm"), "is the same file as 05.pgm");
  const PhotoFolder of_table =
      ReadPhotos({dir.path()}, SiftExtractor(), {.names_to_keep = {"Copy of 05.pgm"}});
  EXPECT_EQ(of_table.set.photos.at(0).name, "Copy of 05.pgm");
  EXPECT_EQ(ReasonFor(of_table, "05.pgm"), "is the same file as Copy of 05.pgm");
}

// A keypoint every ten pixels, of unknown size and orientation, with a descriptor of two numbers.
class GridExtractor final : public FeatureExtractor {
 public:
  std::string descriptor_type() const override { return "grid"; }
  int descriptor_dim() const override { return 2; }
  std::string settings() const override { return "10"; }
  FeatureSet Extract(const GrayImage& image, const StopFunction&) const override {
    FeatureSet features;
    for (int i = 0; 10 * i < image.width_px; ++i) {
      features.keypoints.push_back(KeypointWithoutShape(10.0f * i, 5.0f));
    }
    features.descriptors = DescriptorMatrix::Constant(features.size(), 2, 200.0f);
    return features;
  }
};

TEST(ReadPhotos, TakesFeaturesOfAnyExtractor) {
  const testing::TempDir dir;
  Write(dir.path() / "photos/a.pgm", Picture(1));
  const WorkFolder work(dir.path() / "w");
  const ReadPhotosOptions options = {.work = &work};
  const PhotoFolder first = ReadPhotos({dir.path() / "photos"}, GridExtractor(), options);
  const PhotoFolder second = ReadPhotos({dir.path() / "photos"}, GridExtractor(), options);
  EXPECT_EQ(second.num_from_work, 1);
  for (const PhotoFolder& folder : {first, second}) {
    EXPECT_EQ(folder.set.descriptor_type, "grid");
    EXPECT_EQ(folder.set.photos[0].keypoints.size(), 20u);
    EXPECT_FALSE(HasScale(folder.set.photos[0].keypoints[3]));
    EXPECT_TRUE(*folder.set.photos[0].descriptors.Load() ==
                ByteDescriptorMatrix::Constant(20, 2, 200));
  }
  EXPECT_EQ(ReadPhotos({dir.path() / "photos"}, SiftExtractor(), options).num_from_work, 0);
}

TEST(ReadPhotos, TakesFeaturesFromTheWorkFolder) {
  const testing::TempDir dir;
  Write(dir.path() / "photos/a.pgm", Picture(1));
  const WorkFolder work(dir.path() / "w");
  ReadPhotosOptions options;
  options.work = &work;
  const PhotoFolder first = ReadPhotos({dir.path() / "photos"}, SiftExtractor(), options);
  const PhotoFolder second = ReadPhotos({dir.path() / "photos"}, SiftExtractor(), options);
  EXPECT_EQ(first.num_from_work, 0);
  EXPECT_EQ(second.num_from_work, 1);
  EXPECT_EQ(first.digest, second.digest);
  const MappingPhoto& a = first.set.photos[0];
  const MappingPhoto& b = second.set.photos[0];
  ASSERT_EQ(a.keypoints.size(), b.keypoints.size());
  EXPECT_EQ(a.keypoints.back().x_px, b.keypoints.back().x_px);
  EXPECT_TRUE(*a.descriptors.Load() == *b.descriptors.Load());
  const PhotoFolder third =
      ReadPhotos({dir.path() / "photos"}, SiftExtractor({.max_features = 30}), options);
  EXPECT_EQ(third.num_from_work, 0);
  EXPECT_NE(third.digest, first.digest);
}

TEST(ReadPhotos, IsTheSameOnAnyNumberOfThreads) {
  const testing::TempDir dir;
  for (int i = 0; i < 6; ++i) {
    Write(dir.path() / (std::to_string(i) + ".pgm"), Picture(i + 1));
  }
  const PhotoFolder one = ReadPhotos({dir.path()}, SiftExtractor(), {});
  const PhotoFolder four = ReadPhotos({dir.path()}, SiftExtractor(), {.num_threads = 4});
  EXPECT_EQ(one.digest, four.digest);
  for (size_t i = 0; i < one.set.photos.size(); ++i) {
    EXPECT_EQ(one.set.photos[i].name, four.set.photos[i].name);
    EXPECT_TRUE(*one.set.photos[i].descriptors.Load() == *four.set.photos[i].descriptors.Load());
  }
}

TEST(ReadPhotos, KeepsTheSameDescriptorsOnDisk) {
  const testing::TempDir dir;
  for (int i = 0; i < 6; ++i) {
    Write(dir.path() / "photos" / (std::to_string(i) + ".pgm"), Picture(i + 1));
  }
  const WorkFolder work(dir.path() / "w");
  const PhotoFolder in_memory = ReadPhotos({dir.path() / "photos"}, SiftExtractor(), {});
  for (const int num_from_work : {0, 6}) {
    const PhotoFolder on_disk = ReadPhotos(
        {dir.path() / "photos"}, SiftExtractor(),
        {.work = &work, .num_threads = 3, .descriptors = DescriptorFile::Create(dir.path())});
    EXPECT_EQ(on_disk.num_from_work, num_from_work);
    EXPECT_EQ(on_disk.digest, in_memory.digest);
    for (size_t i = 0; i < 6; ++i) {
      EXPECT_TRUE(*on_disk.set.photos[i].descriptors.Load() ==
                  *in_memory.set.photos[i].descriptors.Load());
    }
  }
}

TEST(ReadPhotos, SaysWhatToDoIfTheDiskIsFull) {
  const testing::TempDir dir;
  Write(dir.path() / "a.pgm", Picture(1));
  const testing::FileSizeLimit limit(1000);
  try {
    ReadPhotos({dir.path()}, SiftExtractor(), {.descriptors = DescriptorFile::Create(dir.path())});
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kIo);
    EXPECT_TRUE(std::string(error.what()).starts_with(dir.path().string() + ": ")) << error.what();
    EXPECT_NE(std::string(error.what()).find("TMPDIR"), std::string::npos) << error.what();
  }
}

TEST(ReadPhotos, RefusesMorePhotosThanTheMemoryTakes) {
  const testing::TempDir dir;
  for (int i = 0; i < 6; ++i) {
    Write(dir.path() / (std::to_string(i) + ".pgm"), Picture(i + 1));
  }
  int64_t num_keypoints = 0;
  for (const MappingPhoto& photo : ReadPhotos({dir.path()}, SiftExtractor(), {}).set.photos) {
    num_keypoints += std::ssize(photo.keypoints);
  }
  const auto expect_limit = [&](int64_t bytes_of_keypoint, ReadPhotosOptions options) {
    const auto needed_bytes = static_cast<uint64_t>(bytes_of_keypoint * num_keypoints);
    options.available_bytes = needed_bytes;
    EXPECT_NO_THROW(ReadPhotos({dir.path()}, SiftExtractor(), options));
    options.available_bytes = needed_bytes - 1;
    try {
      ReadPhotos({dir.path()}, SiftExtractor(), options);
      FAIL();
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kBadInput);
      EXPECT_NE(std::string(error.what()).find("mapping 6 photos with some "), std::string::npos)
          << error.what();
    }
  };
  const auto file = DescriptorFile::Create(dir.path());
  for (const int num_threads : {1, 3}) {
    expect_limit(660, {.num_threads = num_threads});
    expect_limit(file->is_on_disk() ? 532 : 660, {.num_threads = num_threads, .descriptors = file});
  }
}

TEST(ReadPhotos, RefusesAFolderWithoutAPhotoThatItCanRead) {
  const testing::TempDir dir;
  Write(dir.path() / "a.jpg", "not a photo");
  try {
    ReadPhotos({dir.path()}, SiftExtractor(), {});
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kBadInput);
    EXPECT_NE(std::string(error.what()).find("a.jpg"), std::string::npos);
  }
}

TEST(ReadPhotos, TakesThePositionsOfExif) {
  CAIRN_SKIP_WITHOUT_DATA("street_berlin3/images/01.jpg");
  const PhotoFolder folder =
      ReadPhotos({(testing::TestDataDir() / "street_berlin3/images").string()},
                 SiftExtractor({.max_features = 100, .max_pixels = 100'000}), {});
  ASSERT_EQ(folder.set.photos.size(), 3u);
  ASSERT_TRUE(folder.set.photos[0].gps);
  EXPECT_NEAR(folder.set.photos[0].gps->lat_deg(), 52.5, 0.1);
  EXPECT_EQ(folder.orientation_of_photo[0], 1);
}

TEST(FindPhotoFiles, NamesPhotosOfSeveralFoldersAfterThem) {
  const testing::TempDir dir;
  Write(dir.path() / "monday/1.jpg", "");
  Write(dir.path() / "tuesday/1.JPG", "");
  const auto files =
      FindPhotoFiles({(dir.path() / "tuesday/").string(), (dir.path() / "monday").string()});
  ASSERT_EQ(files.size(), 2u);
  EXPECT_EQ(files[0].name, "monday/1.jpg");
  EXPECT_EQ(files[1].name, "tuesday/1.JPG");
}

TEST(FindPhotoFiles, KnowsAllEndingsOfJpeg) {
  const testing::TempDir dir;
  for (const char* name : {"1.JFIF", "2.jpe", "3.Mpo"}) {
    Write(dir.path() / name, "");
  }
  EXPECT_EQ(FindPhotoFiles({dir.path().string()}).size(), 3u);
}

TEST(FindMisnamedPhotos, NamesPhotosOfOtherEndings) {
  const testing::TempDir dir;
  for (const char* name : {"1", "b/2.jpg.tmp", "3.jpg", "4.jpg_original", ".5"}) {
    Write(dir.path() / name, "\xff\xd8\xff\xe0 and so on");
  }
  Write(dir.path() / "6.picture", "\x89PNG\r\n");
  Write(dir.path() / "7.txt", "text");
  Write(dir.path() / "8.pgm", Picture(1));
  const auto misnamed = FindMisnamedPhotos({dir.path().string()});
  ASSERT_EQ(misnamed.size(), 3u);
  EXPECT_EQ(misnamed[0].name, "1");
  EXPECT_NE(misnamed[0].reason.find("ends in .jpg"), std::string::npos);
  EXPECT_EQ(misnamed[1].name, "6.picture");
  EXPECT_NE(misnamed[1].reason.find("ends in .png"), std::string::npos);
  EXPECT_EQ(misnamed[2].name, "b/2.jpg.tmp");
  EXPECT_EQ(ReasonFor(ReadPhotos({dir.path()}, SiftExtractor(), {}), "1"), misnamed[0].reason);
}

TEST(FindPhotoFiles, SkipsThumbnailsOfNetworkDisks) {
  const testing::TempDir dir;
  for (const char* name :
       {"1.jpg", "@eaDir/1.jpg/SYNOPHOTO_THUMB_XL.jpg", "b/.@__thumb/s1001.jpg",
        "b/.thumbnails/1.jpg", "b/#recycle/0.jpg", "__MACOSX/1.jpg", "eaDir/2.jpg"}) {
    Write(dir.path() / name, "");
  }
  const auto files = FindPhotoFiles({dir.path().string()});
  ASSERT_EQ(files.size(), 2u);
  EXPECT_EQ(files[0].name, "1.jpg");
  EXPECT_EQ(files[1].name, "eaDir/2.jpg");
  EXPECT_EQ(FindPhotoFiles({(dir.path() / "@eaDir").string()}).size(), 1u);
}

TEST(FindPhotoFiles, RefusesAFolderWithoutPhotos) {
  const testing::TempDir dir;
  EXPECT_THROW(FindPhotoFiles({dir.path().string()}), Error);
  EXPECT_THROW(FindPhotoFiles({(dir.path() / "missing").string()}), Error);
}

}  // namespace
}  // namespace cairn
