#include "ingest/colmap/colmap_pose_priors.h"

#include <gmock/gmock.h>

#include <Eigen/Core>
#include <cmath>

#include "core/error.h"
#include "ingest/colmap/write_colmap.h"
#include "ingest/colmap_fixture.h"
#include "ingest/place/georegister.h"
#include "storage/database/sqlite/connection.h"
#include "support/map_builder.h"
#include "support/raw_sql.h"
#include "support/reconstruction_builder.h"

namespace cairn {
namespace {

using testing::StreetReconstruction;

class ColmapPosePriors : public testing::ColmapTest {
 protected:
  void Execute(const std::string& sql) {
    sqlite::Connection(dir_.File("database.db"), sqlite::Access::kReadWrite, 100).Execute(sql);
  }
};

class ColmapGps : public ColmapPosePriors, public ::testing::WithParamInterface<ColmapGpsTable> {};

TEST_P(ColmapGps, IsReadFromEverySchema) {
  const Reconstruction written = StreetReconstruction();
  const Reconstruction read = ReadColmap(Write(written, true, {.gps = GetParam()}));
  for (size_t i = 0; i < read.images.size(); ++i) {
    ASSERT_TRUE(read.images[i].gps.has_value());
    EXPECT_LT(GroundDistanceM(*read.images[i].gps, *written.images[i].gps), 1e-3);
    EXPECT_NEAR(read.images[i].gps->h_m, written.images[i].gps->h_m, 1e-6);
    EXPECT_FALSE(read.images[i].gps_accuracy_m.has_value());
    EXPECT_FALSE(read.images[i].down_in_cam.has_value());
  }
}

INSTANTIATE_TEST_SUITE_P(Schemas, ColmapGps,
                         ::testing::Values(ColmapGpsTable::kImageColumns,
                                           ColmapGpsTable::kPosePriorsOfImages,
                                           ColmapGpsTable::kPosePriorsOfData,
                                           ColmapGpsTable::kPosePriorsWithGravity));

TEST_F(ColmapPosePriors, AccuracyAndGravityOfColmap4AreRead) {
  Reconstruction written = StreetReconstruction();
  written.images[1].gps_accuracy_m = 0.5;
  written.images[2].down_in_cam = Eigen::Vector3d(1.0, 0.2, 0.1).normalized();
  written.images[3].down_in_cam = Eigen::Vector3d(0.0, 1.0, 0.0);
  written.images[3].gps.reset();
  const Reconstruction read =
      ReadColmap(Write(written, true, {.gps = ColmapGpsTable::kPosePriorsWithGravity}));
  EXPECT_FALSE(read.images[0].gps_accuracy_m || read.images[0].down_in_cam);
  EXPECT_NEAR(read.images[1].gps_accuracy_m.value(), 0.5, 1e-9);
  EXPECT_LT((read.images[2].down_in_cam.value() - *written.images[2].down_in_cam).norm(), 1e-12);
  EXPECT_FALSE(read.images[3].gps.has_value());
  EXPECT_LT((read.images[3].down_in_cam.value() - *written.images[3].down_in_cam).norm(), 1e-12);
  const auto positions = GpsPositions(read, 7.0);
  EXPECT_EQ(positions[0].accuracy_m, 7.0);
  EXPECT_NEAR(positions[1].accuracy_m, 0.5, 1e-9);
}

// A newer COLMAP that opens an old database adds the table and copies nothing into it.
TEST_F(ColmapPosePriors, ColumnsCountBesideAnEmptyTable) {
  const ColmapInput input =
      Write(StreetReconstruction(), true, {.gps = ColmapGpsTable::kImageColumns});
  Execute(
      "CREATE TABLE pose_priors (pose_prior_id INTEGER PRIMARY KEY NOT NULL, corr_data_id INTEGER "
      "NOT NULL, corr_sensor_id INTEGER NOT NULL, corr_sensor_type INTEGER NOT NULL, position "
      "BLOB, position_covariance BLOB, gravity BLOB, coordinate_system INTEGER NOT NULL);"
      "ALTER TABLE descriptors ADD COLUMN type INTEGER NOT NULL DEFAULT 0;");
  for (const ReconImage& image : ReadColmap(input).images) {
    EXPECT_TRUE(image.gps.has_value()) << image.name;
  }
}

TEST_F(ColmapPosePriors, PriorsOfOtherSensorsAreIgnored) {
  const ColmapInput input =
      Write(StreetReconstruction(), true, {.gps = ColmapGpsTable::kPosePriorsWithGravity});
  Execute("UPDATE pose_priors SET corr_sensor_type = 1");
  EXPECT_FALSE(ReadColmap(input).images[0].gps.has_value());
}

TEST_F(ColmapPosePriors, CartesianPositionsAreNoGps) {
  Reconstruction written = StreetReconstruction();
  written.images[0].down_in_cam = Eigen::Vector3d::UnitY();
  const ColmapInput input = Write(written, true, {.gps = ColmapGpsTable::kPosePriorsWithGravity});
  Execute("UPDATE pose_priors SET coordinate_system = 1");
  const Reconstruction read = ReadColmap(input);
  EXPECT_FALSE(read.images[0].gps.has_value());
  EXPECT_TRUE(read.images[0].down_in_cam.has_value());
}

TEST_F(ColmapPosePriors, BlobsOfOtherSizesAndZerosAreUnknown) {
  Reconstruction written = StreetReconstruction();
  for (ReconImage& image : written.images) {
    image.gps_accuracy_m = 1.0;
    image.down_in_cam = Eigen::Vector3d::UnitY();
  }
  const ColmapInput input = Write(written, true, {.gps = ColmapGpsTable::kPosePriorsWithGravity});
  Execute(
      "UPDATE pose_priors SET gravity = zeroblob(24), position_covariance = zeroblob(72);"
      "UPDATE pose_priors SET gravity = x'00', position_covariance = x'' WHERE corr_data_id = 12;"
      "UPDATE pose_priors SET gravity = NULL, position_covariance = NULL WHERE corr_data_id = 13");
  for (const ReconImage& image : ReadColmap(input).images) {
    EXPECT_TRUE(image.gps.has_value());
    EXPECT_FALSE(image.gps_accuracy_m || image.down_in_cam) << image.name;
  }
}

// Text was taken for latitude 0.
TEST_F(ColmapPosePriors, GpsThatIsTextIsRefused) {
  const ColmapInput input =
      Write(StreetReconstruction(), true, {.gps = ColmapGpsTable::kImageColumns});
  testing::ExecuteRaw(input.database_path, "UPDATE images SET prior_ty = 'north'");
  EXPECT_EQ(testing::ErrorCodeOf([&] { ReadColmap(input); }), ErrorCode::kBadInput);
}

TEST_F(ColmapPosePriors, GpsInWholeDegreesIsGps) {
  const ColmapInput input =
      Write(StreetReconstruction(), true, {.gps = ColmapGpsTable::kImageColumns});
  testing::ExecuteRaw(input.database_path,
                      "CREATE TABLE whole AS SELECT image_id, name, camera_id, 47 AS prior_tx, "
                      "8 AS prior_ty, NULL AS prior_tz FROM images; DROP TABLE images; "
                      "ALTER TABLE whole RENAME TO images");
  const auto gps = ReadColmap(input).images[0].gps;
  ASSERT_TRUE(gps.has_value());
  EXPECT_NEAR(gps->lat_deg(), 47.0, 1e-12);
  EXPECT_EQ(gps->h_m, 0.0);
}

TEST_F(ColmapPosePriors, GpsThatIsNotOnEarthIsLeftOutWithAWord) {
  const ColmapInput input =
      Write(StreetReconstruction(), true, {.gps = ColmapGpsTable::kImageColumns});
  const Reconstruction written = ReadColmap(input);
  const auto change = [&](int image, const std::string& what) {
    testing::ExecuteRaw(input.database_path, "UPDATE images SET " + what + " WHERE name = '" +
                                                 written.images[image].name + "'");
  };
  change(0, "prior_tx = 200.0");
  change(1, "prior_ty = -9e999");
  change(2, "prior_tz = 1e6");
  ::testing::internal::CaptureStderr();
  const Reconstruction read = ReadColmap(input);
  EXPECT_THAT(::testing::internal::GetCapturedStderr(),
              ::testing::HasSubstr("2 of its positions are ignored because they are no latitude"));
  EXPECT_FALSE(read.images[0].gps || read.images[1].gps);
  // The checks of positions take such a height for none.
  EXPECT_EQ(read.images[2].gps.value().h_m, Geodetic::kMaxHeightM);
}

TEST_F(ColmapPosePriors, GpsAtNullIslandIsNoGps) {
  Reconstruction written = StreetReconstruction();
  written.images[0].gps = Geodetic{};
  EXPECT_FALSE(ReadColmap(Write(written)).images[0].gps.has_value());
}

}  // namespace
}  // namespace cairn
