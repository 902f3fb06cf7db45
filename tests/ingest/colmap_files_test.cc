// Models and databases as people have them.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/error.h"
#include "ingest/colmap/colmap_model.h"
#include "ingest/colmap_fixture.h"
#include "support/raw_sql.h"

namespace cairn {
namespace {

using testing::ErrorOf;
using testing::ExecuteRaw;
using ::testing::HasSubstr;
using testing::StreetReconstruction;

class ColmapFiles : public testing::ColmapTest {
 protected:
  // Changes the bytes of a file.
  void Rewrite(const std::string& name, const std::function<std::string(std::string)>& change) {
    std::ifstream in(dir_.File(name), std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(in), {}};
    in.close();
    std::ofstream(dir_.File(name), std::ios::binary) << change(bytes);
  }

  std::string RefusalOf(const ColmapInput& input) {
    const auto [code, message] = ErrorOf([&] { ReadColmap(input); });
    EXPECT_EQ(code, ErrorCode::kBadInput) << message;
    return message;
  }
};

TEST_F(ColmapFiles, ImageNamesThatAModelCannotHoldAreNotWritten) {
  Reconstruction street = StreetReconstruction();
  for (const std::string& name :
       {std::string("a\nb.jpg"), std::string("a\rb.jpg"), std::string("a\0b.jpg", 7)}) {
    street.images.front().name = name;
    for (const bool binary : {false, true}) {
      const auto [code, message] = ErrorOf([&] { Write(street, binary); });
      EXPECT_EQ(code, ErrorCode::kBadInput);
      EXPECT_THAT(message, HasSubstr("COLMAP models cannot hold the image name"));
    }
  }
}

TEST_F(ColmapFiles, TextModelsMayHaveAByteOrderMarkAndLinesOfWindows) {
  const Reconstruction written = StreetReconstruction();
  const ColmapInput input = Write(written, /*binary=*/false);
  for (const char* name : {"cameras.txt", "images.txt", "points3D.txt"}) {
    Rewrite(name, [](const std::string& text) {
      std::string windows = "\xef\xbb\xbf";
      for (const char letter : text) {
        windows += letter == '\n' ? "\r\n" : std::string(1, letter);
      }
      return windows;
    });
  }
  const Reconstruction read = ReadColmap(input);
  EXPECT_EQ(read.images.size(), written.images.size());
  EXPECT_EQ(read.landmarks.size(), written.landmarks.size());
}

TEST_F(ColmapFiles, AnImageNeedsASecondLine) {
  const ColmapInput input = Write(StreetReconstruction(), /*binary=*/false);
  Rewrite("images.txt", [](const std::string&) {
    return "1 1 0 0 0 0 0 0 1 01.jpg\n2 1 0 0 0 0 0 0 1 02.jpg\n";
  });
  const std::string refusal = RefusalOf(input);
  EXPECT_THAT(refusal, HasSubstr("line 2"));
  EXPECT_THAT(refusal, HasSubstr("'02.jpg' is not a valid keypoint: each image needs a second "));
}

TEST_F(ColmapFiles, Utf16IsNoTextModel) {
  const ColmapInput input = Write(StreetReconstruction(), /*binary=*/false);
  Rewrite("images.txt", [](const std::string& text) {
    std::string wide = "\xff\xfe";
    for (const char letter : text) {
      wide += {letter, '\0'};
    }
    return wide;
  });
  EXPECT_THAT(RefusalOf(input), HasSubstr("not UTF-8"));
}

TEST_F(ColmapFiles, AFileOfTheModelAndTheFolderOfTheDatabaseAreCalledSo) {
  const ColmapInput input = Write(StreetReconstruction());
  EXPECT_THAT(RefusalOf({dir_.File("images.bin"), input.database_path, {}}),
              HasSubstr("this is a file; name the folder of the COLMAP model, " + input.model_dir));
  EXPECT_THAT(RefusalOf({input.database_path, input.database_path, {}}),
              HasSubstr("this is a file; name the folder of the COLMAP model"));
  EXPECT_THAT(
      RefusalOf({input.model_dir, input.model_dir, {}}),
      HasSubstr("this is a folder; name the file of the COLMAP database, " + input.database_path));
}

TEST_F(ColmapFiles, TheOnlyModelOfAProjectIsTaken) {
  const Reconstruction written = StreetReconstruction();
  ColmapInput input = Write(written);
  std::filesystem::create_directories(dir_.path() / "project/sparse/0");
  std::filesystem::create_directories(dir_.path() / "project/images");
  for (const char* name : {"cameras.bin", "images.bin", "points3D.bin"}) {
    std::filesystem::copy(dir_.File(name), dir_.path() / "project/sparse/0");
  }
  for (const char* folder : {"project/sparse", "project"}) {
    input.model_dir = dir_.File(folder);
    EXPECT_EQ(ReadColmap(input).images.size(), written.images.size()) << folder;
  }
  std::filesystem::copy(dir_.path() / "project/sparse/0", dir_.path() / "project/sparse/1");
  const std::string message = RefusalOf(input);
  EXPECT_THAT(message, HasSubstr("2 COLMAP models"));
  EXPECT_THAT(message, HasSubstr(fmt::format("sparse/1 ({} images)", written.images.size())));
}

TEST_F(ColmapFiles, ACameraModelThatIsNotSupportedIsNamedIfAnImageHasIt) {
  const Reconstruction written = StreetReconstruction();
  const ColmapInput input = Write(written);
  const auto camera = [](uint32_t id, int32_t model, size_t num_params) {
    const uint64_t size[2] = {2048, 1024};
    const std::vector<double> params(num_params, 1.0);
    std::string bytes(reinterpret_cast<const char*>(&id), 4);
    bytes.append(reinterpret_cast<const char*>(&model), 4);
    bytes.append(reinterpret_cast<const char*>(size), 16);
    return bytes.append(reinterpret_cast<const char*>(params.data()), 8 * num_params);
  };
  // Before the camera of the images, so that its end must be found.
  Rewrite("cameras.bin", [&](std::string bytes) {
    bytes[0] = static_cast<char>(bytes[0] + 2);
    return bytes.insert(8, camera(900, 17, 2) + camera(901, 12, 4));
  });
  EXPECT_EQ(ReadColmap(input).images.size(), written.images.size());
  Rewrite("cameras.bin", [&](const std::string&) {
    return std::string("\1\0\0\0\0\0\0\0", 8) + camera(3, 17, 2);
  });
  EXPECT_THAT(RefusalOf(input), HasSubstr("EQUIRECTANGULAR) is not supported"));
  Rewrite("cameras.bin", [&](const std::string&) {
    return std::string("\1\0\0\0\0\0\0\0", 8) + camera(3, 42, 2);
  });
  EXPECT_THAT(RefusalOf(input), HasSubstr("camera model 42 is not supported"));
}

TEST_F(ColmapFiles, ACameraModelOfATextModelIsNamed) {
  const ColmapInput input = Write(StreetReconstruction(), /*binary=*/false);
  Rewrite("cameras.txt", [](const std::string&) { return "3 EUCM 640 480 1 1 1 1 1 1\n"; });
  EXPECT_THAT(RefusalOf(input), HasSubstr("'EUCM' is not supported"));
}

TEST_F(ColmapFiles, SparseFilesNeedNoMemory) {
  const ColmapInput input = Write(StreetReconstruction());
  std::filesystem::resize_file(dir_.File("points3D.bin"), uint64_t{100} << 30);
  EXPECT_THAT(RefusalOf(input), HasSubstr("100.0 GiB"));
  // A count that fits a file with a hole, but not its content.
  std::ofstream(dir_.File("images.bin"), std::ios::binary) << std::string("\0\0\0\10\0\0\0\0", 8);
  std::filesystem::resize_file(dir_.File("images.bin"), uint64_t{12} << 30);
  EXPECT_THAT(RefusalOf(input), HasSubstr("images.bin"));
}

TEST_F(ColmapFiles, NamesMayBeWrittenInAnotherWay) {
  Reconstruction written = StreetReconstruction();
  written.images[0].name = "Stra\u00dfe/u\u0308ber 0.jpg";
  written.images[1].name = "Stra\u00dfe/u\u0308ber 1.jpg";
  ColmapInput input = Write(written);
  ExecuteRaw(input.database_path,
             "UPDATE images SET name = replace(name, 'u\u0308', '\u00fc') WHERE name LIKE 'Stra%'");
  input.image_names = {"stra\u00dfe/\u00fcber 0.JPG", "stra\u00dfe/\u00fcber 1.JPG"};
  const Reconstruction read = ReadColmap(input);
  ASSERT_EQ(read.images.size(), 2u);
  EXPECT_EQ(read.images[0].name, written.images[0].name);
  EXPECT_GT(read.images[0].features.size(), 0);
}

TEST_F(ColmapFiles, NamesOfAnotherDatabaseAreRefusedWithExamples) {
  const ColmapInput input = Write(StreetReconstruction());
  ExecuteRaw(input.database_path, "UPDATE images SET name = 'other_' || image_id || '.png'");
  EXPECT_THAT(RefusalOf(input), HasSubstr("'other_11.png'"));
}

TEST_F(ColmapFiles, EmptyMatricesAreNoFeatures) {
  Reconstruction written = StreetReconstruction();
  const ColmapInput input = Write(written);
  ExecuteRaw(input.database_path,
             "UPDATE descriptors SET rows = 0, cols = 0, data = x'' WHERE image_id = 11");
  const std::string message = RefusalOf(input);
  EXPECT_THAT(message, HasSubstr("descriptors are empty"));
  EXPECT_THAT(message, HasSubstr(written.images[0].name));
}

TEST_F(ColmapFiles, DescriptorsWithoutInformationAreRefused) {
  const ColmapInput input = Write(StreetReconstruction());
  const auto refusal_after = [&](const std::string& sql) {
    std::filesystem::copy_file(input.database_path, dir_.File("copy.db"),
                               std::filesystem::copy_options::overwrite_existing);
    ExecuteRaw(dir_.File("copy.db"), sql);
    ColmapInput changed = input;
    changed.database_path = dir_.File("copy.db");
    return RefusalOf(changed);
  };
  EXPECT_THAT(refusal_after("UPDATE descriptors SET data = zeroblob(length(data))"),
              HasSubstr("are zero"));
  EXPECT_THAT(refusal_after("UPDATE descriptors SET data = CAST(replace(hex(zeroblob(length(data) "
                            "/ 2)), '00', '-/') AS BLOB)"),
              HasSubstr("are equal"));
  // The rows of each image in another order: descriptors of real features, of other keypoints.
  EXPECT_THAT(refusal_after("UPDATE descriptors SET data = CAST(substr(data, 1 + 128 * (image_id % "
                            "7 + 3)) || substr(data, 1, 128 * (image_id % 7 + 3)) AS BLOB)"),
              HasSubstr("do not tell landmarks apart"));
}

// Gives up the rights of root, which may write everywhere, until the end of the test.
class AsNobody {
 public:
  AsNobody() : was_root_(geteuid() == 0) {
    if (was_root_ && seteuid(65534) != 0) {
      throw std::runtime_error("seteuid");
    }
  }
  ~AsNobody() {
    if (was_root_ && seteuid(0) != 0) {
      std::abort();
    }
  }

 private:
  bool was_root_;
};

// COLMAP leaves its database in WAL mode, in which SQLite wants to write files beside it.
TEST_F(ColmapFiles, DatabasesInWalModeAreReadFromFoldersThatCannotBeWritten) {
  const Reconstruction written = StreetReconstruction();
  const ColmapInput input = Write(written);
  ExecuteRaw(input.database_path, "PRAGMA journal_mode = WAL");
  chmod(input.database_path.c_str(), 0444);
  chmod(dir_.path().c_str(), 0555);
  {
    const AsNobody nobody;
    EXPECT_EQ(ReadColmap(input).images.size(), written.images.size());
  }
  chmod(dir_.path().c_str(), 0755);
  std::ofstream(input.database_path + "-wal") << "changes";
  chmod(dir_.path().c_str(), 0555);
  {
    const AsNobody nobody;
    const auto [code, message] = ErrorOf([&] { ReadColmap(input); });
    EXPECT_EQ(code, ErrorCode::kIo) << message;
    EXPECT_THAT(message, HasSubstr("database.db-wal"));
  }
  chmod(dir_.path().c_str(), 0755);
}

// A program that is killed leaves a journal, and a database with half of its changes.
TEST_F(ColmapFiles, AJournalOfAKilledProgramIsTakenBack) {
  const Reconstruction written = StreetReconstruction();
  ColmapInput input = Write(written);
  const std::string killed = dir_.File("killed.db");
  sqlite3* writer = nullptr;
  ASSERT_EQ(sqlite3_open(input.database_path.c_str(), &writer), SQLITE_OK);
  ASSERT_EQ(sqlite3_exec(writer,
                         "PRAGMA cache_size = 1; BEGIN; UPDATE keypoints SET rows = 0, data = x'';"
                         "CREATE TABLE filler(bytes); INSERT INTO filler VALUES(zeroblob(400000));",
                         nullptr, nullptr, nullptr),
            SQLITE_OK);
  std::filesystem::copy_file(input.database_path, killed);
  std::filesystem::copy_file(input.database_path + "-journal", killed + "-journal");
  ASSERT_EQ(sqlite3_close(writer), SQLITE_OK);
  input.database_path = killed;
  const Reconstruction read = ReadColmap(input);
  ASSERT_EQ(read.images.size(), written.images.size());
  EXPECT_EQ(read.images[0].features.keypoints.size(), written.images[0].features.keypoints.size());
  EXPECT_FALSE(std::filesystem::exists(killed + "-journal"));
}

TEST_F(ColmapFiles, ImagesOfOneNameAreRefused) {
  Reconstruction street = StreetReconstruction();
  const ColmapInput input = Write(street);
  const std::string name = street.images[0].name;
  street.images[2].name = name;
  WriteColmapModel(street, dir_.path().string(), ColmapModelFormat::kBinary);
  EXPECT_THAT(RefusalOf(input), HasSubstr("the image " + name + " occurs twice, with the ids"));
}

TEST_F(ColmapFiles, AKeypointSeesOnePoint) {
  Reconstruction street = StreetReconstruction();
  const size_t num_landmarks = street.landmarks.size();
  street.landmarks.push_back(street.landmarks[0]);
  EXPECT_EQ(ReadColmap(Write(street)).landmarks.size(), num_landmarks);
}

// Exporters of poses leave the line of keypoints empty.
TEST_F(ColmapFiles, AnImageWithoutKeypointsHasThoseOfTheDatabase) {
  const Reconstruction street = StreetReconstruction();
  const ColmapInput input = Write(street);
  Reconstruction emptied = street;
  emptied.images[0].features.keypoints.clear();
  emptied.images[0].features.descriptors = {};
  for (ReconLandmark& landmark : emptied.landmarks) {
    std::erase_if(landmark.observations, [](const auto& seen) { return seen.image_idx == 0; });
  }
  std::erase_if(emptied.landmarks,
                [](const auto& landmark) { return landmark.observations.size() < 2; });
  WriteColmapModel(emptied, dir_.path().string(), ColmapModelFormat::kBinary);
  const Reconstruction read = ReadColmap(input);
  EXPECT_EQ(read.images[0].features.keypoints.size(), street.images[0].features.keypoints.size());
  EXPECT_EQ(read.landmarks.size(), emptied.landmarks.size());
}

// Queries need no points.
TEST_F(ColmapFiles, PosesWithoutPointsAreReadWithAWord) {
  Reconstruction street = StreetReconstruction();
  street.landmarks.clear();
  ::testing::internal::CaptureStderr();
  const Reconstruction read = ReadColmap(Write(street));
  const std::string log = ::testing::internal::GetCapturedStderr();
  EXPECT_EQ(read.images.size(), street.images.size());
  EXPECT_TRUE(read.landmarks.empty());
  EXPECT_THAT(log, HasSubstr("point_triangulator"));
}

TEST_F(ColmapFiles, LinesOfOldMacsAreNoticed) {
  const ColmapInput input = Write(StreetReconstruction(), /*binary=*/false);
  Rewrite("images.txt", [](std::string text) {
    std::replace(text.begin(), text.end(), '\n', '\r');
    return text;
  });
  EXPECT_THAT(RefusalOf(input), HasSubstr("end with CR alone"));
}

}  // namespace
}  // namespace cairn
