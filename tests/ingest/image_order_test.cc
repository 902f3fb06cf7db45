// Tests that a map does not depend on the order of the photos in COLMAP's files.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include "ingest/colmap/colmap_reader.h"
#include "ingest/colmap/write_colmap.h"
#include "ingest/ingest_session.h"
#include "support/street_sessions.h"
#include "support/temp_dir.h"

namespace cairn {
namespace {

// The same photos under other image ids.
Reconstruction WithShuffledImages(const Reconstruction& reconstruction) {
  std::vector<int> new_idx(reconstruction.images.size());
  std::iota(new_idx.begin(), new_idx.end(), 0);
  std::shuffle(new_idx.begin(), new_idx.end(), std::mt19937(3));
  Reconstruction shuffled = reconstruction;
  for (size_t i = 0; i < new_idx.size(); ++i) {
    shuffled.images[static_cast<size_t>(new_idx[i])] = reconstruction.images[i];
  }
  for (ReconLandmark& landmark : shuffled.landmarks) {
    for (ReconObservation& observation : landmark.observations) {
      observation.image_idx = new_idx[static_cast<size_t>(observation.image_idx)];
    }
  }
  return shuffled;
}

// The payloads of a map of two sessions, written by COLMAP in this order or another.
std::vector<std::string> DigestsOfMap(bool shuffle) {
  const testing::TempDir dir;
  MapStore store = MapStore::Create(dir.File("map.gpkg"));
  for (const int day : {1, 2}) {
    testing::StreetWorldOptions street = testing::ShortStreet();
    street.view_seed = static_cast<uint64_t>(day);
    const testing::StreetWorld world(street);
    Reconstruction written = world.Reconstruct();
    if (shuffle) {
      written = WithShuffledImages(written);
    }
    const std::string folder = dir.File(std::to_string(day));
    std::filesystem::create_directory(folder);
    WriteColmapModel(written, folder, ColmapModelFormat::kBinary);
    WriteColmapDatabase(written, folder + "/database.db", {});
    IngestOptions options = testing::SessionNamed("day " + std::to_string(day));
    options.now = "2026-01-31T12:00:00Z";
    IngestSession(ReadColmap({folder, folder + "/database.db", {}}), world.EcefFromWorld(), options,
                  &store, {});
  }
  std::vector<std::string> digests;
  for (const TileRecord& tile : store.Snapshot().AllTiles(9)) {
    digests.push_back(tile.digest);
  }
  return digests;
}

TEST(ImageOrder, OfTheFilesDoesNotMatter) {
  const Reconstruction ordered = testing::StreetWorld(testing::ShortStreet()).Reconstruct();
  ASSERT_NE(WithShuffledImages(ordered).images[0].name, ordered.images[0].name);
  const std::vector<std::string> digests = DigestsOfMap(false);
  ASSERT_FALSE(digests.empty());
  EXPECT_EQ(DigestsOfMap(true), digests);
}

}  // namespace
}  // namespace cairn
