// Tests that a map has the same bytes on every processor. scripts/test-arm64 runs these tests, too.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "ingest/ingest_session.h"
#include "storage/map/map_store.h"
#include "storage/tile/content_digest.h"
#include "storage/tile/tile_codec.h"
#include "support/street_sessions.h"
#include "support/temp_dir.h"

namespace cairn {
namespace {

// Rounds to steps far above the last bits, which sines and logarithms of other processors may have
// different.
template <typename Scalar>
Scalar Rounded(Scalar value, int bits) {
  return std::ldexp(std::round(std::ldexp(value, bits)), -bits);
}

Eigen::Vector3d Rounded(const Eigen::Vector3d& x, int bits) {
  return x.unaryExpr([bits](double value) { return Rounded(value, bits); });
}

Eigen::Quaterniond Rounded(const Eigen::Quaterniond& rotation) {
  Eigen::Quaterniond rounded;
  rounded.coeffs() = rotation.coeffs().unaryExpr([](double value) { return Rounded(value, 30); });
  return rounded;
}

// A reconstruction of a street and its place, the same to the last bit everywhere.
struct ExactStreet {
  Reconstruction reconstruction;
  Sim3d ecef_from_world;

  ExactStreet() {
    const testing::StreetWorld world(testing::ShortStreet());
    reconstruction = world.Reconstruct();
    for (ReconImage& image : reconstruction.images) {
      image.cam_from_world = {Rounded(image.cam_from_world.rotation),
                              Rounded(image.cam_from_world.translation, 20)};
      image.gps.reset();
      image.down_in_cam.reset();
      for (Keypoint& keypoint : image.features.keypoints) {
        keypoint.x_px = Rounded(keypoint.x_px, 6);
        keypoint.y_px = Rounded(keypoint.y_px, 6);
        keypoint.scale_px = Rounded(keypoint.scale_px, 6);
        keypoint.orientation_rad = Rounded(keypoint.orientation_rad, 10);
      }
      image.features.descriptors = DescriptorMatrix(image.features.descriptors.Unpacked().unaryExpr(
          [](float value) { return Rounded(value, 10); }));
    }
    for (ReconLandmark& landmark : reconstruction.landmarks) {
      landmark.x_in_world = Rounded(landmark.x_in_world, 20);
    }
    const Sim3d placement = world.EcefFromWorld();
    ecef_from_world.scale = Rounded(placement.scale, 20);
    ecef_from_world.rotation = Rounded(placement.rotation);
    ecef_from_world.translation = Rounded(placement.translation, 10);
  }
};

template <typename Value>
void AddColumn(const std::vector<Value>& column, ContentHash* hash) {
  hash->Add({reinterpret_cast<const uint8_t*>(column.data()), column.size() * sizeof(Value)});
}

// The columns that the engine searches. Poses are left out: their last bits come from the sines of
// the C library and from GeographicLib, whose builds differ.
std::string DigestOfColumns(const Tile& tile) {
  ContentHash hash;
  AddColumn(tile.landmark_ids, &hash);
  AddColumn(tile.x_in_tile, &hash);
  AddColumn(tile.sigma_codes, &hash);
  AddColumn(tile.descriptor_begin, &hash);
  AddColumn(tile.codes, &hash);
  AddColumn(tile.orientation_codes, &hash);
  AddColumn(tile.size_codes, &hash);
  AddColumn(tile.azimuth_codes, &hash);
  AddColumn(tile.weight_codes, &hash);
  AddColumn(tile.keyframe_begin, &hash);
  AddColumn(tile.keyframe_landmarks, &hash);
  return hash.Hex();
}

// With the shipped codebook: a trained one has other last bits where another BLAS trains it.
TEST(SameBytes, OfTheTilesOfASession) {
  const testing::TempDir dir;
  MapStore store = MapStore::Create(dir.File("map.gpkg"));
  const ExactStreet street;
  IngestOptions options = testing::SessionNamed("monday");
  options.codebook.source = CodebookSource::kShipped;
  IngestSession(street.reconstruction, street.ecef_from_world, options, &store, {});
  const MapSnapshot map = store.Snapshot();
  std::vector<std::string> digests;
  for (const TileRecord& record : map.AllTiles(std::numeric_limits<int64_t>::max())) {
    digests.push_back(DigestOfColumns(DecodeTile(map.LoadPayload(record.payload_id))));
  }
  EXPECT_EQ(digests, (std::vector<std::string>{"9ccb2eae2d46075519599b94e89bbe16"}));
}

}  // namespace
}  // namespace cairn
