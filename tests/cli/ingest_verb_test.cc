// Tests `cairn ingest`: what it says about a second session, and the alternatives of the paper.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "cli/run_cairn.h"
#include "eval/pictures/encode_png.h"
#include "ingest/colmap/write_colmap.h"
#include "storage/map/map_store.h"
#include "storage/tile/tile_codec.h"
#include "support/exif_bytes.h"
#include "support/reconstruction_builder.h"
#include "support/temp_dir.h"

namespace cairn::testing {
namespace {

using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::Not;

class IngestVerb : public ::testing::Test {
 protected:
  static StreetWorldOptions Visit(uint64_t view_seed) {
    StreetWorldOptions options;
    options.length_m = 45.0;
    options.num_landmarks = 800;
    options.view_seed = view_seed;
    return options;
  }

  std::string NewMap(const std::string& name) const {
    MapStore::Create(dir_.File(name));
    return dir_.File(name);
  }

  // Ingests a visit of a street, whose name is that of the session.
  Finished TryIngest(const std::string& map, const std::string& session,
                     const StreetWorldOptions& street,
                     const std::vector<std::string>& more = {}) const {
    const std::string folder = dir_.File(session);
    if (std::filesystem::create_directory(folder)) {
      const Reconstruction reconstruction = StreetWorld(street).Reconstruct();
      WriteColmapModel(reconstruction, folder, ColmapModelFormat::kBinary);
      WriteColmapDatabase(reconstruction, folder + "/database.db", {});
    }
    std::vector<std::string> arguments = {"ingest", map,          "--model",
                                          folder,   "--database", folder + "/database.db",
                                          "--gps",  "--session",  session};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return RunCairn(arguments);
  }

  Finished Ingest(const std::string& map, const std::string& session,
                  const StreetWorldOptions& street,
                  const std::vector<std::string>& more = {}) const {
    Finished finished = TryIngest(map, session, street, more);
    EXPECT_EQ(finished.exit_code, 0) << finished.err;
    return finished;
  }

  // The path of an options file that holds `json`.
  std::string Options(const std::string& json) const {
    std::ofstream(dir_.File("options.json"), std::ios::binary) << json;
    return dir_.File("options.json");
  }

  static std::vector<std::string> DigestsOf(const std::string& map) {
    std::vector<std::string> digests;
    for (const TileRecord& tile : MapStore::Open(map, OpenMode::kReadOnly).Snapshot().AllTiles(9)) {
      digests.push_back(tile.digest);
    }
    return digests;
  }

  const TempDir dir_;
};

TEST_F(IngestVerb, SaysInJsonWhatASecondSessionChanged) {
  const std::string map = NewMap("map.gpkg");
  Ingest(map, "monday", Visit(2));
  const auto json = nlohmann::json::parse(Ingest(map, "tuesday", Visit(3), {"--json"}).out);
  const auto& changes = json["changes"];
  EXPECT_GT(changes["merged"], changes["new"]);
  EXPECT_GT(changes["bytesBefore"], 0);
  EXPECT_GT(changes["bytesAfter"], changes["bytesBefore"]);
  EXPECT_EQ(changes["bytesAfter"], json["payloadBytes"]);
  EXPECT_EQ(changes["faded"], 0);
  EXPECT_EQ(changes["evicted"], 0);
  EXPECT_TRUE(changes.contains("notNeeded"));
  EXPECT_EQ(changes["keyframesReplaced"], 0);
  const auto& comparison = json["comparison"];
  EXPECT_EQ(comparison["photosExpected"], 16);
  EXPECT_GT(comparison["photosRecognized"], 12);
  EXPECT_GT(comparison["photosAgreeing"], 12);
  EXPECT_EQ(comparison["judged"], true);
  EXPECT_LT(comparison["movedM"], 0.1);
  EXPECT_LT(comparison["turnedDeg"], 0.1);
  EXPECT_NEAR(comparison["scale"], 1.0, 0.005);
  EXPECT_LT(comparison["medianResidualM"], 0.1);
}

TEST_F(IngestVerb, SaysInWordsWhatASecondSessionChanged) {
  const std::string map = NewMap("map.gpkg");
  EXPECT_THAT(Ingest(map, "monday", Visit(2)).out, Not(HasSubstr("comparison")));
  const std::string text = Ingest(map, "tuesday", Visit(3)).out;
  EXPECT_THAT(text, ContainsRegex("the map recognizes 1[0-9] of 16 photos"));
  EXPECT_THAT(text, ContainsRegex("[1-9][0-9]* merged, [0-9]+ new, [0-9]+ not needed, 0 faded"));
  EXPECT_THAT(text, ContainsRegex("[1-9][0-9.]* kB before, [1-9][0-9.]* kB now"));
  EXPECT_THAT(text, Not(HasSubstr("too few")));
}

// Tools put the database of each capture into a folder of the same name, which is the default.
TEST_F(IngestVerb, ADefaultNameReplacesOnlyASessionOfTheSamePhotos) {
  const std::string map = NewMap("map.gpkg");
  StreetWorldOptions elsewhere = Visit(2);
  elsewhere.origin = Geodetic::FromDegrees(59.3, 18.0, 20.0);
  const auto ingest = [&](const std::string& capture, const StreetWorldOptions& street,
                          std::vector<std::string> more) {
    const std::string folder = dir_.File(capture + "/colmap");
    if (std::filesystem::create_directories(folder)) {
      const Reconstruction reconstruction = StreetWorld(street).Reconstruct();
      WriteColmapModel(reconstruction, folder, ColmapModelFormat::kBinary);
      WriteColmapDatabase(reconstruction, folder + "/database.db", {});
    }
    more.insert(more.begin(),
                {"ingest", map, "--model", folder, "--database", folder + "/database.db", "--gps"});
    return RunCairn(more);
  };
  ASSERT_EQ(ingest("a", Visit(2), {}).exit_code, 0);
  const Finished refused = ingest("b", elsewhere, {});
  EXPECT_NE(refused.exit_code, 0);
  EXPECT_THAT(refused.err, HasSubstr("session 'colmap' already"));
  EXPECT_THAT(refused.err, HasSubstr(" km away"));
  EXPECT_THAT(refused.err, HasSubstr("--session"));
  const Finished again = ingest("a", Visit(2), {"--max-descriptors", "50000"});
  EXPECT_EQ(again.exit_code, 0) << again.err;
  const Finished forced = ingest("b", elsewhere, {"--session", "colmap"});
  EXPECT_EQ(forced.exit_code, 0) << forced.err;
  EXPECT_THAT(forced.err, HasSubstr("stands"));
}

TEST_F(IngestVerb, SaysWhatToDoWithoutGps) {
  Reconstruction reconstruction = StreetWorld(Visit(2)).Reconstruct();
  for (ReconImage& image : reconstruction.images) {
    image.gps.reset();
  }
  WriteColmapModel(reconstruction, dir_.path().string(), ColmapModelFormat::kBinary);
  WriteColmapDatabase(reconstruction, dir_.File("database.db"), {});
  const Finished refused = RunCairn({"ingest", NewMap("map.gpkg"), "--model", dir_.path().string(),
                                     "--database", dir_.File("database.db"), "--gps"});
  EXPECT_NE(refused.exit_code, 0);
  EXPECT_THAT(refused.err, HasSubstr("none of the 16 images has a GPS position"));
  EXPECT_THAT(refused.err, HasSubstr("--georef"));
}

TEST_F(IngestVerb, SaysIfAFolderOfPhotosIsNotThatOfTheModel) {
  const Finished missing =
      TryIngest(NewMap("a.gpkg"), "monday", Visit(1), {"--photos", dir_.File("none")});
  EXPECT_NE(missing.exit_code, 0);
  EXPECT_THAT(missing.err, HasSubstr("there is no such folder"));
  std::filesystem::create_directory(dir_.File("photos"));
  std::ofstream(dir_.File("photos/other.jpg")) << "";
  const Finished other =
      TryIngest(NewMap("b.gpkg"), "monday", Visit(1), {"--photos", dir_.File("photos")});
  EXPECT_EQ(other.exit_code, 0) << other.err;
  EXPECT_THAT(other.err,
              ContainsRegex("none of the [0-9]+ photos of the model is among its 1 file"));
}

// COLMAP stores positions that the receiver marked as void like all others.
TEST_F(IngestVerb, LeavesOutPositionsThatThePhotosKnowToBeVoid) {
  Reconstruction reconstruction = StreetWorld(Visit(2)).Reconstruct();
  const std::vector<uint8_t> png = EncodePng(BlankImage(640, 480));
  ExifContent content{.lat_deg = 55.0, .lon_deg = 13.0};
  content.more_gps = {{9, ExifWriter::Text("V")}};
  const std::vector<uint8_t> with_void = PngWithExifBlock(png, ExifBlock(content));
  std::filesystem::create_directory(dir_.File("images"));
  for (size_t i = 0; i < reconstruction.images.size(); ++i) {
    ReconImage& image = reconstruction.images[i];
    const std::vector<uint8_t>& photo = i < 5 ? with_void : png;
    std::ofstream(dir_.File("images/" + image.name), std::ios::binary)
        .write(reinterpret_cast<const char*>(photo.data()),
               static_cast<std::streamsize>(photo.size()));
    if (i < 5) {
      image.gps = reconstruction.images.front().gps;  // Where there was the last fix.
    }
  }
  WriteColmapModel(reconstruction, dir_.path().string(), ColmapModelFormat::kBinary);
  WriteColmapDatabase(reconstruction, dir_.File("database.db"), {});
  const Finished finished = RunCairn({"ingest", NewMap("map.gpkg"), "--model", dir_.path().string(),
                                      "--database", dir_.File("database.db"), "--gps"});
  ASSERT_EQ(finished.exit_code, 0) << finished.err;
  EXPECT_THAT(finished.out,
              HasSubstr("5 positions that the receiver marked as void (GPSStatus V) are left out"));
  EXPECT_THAT(finished.out, HasSubstr("5 of 16 photos have no position"));
}

TEST_F(IngestVerb, SaysThatTooFewPhotosCannotBeJudged) {
  const std::string map = NewMap("map.gpkg");
  Ingest(map, "monday", Visit(2));
  StreetWorldOptions foreign = Visit(3);
  foreign.seed = 9;
  foreign.length_m = 40.0;
  foreign.keyframe_step_m = 5.0;  // Nine photos.
  EXPECT_THAT(Ingest(map, "tuesday", foreign).out,
              HasSubstr("too few photos agree to judge whether the placement fits the map"));
}

TEST_F(IngestVerb, RefusesToPublishWhatTakesTheAnswersOfTheMapUnlessItIsForced) {
  const std::string map = NewMap("map.gpkg");
  Ingest(map, "monday", Visit(2));
  const std::vector<std::string> digests = DigestsOf(map);
  const std::string log = RunCairn({"log", map, "--json"}).out;
  const std::vector<std::string> budget = {"--max-descriptors", "40"};
  const Finished refused = TryIngest(map, "tuesday", Visit(3), budget);
  EXPECT_EQ(refused.exit_code, 4);
  EXPECT_THAT(refused.err,
              ContainsRegex("the map no longer localizes [0-9]+ of 1[2-6] of its own"));
  EXPECT_THAT(refused.err, HasSubstr("--force"));
  EXPECT_EQ(DigestsOf(map), digests);
  EXPECT_EQ(RunCairn({"log", map, "--json"}).out, log);
  Ingest(map, "tuesday", Visit(3), {"--max-descriptors", "40", "--force"});
  EXPECT_NE(DigestsOf(map), digests);
}

TEST_F(IngestVerb, EveryAlternativeOfThePaperMakesAnotherMap) {
  const std::string plain = NewMap("plain.gpkg");
  Ingest(plain, "street", Visit(2));
  const std::string again = NewMap("again.gpkg");
  Ingest(again, "street", Visit(2));
  ASSERT_EQ(DigestsOf(plain), DigestsOf(again));
  const std::vector<std::vector<std::string>> alternatives = {
      {"--options", R"({"ingest": {"appearance": {"kind": "kmedoids"}}})"},
      {"--options", R"({"ingest": {"appearance": {"kind": "random"}}})"},
      {"--options", R"({"ingest": {"appearance": {"count": 1}}})"},
      {"--options", R"({"ingest": {"appearance": {"ratio": 0.5}}})"},
      {"--options", R"({"ingest": {"codebook": {"projection": "likelihood_ratio"}}})"},
      {"--code-bytes", "4"}};
  std::vector<std::vector<std::string>> seen = {DigestsOf(plain)};
  for (size_t i = 0; i < alternatives.size(); ++i) {
    std::vector<std::string> flags = alternatives[i];
    const std::string name = flags[1];
    if (flags[0] == "--options") {
      flags[1] = Options(flags[1]);
    }
    const std::string map = NewMap("alternative" + std::to_string(i) + ".gpkg");
    Ingest(map, "street", Visit(2), flags);
    EXPECT_THAT(seen, Not(::testing::Contains(DigestsOf(map)))) << name;
    seen.push_back(DigestsOf(map));
    EXPECT_EQ(RunCairn({"check", map}).exit_code, 0) << name;
  }
}

// The fewest landmarks that a keyframe of the map sees, and the most of a tile.
std::pair<size_t, size_t> FewestAndMost(const std::string& map) {
  const MapStore store = MapStore::Open(map, OpenMode::kReadOnly);
  const MapSnapshot snapshot = store.Snapshot();
  size_t fewest = SIZE_MAX, most = 0;
  for (const TileRecord& record : snapshot.AllTiles(9)) {
    const Tile tile = DecodeTile(snapshot.LoadPayload(record.payload_id));
    most = std::max(most, tile.num_landmarks());
    for (size_t k = 0; k < tile.num_keyframes(); ++k) {
      fewest = std::min(fewest, tile.LandmarksOfKeyframe(k).size());
    }
  }
  return {fewest, most};
}

TEST_F(IngestVerb, SelectionByCoverageHoldsForASecondSession) {
  const std::string map = NewMap("map.gpkg");
  const std::vector<std::string> coverage = {
      "--selection", "coverage", "--json", "--options",
      Options(R"({"ingest": {"selection": {"max_landmarks": 150,
                                           "min_landmarks_per_keyframe": 40}}})")};
  Ingest(map, "monday", Visit(2), coverage);
  const auto json = nlohmann::json::parse(Ingest(map, "tuesday", Visit(3), coverage).out);
  EXPECT_GT(json["changes"]["merged"], 0);
  EXPECT_GT(json["changes"]["evicted"], 0);
  const auto [fewest, most] = FewestAndMost(map);
  EXPECT_LE(most, 150u);
  EXPECT_GE(fewest, 20u);
  EXPECT_EQ(RunCairn({"check", map}).exit_code, 0);
}

}  // namespace
}  // namespace cairn::testing
