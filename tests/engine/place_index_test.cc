#include "engine/places/place_index.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <random>
#include <vector>

#include "storage/codebook/descriptor_codec.h"
#include "support/tile_builder.h"

namespace cairn {
namespace {

constexpr int kNumTiles = 30;

TileId TileNumber(int i) {
  const TileId first = TileId::Containing(Geodetic::FromDegrees(49.011, 8.416, 0.0));
  return first.WithIndices(first.easting_idx() + i, first.northing_idx());
}

// Tiles in a row from west to east, in two segments.
class PlaceIndexTest : public ::testing::Test {
 protected:
  PlaceIndexTest() : codebook_(std::make_shared<Codebook>(testing::RandomCodebook())) {
    std::vector<std::vector<SharedSignature>> halves(2);
    for (int i = 0; i < kNumTiles; ++i) {
      tiles_.push_back(testing::RandomTile(
          {.id = TileNumber(i), .num_keyframes = 8, .seed = static_cast<uint64_t>(i)}));
      halves[i % 2].push_back(
          std::make_shared<const TileSignature>(MakeTileSignature(tiles_.back(), 1000)));
    }
    std::vector<SharedSegment> segments;
    for (const auto& half : halves) {
      segments.push_back(std::make_shared<const PlaceSegment>(*codebook_, half));
    }
    index_ = std::make_unique<PlaceIndex>(codebook_, std::move(segments));
  }

  // The descriptors of what a keyframe saw, with noise, among others that nobody saw.
  QueryContext Photo(const Tile& tile, size_t keyframe, int num_others) const {
    std::vector<uint8_t> codes;
    for (const uint32_t landmark : tile.LandmarksOfKeyframe(keyframe)) {
      const auto code =
          tile.codes.begin() + tile.descriptor_begin[landmark] * static_cast<ptrdiff_t>(8);
      codes.insert(codes.end(), code, code + tile.code_size);
    }
    std::mt19937_64 random(7);
    for (int i = 0; i < 8 * num_others; ++i) {
      codes.push_back(static_cast<uint8_t>(random() >> 56));
    }
    DescriptorMatrix photo =
        DescriptorCodec(codebook_).Decode(codes.data(), static_cast<int>(codes.size() / 8));
    std::normal_distribution<float> noise(0.0f, 0.05f);
    photo +=
        DescriptorMatrix::NullaryExpr(photo.rows(), photo.cols(), [&] { return noise(random); });
    return QueryOf(photo);
  }

  // A query without gravity.
  static QueryContext QueryOf(const DescriptorMatrix& descriptors) {
    QueryContext query;
    query.descriptors = descriptors;
    query.keypoints.resize(descriptors.rows());
    query.rays_in_cam.resize(descriptors.rows(), Eigen::Vector3d::UnitZ());
    query.gravity_orientations_rad.resize(descriptors.rows());
    return query;
  }

  // The distance on the ground from a place to a keyframe.
  static double DistanceM(const RankedPlace& place, const Tile& tile, size_t keyframe) {
    const Geodetic camera =
        GeodeticFromEcef(EcefFromEnu(tile.id.Anchor()) *
                         tile.keyframes[keyframe].cam_from_tile.Inverse().translation);
    return GroundDistanceM(place.center, camera);
  }

  std::shared_ptr<const Codebook> codebook_;
  std::vector<Tile> tiles_;
  std::unique_ptr<PlaceIndex> index_;
};

TEST_F(PlaceIndexTest, ThePlaceOfAPhotoIsFirst) {
  for (const int i : {0, 7, 16, 29}) {
    const auto ranked = index_->Rank(Photo(tiles_[i], 3, 200), PlacesOptions());
    ASSERT_FALSE(ranked.empty()) << i;
    // A landmark's place is the middle of all keyframes that saw it, so the tile is what counts.
    EXPECT_EQ(TileId::Containing(ranked.front().center), tiles_[i].id) << i;
  }
}

TEST_F(PlaceIndexTest, PlacesAreApartAndInOrder) {
  PlacesOptions options;
  options.max_places = 12;
  const auto ranked = index_->Rank(Photo(tiles_[4], 1, 300), options);
  ASSERT_EQ(ranked.size(), 12u);
  for (size_t i = 0; i < ranked.size(); ++i) {
    EXPECT_TRUE(i == 0 || ranked[i].score <= ranked[i - 1].score);
    for (size_t k = 0; k < i; ++k) {
      EXPECT_GE(GroundDistanceM(ranked[i].center, ranked[k].center), options.radius_m - 1.0);
    }
  }
}

TEST_F(PlaceIndexTest, NothingNearNoPlace) {
  const DescriptorMatrix far = DescriptorMatrix::Constant(20, 16, 100.0f);
  EXPECT_TRUE(index_->Rank(QueryOf(far), PlacesOptions()).empty());
  EXPECT_TRUE(index_->Rank(QueryOf(DescriptorMatrix(0, 16)), PlacesOptions()).empty());
}

TEST_F(PlaceIndexTest, ToldToStopItEnds) {
  EXPECT_TRUE(index_->Rank(Photo(tiles_[4], 1, 0), PlacesOptions(), [] { return true; }).empty());
}

TEST_F(PlaceIndexTest, OrientationsMustAgree) {
  QueryContext query = Photo(tiles_[7], 3, 0);
  const auto without = index_->Rank(query, PlacesOptions());
  std::mt19937_64 random(7);
  for (std::optional<float>& orientation_rad : query.gravity_orientations_rad) {
    orientation_rad = std::uniform_real_distribution<float>(-3.1f, 3.1f)(random);
  }
  const auto turned = index_->Rank(query, PlacesOptions());
  ASSERT_FALSE(without.empty());
  EXPECT_TRUE(turned.empty() || turned.front().score < 0.5 * without.front().score);
}

TEST_F(PlaceIndexTest, SaysItsMemory) {
  size_t num_descriptors = 0;
  for (const SharedSegment& segment : index_->segments()) {
    num_descriptors += segment->num_descriptors();
  }
  EXPECT_EQ(index_->num_tiles(), size_t{kNumTiles});
  EXPECT_GE(index_->MemoryBytes(), num_descriptors * PlaceSegment::BytesPerDescriptor(*codebook_));
}

}  // namespace
}  // namespace cairn
