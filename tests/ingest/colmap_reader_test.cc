#include "ingest/colmap/colmap_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <utility>

#include "core/error.h"
#include "core/focal_length.h"
#include "core/keypoint_shape.h"
#include "ingest/colmap/colmap_model.h"
#include "ingest/colmap/write_colmap.h"
#include "ingest/colmap_fixture.h"
#include "storage/codebook/descriptor_codec.h"
#include "storage/database/sqlite/connection.h"
#include "support/map_builder.h"
#include "support/raw_sql.h"
#include "support/reconstruction_builder.h"
#include "support/temp_dir.h"

namespace cairn {
namespace {

using testing::ErrorOf;
using ::testing::HasSubstr;
using testing::StreetReconstruction;

// Two landmarks and two images with two keypoints: a model of a few hundred bytes.
Reconstruction TinyModel() {
  Reconstruction model = StreetReconstruction();
  model.images.resize(2);
  model.landmarks.resize(2);
  for (ReconImage& image : model.images) {
    image.features.keypoints.resize(2);
    image.features.descriptors = image.features.descriptors.Rows(std::vector<int>{0, 1});
  }
  for (int i = 0; i < 2; ++i) {
    model.landmarks[i].observations = {{0, i}, {1, i}};
  }
  return model;
}

std::string ReadAll(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void WriteAll(const std::string& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

class ColmapReader : public testing::ColmapTest {};

void ExpectSameReconstruction(const Reconstruction& read, const Reconstruction& written) {
  ASSERT_EQ(read.cameras.size(), written.cameras.size());
  EXPECT_EQ(read.cameras[0].params(), written.cameras[0].params());
  ASSERT_EQ(read.images.size(), written.images.size());
  for (size_t i = 0; i < read.images.size(); ++i) {
    const ReconImage& a = read.images[i];
    const ReconImage& b = written.images[i];
    EXPECT_EQ(a.name, b.name);
    EXPECT_LT(RotationAngleRad(a.cam_from_world.rotation, b.cam_from_world.rotation), 1e-7);
    EXPECT_LT((a.cam_from_world.translation - b.cam_from_world.translation).norm(), 1e-12);
    ASSERT_EQ(a.features.size(), b.features.size());
    for (int k = 0; k < a.features.size(); ++k) {
      EXPECT_FLOAT_EQ(a.features.keypoints[k].x_px, b.features.keypoints[k].x_px);
      EXPECT_FLOAT_EQ(a.features.keypoints[k].y_px, b.features.keypoints[k].y_px);
    }
  }
  ASSERT_EQ(read.landmarks.size(), written.landmarks.size());
  for (size_t i = 0; i < read.landmarks.size(); ++i) {
    EXPECT_LT((read.landmarks[i].x_in_world - written.landmarks[i].x_in_world).norm(), 1e-12);
    EXPECT_EQ(read.landmarks[i].observations.size(), written.landmarks[i].observations.size());
  }
}

TEST_F(ColmapReader, ReadsBinaryModels) {
  const Reconstruction written = StreetReconstruction();
  ExpectSameReconstruction(ReadColmap(Write(written)), written);
}

TEST_F(ColmapReader, ReadsTextModels) {
  const Reconstruction written = StreetReconstruction();
  ExpectSameReconstruction(ReadColmap(Write(written, /*binary=*/false)), written);
}

TEST_F(ColmapReader, UndoesTheSquareRootOfColmapsDescriptors) {
  const Reconstruction written = StreetReconstruction();
  DescriptorMatrix read = ReadColmap(Write(written)).images[0].features.descriptors.Unpacked();
  DescriptorMatrix expected = written.images[0].features.descriptors.Unpacked();
  NormalizeDescriptors(DescriptorNormalization::kRootSift, &read);
  NormalizeDescriptors(DescriptorNormalization::kRootSift, &expected);
  EXPECT_LT((read - expected).cwiseAbs().maxCoeff(), 1.0f / 512.0f);
}

TEST_F(ColmapReader, ReadsAffineShapesAsScaleAndOrientation) {
  const Reconstruction written = StreetReconstruction();
  const Reconstruction read = ReadColmap(Write(written));
  for (int k = 0; k < read.images[0].features.size(); ++k) {
    const Keypoint& a = read.images[0].features.keypoints[k];
    const Keypoint& b = written.images[0].features.keypoints[k];
    EXPECT_NEAR(a.scale_px, b.scale_px, 1e-4 * b.scale_px);
    EXPECT_NEAR(WrapAngleRad(a.orientation_rad - b.orientation_rad), 0.0, 1e-4);
  }
}

TEST_F(ColmapReader, ReadsKeypointsOfFourAndTwoColumns) {
  const Reconstruction written = StreetReconstruction();
  const Keypoint& expected = written.images[0].features.keypoints[0];
  const Reconstruction four = ReadColmap(Write(written, true, {.keypoint_columns = 4}));
  EXPECT_FLOAT_EQ(four.images[0].features.keypoints[0].scale_px, expected.scale_px);
  EXPECT_FLOAT_EQ(four.images[0].features.keypoints[0].orientation_rad, expected.orientation_rad);
  std::filesystem::remove(dir_.File("database.db"));
  const Reconstruction two = ReadColmap(Write(written, true, {.keypoint_columns = 2}));
  EXPECT_FLOAT_EQ(two.images[0].features.keypoints[0].x_px, expected.x_px);
  EXPECT_FALSE(HasScale(two.images[0].features.keypoints[0]));
  EXPECT_FALSE(HasOrientation(two.images[0].features.keypoints[0]));
}

// Positions fit such a model, whose landmarks are triangulated again with the wrong cameras.
TEST_F(ColmapReader, CamerasThatDoNotMakeThePointsOfTheModelAreRefused) {
  const Reconstruction right = StreetReconstruction();
  const ColmapInput input = Write(right);
  const auto read_with_focal = [&](double factor) {
    Reconstruction scaled = right;
    for (Camera& camera : scaled.cameras) {
      camera = WithFocalScaled(camera, factor);
    }
    WriteColmapModel(scaled, input.model_dir, ColmapModelFormat::kBinary);
    ReadColmap(input);
  };
  for (const double factor : {0.5, 0.9, 1.2, 2.0}) {
    EXPECT_THAT(ErrorOf([&] { read_with_focal(factor); }).second,
                HasSubstr("its points are not where its photos see them"))
        << factor;
  }
  EXPECT_NO_THROW(read_with_focal(1.005));
}

TEST_F(ColmapReader, ImagesThatAreAViewWithoutEndAreRefused) {
  const ColmapInput input = Write(StreetReconstruction());
  testing::ExecuteRaw(input.database_path,
                      "DROP TABLE images; CREATE VIEW images AS WITH RECURSIVE n(image_id) AS "
                      "(SELECT 1 UNION ALL SELECT image_id + 1 FROM n) "
                      "SELECT image_id, 'none' AS name FROM n");
  EXPECT_EQ(testing::ErrorCodeOf([&] { ReadColmap(input); }), ErrorCode::kBadInput);
}

TEST_F(ColmapReader, RestrictedReadTriangulatesFromTheRemainingImagesAlone) {
  Reconstruction written = StreetReconstruction();
  const Reconstruction truth = written;
  // Positions in the file that only the images left out could explain.
  for (ReconLandmark& landmark : written.landmarks) {
    landmark.x_in_world.array() += 0.1;
  }
  ColmapInput input = Write(written);
  input.image_names = {"0000.jpg", "0001.jpg", "0003.jpg"};
  const Reconstruction read = ReadColmap(input);
  ASSERT_EQ(read.images.size(), 3u);
  ASSERT_GT(read.landmarks.size(), 20u);
  size_t num_expected = 0, next = 0;
  for (const ReconLandmark& landmark : truth.landmarks) {
    int num_left = 0;
    for (const ReconObservation& observation : landmark.observations) {
      num_left +=
          observation.image_idx == 0 || observation.image_idx == 1 || observation.image_idx == 3;
    }
    if (num_left < 2) {
      continue;
    }
    ++num_expected;
    if (next < read.landmarks.size() &&
        (read.landmarks[next].x_in_world - landmark.x_in_world).norm() < 0.1) {
      ++next;
    }
  }
  EXPECT_GE(read.landmarks.size(), num_expected * 9 / 10);
  EXPECT_GE(next, num_expected * 8 / 10);
  for (const ReconLandmark& landmark : read.landmarks) {
    EXPECT_GE(landmark.observations.size(), 2u);
  }
}

TEST_F(ColmapReader, RefusesNamesThatNeitherModelNorDatabaseHas) {
  ColmapInput input = Write(StreetReconstruction());
  input.image_names = {"0000.jpg", "nowhere.jpg"};
  const auto [code, message] = ErrorOf([&] { ReadColmap(input); });
  EXPECT_EQ(code, ErrorCode::kBadInput);
  EXPECT_THAT(message, HasSubstr("nowhere.jpg"));
}

TEST_F(ColmapReader, LeavesOutNamesThatWereNotRegistered) {
  ColmapInput input = Write(StreetReconstruction());
  sqlite::Connection(input.database_path, sqlite::Access::kReadWrite, 100)
      .Execute("INSERT INTO images (image_id, name, camera_id) VALUES (9001, 'dark.jpg', 1)");
  input.image_names = {"0000.jpg", "0001.jpg", "0003.jpg"};
  const size_t num_landmarks = ReadColmap(input).landmarks.size();
  input.image_names.push_back("dark.jpg");
  const Reconstruction read = ReadColmap(input);
  EXPECT_EQ(read.images.size(), 3u);
  EXPECT_EQ(read.landmarks.size(), num_landmarks);

  input.image_names = {"dark.jpg"};
  const auto [code, message] = ErrorOf([&] { ReadColmap(input); });
  EXPECT_EQ(code, ErrorCode::kBadInput);
  EXPECT_THAT(message, HasSubstr("none of the 1 requested images"));
}

TEST_F(ColmapReader, RefusesADatabaseWithoutDescriptors) {
  const ColmapInput input = Write(StreetReconstruction());
  sqlite::Connection(input.database_path, sqlite::Access::kReadWrite, 100)
      .Execute("DELETE FROM descriptors WHERE image_id = 12");
  const auto [code, message] = ErrorOf([&] { ReadColmap(input); });
  EXPECT_EQ(code, ErrorCode::kBadInput);
  EXPECT_THAT(message, HasSubstr("no descriptors for image 0001.jpg"));
}

TEST_F(ColmapReader, RefusesADatabaseOfAnotherModel) {
  ColmapInput input = Write(StreetReconstruction());
  testing::StreetWorldOptions options;
  options.seed = 5;
  input.database_path = dir_.File("other.db");
  WriteColmapDatabase(testing::StreetWorld(options).Reconstruct(), input.database_path, {});
  EXPECT_EQ(ErrorOf([&] { ReadColmap(input); }).first, ErrorCode::kBadInput);
}

TEST_F(ColmapReader, RefusesAFileThatIsNoDatabase) {
  ColmapInput input = Write(StreetReconstruction());
  input.database_path = dir_.File("images.bin");
  EXPECT_EQ(ErrorOf([&] { ReadColmap(input); }).first, ErrorCode::kBadInput);
  input.database_path = dir_.File("missing.db");
  EXPECT_EQ(ErrorOf([&] { ReadColmap(input); }).first, ErrorCode::kNotFound);
}

TEST_F(ColmapReader, RefusesBlobsOfTheWrongSize) {
  const ColmapInput input = Write(StreetReconstruction());
  sqlite::Connection(input.database_path, sqlite::Access::kReadWrite, 100)
      .Execute("UPDATE keypoints SET rows = rows + 1 WHERE image_id = 11");
  EXPECT_EQ(ErrorOf([&] { ReadColmap(input); }).first, ErrorCode::kBadInput);
}

// COLMAP 3.12 writes rigs and frames beside the images, which have their whole poses still.
TEST_F(ColmapReader, RigsAndFramesOfColmap312ChangeNothing) {
  const Reconstruction written = StreetReconstruction();
  const ColmapInput input = Write(written, true, {.gps = ColmapGpsTable::kPosePriorsOfData});
  WriteAll(dir_.File("rigs.bin"), std::string("\1\0\0\0\0\0\0\0 a rig", 14));
  WriteAll(dir_.File("frames.bin"), "frames");
  sqlite::Connection(input.database_path, sqlite::Access::kReadWrite, 100)
      .Execute(
          "CREATE TABLE rigs (rig_id INTEGER PRIMARY KEY, ref_sensor_id INTEGER, "
          "ref_sensor_type INTEGER);"
          "CREATE TABLE rig_sensors (rig_id INTEGER, sensor_id INTEGER, sensor_type INTEGER, "
          "sensor_from_rig BLOB);"
          "CREATE TABLE frames (frame_id INTEGER PRIMARY KEY, rig_id INTEGER);"
          "CREATE TABLE frame_data (frame_id INTEGER, data_id INTEGER, sensor_id INTEGER, "
          "sensor_type INTEGER);");
  const Reconstruction read = ReadColmap(input);
  ExpectSameReconstruction(read, written);
  EXPECT_TRUE(read.images[0].gps.has_value());
}

TEST_F(ColmapReader, RefusesAnUnknownCameraModel) {
  const ColmapInput input = Write(TinyModel());
  std::string bytes = ReadAll(dir_.File("cameras.bin"));
  bytes[12] = 16;
  WriteAll(dir_.File("cameras.bin"), bytes);
  const auto [code, message] = ErrorOf([&] { ReadColmap(input); });
  EXPECT_EQ(code, ErrorCode::kBadInput);
  EXPECT_THAT(message, HasSubstr("cameras.bin"));
  EXPECT_THAT(message, HasSubstr("EUCM) is not supported"));
}

TEST_F(ColmapReader, ReadsPosesWithoutADatabase) {
  Reconstruction written = StreetReconstruction();
  std::swap(written.images.front().name, written.images.back().name);  // Not by name in the file.
  const ColmapInput input = Write(written);
  const Reconstruction whole = ReadColmap(input);
  std::filesystem::remove(input.database_path);
  const Reconstruction poses = ReadColmapPoses(input.model_dir);
  ASSERT_EQ(poses.cameras.size(), whole.cameras.size());
  EXPECT_EQ(poses.cameras[0].params(), whole.cameras[0].params());
  ASSERT_EQ(poses.images.size(), whole.images.size());
  for (size_t i = 0; i < poses.images.size(); ++i) {
    const ReconImage& a = poses.images[i];
    const ReconImage& b = whole.images[i];
    EXPECT_TRUE(i == 0 || poses.images[i - 1].name < a.name);
    EXPECT_EQ(a.name, b.name);
    EXPECT_EQ(a.camera_idx, b.camera_idx);
    EXPECT_EQ(a.cam_from_world.translation, b.cam_from_world.translation);
    EXPECT_EQ(a.cam_from_world.rotation.coeffs(), b.cam_from_world.rotation.coeffs());
    EXPECT_EQ(a.features.size(), 0);
  }
  EXPECT_TRUE(poses.landmarks.empty());
}

TEST_F(ColmapReader, RefusesPosesOfAnUnknownCameraModel) {
  const ColmapInput input = Write(TinyModel());
  std::string bytes = ReadAll(dir_.File("cameras.bin"));
  bytes[12] = 16;
  WriteAll(dir_.File("cameras.bin"), bytes);
  const auto [code, message] = ErrorOf([&] { ReadColmapPoses(input.model_dir); });
  EXPECT_EQ(code, ErrorCode::kBadInput);
  EXPECT_THAT(message, HasSubstr("EUCM) is not supported"));
}

TEST_F(ColmapReader, SaysWhereAMissingModelWasExpected) {
  const auto [code, message] = ErrorOf([&] { ReadColmapModel(dir_.path().string()); });
  EXPECT_EQ(code, ErrorCode::kNotFound);
  EXPECT_THAT(message, HasSubstr(dir_.path().string()));
}

TEST_F(ColmapReader, EveryTruncationOfABinaryModelIsAnErrorThatNamesTheFile) {
  Write(TinyModel());
  for (const char* name : {"cameras.bin", "images.bin", "points3D.bin"}) {
    const std::string whole = ReadAll(dir_.File(name));
    for (size_t size = 0; size < whole.size(); ++size) {
      WriteAll(dir_.File(name), whole.substr(0, size));
      const auto [code, message] = ErrorOf([&] { ReadColmapModel(dir_.path().string()); });
      ASSERT_EQ(code, ErrorCode::kBadInput) << name << " cut to " << size;
      ASSERT_THAT(message, HasSubstr(name));
    }
    WriteAll(dir_.File(name), whole);
  }
  EXPECT_NO_THROW(ReadColmapModel(dir_.path().string()));
}

TEST_F(ColmapReader, NoFlippedByteOfABinaryModelGetsPastTheChecksUnharmed) {
  const ColmapInput input = Write(TinyModel());
  for (const char* name : {"cameras.bin", "images.bin", "points3D.bin"}) {
    const std::string whole = ReadAll(dir_.File(name));
    for (size_t i = 0; i < whole.size(); ++i) {
      std::string flipped = whole;
      flipped[i] = static_cast<char>(flipped[i] ^ 0xff);
      WriteAll(dir_.File(name), flipped);
      try {  // Either a sound reconstruction or an Error.
        if (i % 8 == 0) {
          ReadColmap(input).Validate();
        } else {
          ReadColmapModel(input.model_dir);  // Opens no database: much faster.
        }
      } catch (const Error& e) {
        ASSERT_EQ(e.code(), ErrorCode::kBadInput) << name << " byte " << i << ": " << e.what();
      }
    }
    WriteAll(dir_.File(name), whole);
  }
}

TEST_F(ColmapReader, TextErrorsNameTheLine) {
  Write(TinyModel(), /*binary=*/false);
  std::string cameras = ReadAll(dir_.File("cameras.txt"));
  WriteAll(dir_.File("cameras.txt"), cameras + "4 PINHOLE 640 abc 1 1 1 1\n");
  const auto [code, message] = ErrorOf([&] { ReadColmapModel(dir_.path().string()); });
  EXPECT_EQ(code, ErrorCode::kBadInput);
  EXPECT_THAT(message, HasSubstr("cameras.txt: line 3"));
  EXPECT_THAT(message, HasSubstr("abc"));
}

TEST_F(ColmapReader, TextModelsMayWriteWholeNumbersWithFractionsAndSigns) {
  Write(TinyModel(), /*binary=*/false);
  const std::string cameras = ReadAll(dir_.File("cameras.txt"));
  WriteAll(dir_.File("cameras.txt"), cameras + "4 SIMPLE_PINHOLE +640 480.00 +500.5 320 240\n");
  const Camera camera = ReadColmapModel(dir_.path().string()).cameras.at(4);
  EXPECT_EQ(camera.width_px(), 640);
  EXPECT_EQ(camera.height_px(), 480);
  EXPECT_EQ(camera.focal_px(), 500.5);
  for (const char* bad : {"640.5", "640.x", "+-640", "640,0", "640.0.0"}) {
    WriteAll(dir_.File("cameras.txt"), cameras + "4 SIMPLE_PINHOLE " + bad + " 480 500 320 240\n");
    const auto [code, message] = ErrorOf([&] { ReadColmapModel(dir_.path().string()); });
    EXPECT_EQ(code, ErrorCode::kBadInput);
    EXPECT_THAT(message, HasSubstr("line 3: '" + std::string(bad) + "' is not a valid width"));
  }
}

TEST_F(ColmapReader, TruncatedTextModelsNeverCrash) {
  Write(TinyModel(), /*binary=*/false);
  for (const char* name : {"cameras.txt", "images.txt", "points3D.txt"}) {
    const std::string whole = ReadAll(dir_.File(name));
    for (size_t size = 0; size < whole.size(); ++size) {
      WriteAll(dir_.File(name), whole.substr(0, size));
      try {
        ReadColmapModel(dir_.path().string());
      } catch (const Error& e) {
        ASSERT_EQ(e.code(), ErrorCode::kBadInput) << e.what();
      }
    }
    WriteAll(dir_.File(name), whole);
  }
}

TEST(ImageList, SkipsBlanksAndComments) {
  const testing::TempDir dir;
  WriteAll(dir.File("list.txt"), "# even frames\n\n a.jpg \r\nfolder/b c.jpg\n");
  EXPECT_EQ(ReadImageList(dir.File("list.txt")),
            (std::vector<std::string>{"a.jpg", "folder/b c.jpg"}));
  EXPECT_EQ(ErrorOf([&] { ReadImageList(dir.File("none.txt")); }).first, ErrorCode::kNotFound);
}

}  // namespace
}  // namespace cairn
