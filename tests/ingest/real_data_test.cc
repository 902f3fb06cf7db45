// Tests the whole ingest on real reconstructions.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "core/angles.h"
#include "core/features/sift/sift_extractor.h"
#include "core/frames.h"
#include "core/statistics.h"
#include "ingest/colmap/colmap_reader.h"
#include "ingest/ingest_session.h"
#include "ingest/place/georegister.h"
#include "storage/codebook/descriptor_codec.h"
#include "support/temp_dir.h"
#include "support/test_data.h"

namespace cairn {
namespace {

ColmapInput KittiInput() {
  const auto dir = testing::TestDataDir() / "kitti_vo_2x51";
  return {(dir / "colmap_model_seq1").string(), (dir / "database_seq1.db").string(), {}};
}

ColmapInput LundInput() {
  const auto dir = testing::TestDataDir() / "street_lund";
  return {(dir / "colmap_model").string(), (dir / "database.db").string(), {}};
}

std::vector<std::string> EvenKittiFrames() {
  std::vector<std::string> names;
  for (int i = 0; i <= 50; i += 2) {
    names.push_back("0000" + std::string(i < 10 ? "0" : "") + std::to_string(i) + ".png");
  }
  return names;
}

// Angle between the camera's x axis and the horizontal, degrees, per image.
std::vector<double> RollsDeg(const Reconstruction& reconstruction, const Sim3d& ecef_from_world) {
  std::vector<double> rolls_deg;
  for (const ReconImage& image : reconstruction.images) {
    const Rigid3d ecef_from_cam = CamFromTarget(image.cam_from_world, ecef_from_world).Inverse();
    const Rigid3d ecef_from_enu = EcefFromEnu(GeodeticFromEcef(ecef_from_cam.translation));
    const Eigen::Vector3d right_in_enu =
        ecef_from_enu.rotation.conjugate() * (ecef_from_cam.rotation * Eigen::Vector3d::UnitX());
    rolls_deg.push_back(std::asin(right_in_enu.z()) * kDegPerRad);
  }
  return rolls_deg;
}

TEST(RealData, KittiReadsWhole) {
  CAIRN_SKIP_WITHOUT_DATA("kitti_vo_2x51");
  const Reconstruction reconstruction = ReadColmap(KittiInput());
  EXPECT_EQ(reconstruction.images.size(), 51u);
  EXPECT_EQ(reconstruction.landmarks.size(), 11984u);
  EXPECT_EQ(reconstruction.descriptor_type, "sift");
}

TEST(RealData, KittiFitsItsExactPositions) {
  CAIRN_SKIP_WITHOUT_DATA("kitti_vo_2x51");
  ColmapInput input = KittiInput();
  input.image_names = EvenKittiFrames();
  const Reconstruction reconstruction = ReadColmap(input);
  const auto positions =
      ReadCameraPositions((testing::TestDataDir() / "kitti_vo_2x51" / "georef_seq1.csv").string());
  const Georegistration result = Georegister(reconstruction, positions, GeoregisterOptions());
  std::printf("KITTI: %d positions, median %.4f m, max %.4f m, %zu landmarks\n",
              result.num_positions, result.median_residual_m, result.max_residual_m,
              reconstruction.landmarks.size());
  EXPECT_EQ(result.num_positions, 26);
  EXPECT_EQ(result.num_inliers, 26);
  EXPECT_LT(result.median_residual_m, 0.03);
  EXPECT_LT(result.max_residual_m, 0.1);
  // A car on a straight and level road.
  for (const double roll_deg : RollsDeg(reconstruction, result.ecef_from_world)) {
    EXPECT_NEAR(roll_deg, 0.0, 3.0);
  }
}

TEST(RealData, LundIsLevelOnGpsAlone) {
  CAIRN_SKIP_WITHOUT_DATA("street_lund");
  const Reconstruction reconstruction = ReadColmap(LundInput());
  auto positions = GpsPositions(reconstruction, 5.0);
  ASSERT_EQ(positions.size(), 29u);
  MakeHeightsEllipsoidal(HeightReference::kMeanSeaLevel, HeightReference::kEllipsoid, &positions);
  const Georegistration result = Georegister(reconstruction, positions, GeoregisterOptions());
  std::vector<double> rolls_deg = RollsDeg(reconstruction, result.ecef_from_world);
  std::vector<double> heights_m;
  for (const ReconImage& image : reconstruction.images) {
    heights_m.push_back(
        GeodeticFromEcef(result.ecef_from_world * image.cam_from_world.Inverse().translation).h_m);
  }
  std::sort(heights_m.begin(), heights_m.end());
  std::printf("Lund: median residual %.2f m, median roll %.2f deg, heights %.1f to %.1f m\n",
              result.median_residual_m, Median(rolls_deg), heights_m.front(),
              heights_m[heights_m.size() - 2]);
  EXPECT_LT(result.median_residual_m, 5.0);
  // The pose of 20.jpg is wrong in the model itself, by 55 m.
  EXPECT_EQ(result.num_inliers, 28);
  EXPECT_NEAR(Median(rolls_deg), 0.0, 1.0);
  EXPECT_LT(heights_m[heights_m.size() - 2] - heights_m.front(), 5.0);
  // The photos' EXIF says 30 to 40 m, above the sea; the ellipsoid is 35.7 m lower.
  EXPECT_NEAR(heights_m[heights_m.size() / 2], 36.0 + 35.7, 6.0);
}

// A phone held upright stores its pictures lying: the x axes of the cameras point to the ground.
TEST(RealData, LundWithThePhoneHeldUprightIsLevel) {
  CAIRN_SKIP_WITHOUT_DATA("street_lund");
  Reconstruction reconstruction = ReadColmap(LundInput());
  const Sim3d level =
      Georegister(reconstruction, GpsPositions(reconstruction, 5.0), {}).ecef_from_world;
  const Rigid3d turn{Eigen::Quaterniond(Eigen::AngleAxisd(-0.5 * kPi, Eigen::Vector3d::UnitZ())),
                     Eigen::Vector3d::Zero()};
  for (ReconImage& image : reconstruction.images) {
    image.cam_from_world = turn * image.cam_from_world;
  }
  const Georegistration turned = Georegister(reconstruction, GpsPositions(reconstruction, 5.0), {});
  EXPECT_LT(RotationAngleRad(turned.ecef_from_world.rotation, level.rotation), 0.02);
  EXPECT_GE(turned.up.num_images[static_cast<size_t>(PictureUp::kLeft)], 26);
}

// The extractor's keypoints and descriptors are those in COLMAP's database, for the features that
// both detectors find.
TEST(RealData, ExtractedSiftAgreesWithColmap) {
  CAIRN_SKIP_WITHOUT_DATA("kitti_vo_2x51");
  ColmapInput input = KittiInput();
  input.image_names = {"000010.png", "000012.png"};
  FeatureSet colmap = ReadColmap(input).images[0].features.Unpacked();
  FeatureSet ours = ExtractSift(ReadGrayImage((testing::TestDataDir() / "kitti_vo_2x51" /
                                               "KITTI_sequence_1" / "image_l" / "000010.png")
                                                  .string()),
                                {.max_features = 10'000});
  NormalizeDescriptors(DescriptorNormalization::kRootSift, &colmap.descriptors);
  NormalizeDescriptors(DescriptorNormalization::kRootSift, &ours.descriptors);
  std::vector<double> dx_px, dy_px, scale_ratios, distances;
  for (int i = 0; i < colmap.size(); ++i) {
    for (int j = 0; j < ours.size(); ++j) {
      const Keypoint& a = colmap.keypoints[i];
      const Keypoint& b = ours.keypoints[j];
      const bool same = std::hypot(a.x_px - b.x_px, a.y_px - b.y_px) < 0.7 &&
                        std::abs(std::log(a.scale_px / b.scale_px)) < 0.2 &&
                        std::abs(WrapAngleRad(a.orientation_rad - b.orientation_rad)) < 0.1;
      if (!same) {
        continue;
      }
      dx_px.push_back(b.x_px - a.x_px);
      dy_px.push_back(b.y_px - a.y_px);
      scale_ratios.push_back(b.scale_px / a.scale_px);
      distances.push_back((colmap.descriptors.row(i) - ours.descriptors.row(j)).norm());
    }
  }
  ASSERT_GT(distances.size(), 1000u);
  EXPECT_NEAR(Median(dx_px), 0.0, 0.02);
  EXPECT_NEAR(Median(dy_px), 0.0, 0.02);
  EXPECT_NEAR(Median(scale_ratios), 1.0, 0.01);
  EXPECT_LT(Median(distances), 0.1);
}

IngestReport IngestInto(const std::string& map_path, const Reconstruction& reconstruction,
                        const Georegistration& georegistration) {
  MapStore store = MapStore::Create(map_path);
  IngestOptions options;
  options.session_name = "first";
  options.georef_median_residual_m = georegistration.median_residual_m;
  const IngestReport report =
      IngestSession(reconstruction, georegistration.ecef_from_world, options, &store, {});
  std::printf(
      "%lld of %lld landmarks kept; written %lld landmarks, %lld descriptors, %lld tiles, "
      "%lld bytes: %.1f bytes a landmark\n",
      static_cast<long long>(report.num_landmarks_read - report.num_landmarks_dropped),
      static_cast<long long>(report.num_landmarks_read),
      static_cast<long long>(report.num_landmarks_written),
      static_cast<long long>(report.num_descriptors_written),
      static_cast<long long>(report.num_tiles_written),
      static_cast<long long>(report.num_payload_bytes),
      static_cast<double>(report.num_payload_bytes) /
          static_cast<double>(report.num_landmarks_written));
  EXPECT_TRUE(store.Check({}).problems.empty());
  return report;
}

TEST(RealData, KittiBecomesAMap) {
  CAIRN_SKIP_WITHOUT_DATA("kitti_vo_2x51");
  const testing::TempDir dir;
  ColmapInput input = KittiInput();
  input.image_names = EvenKittiFrames();
  const Reconstruction reconstruction = ReadColmap(input);
  const auto positions =
      ReadCameraPositions((testing::TestDataDir() / "kitti_vo_2x51" / "georef_seq1.csv").string());
  const IngestReport report =
      IngestInto(dir.File("kitti.gpkg"), reconstruction,
                 Georegister(reconstruction, positions, GeoregisterOptions()));
  EXPECT_GT(report.num_landmarks_written, 5000);
  EXPECT_LT(report.num_landmarks_dropped, report.num_landmarks_read / 5);
}

TEST(RealData, LundBecomesTwoTilesOrMore) {
  CAIRN_SKIP_WITHOUT_DATA("street_lund");
  const testing::TempDir dir;
  const Reconstruction reconstruction = ReadColmap(LundInput());
  const IngestReport report = IngestInto(
      dir.File("lund.gpkg"), reconstruction,
      Georegister(reconstruction, GpsPositions(reconstruction, 5.0), GeoregisterOptions()));
  EXPECT_GE(report.num_tiles_written, 2);
}

}  // namespace
}  // namespace cairn
