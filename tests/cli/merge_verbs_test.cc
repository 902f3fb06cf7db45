// Tests the verbs that bring maps of one place together.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "cli/run_cairn.h"
#include "ingest/codebook/shipped_codebook.h"
#include "ingest/colmap/write_colmap.h"
#include "ingest/ingest_session.h"
#include "storage/map/map_store.h"
#include "support/reconstruction_builder.h"
#include "support/temp_dir.h"
#include "support/tile_builder.h"

namespace cairn::testing {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using Json = nlohmann::json;

StreetWorld Street(uint64_t view_seed) {
  StreetWorldOptions options;
  options.length_m = 45.0;
  options.num_landmarks = 800;
  options.view_seed = view_seed;
  return StreetWorld(options);
}

// Two maps of one street, made on two visits, each with a codebook of its own.
class MergeVerbs : public ::testing::Test {
 protected:
  MergeVerbs() {
    MakeMap(a_, "monday", 2, Eigen::Vector3d::Zero());
    MakeMap(b_, "tuesday", 3, Eigen::Vector3d::Zero());
  }

  static void MakeMap(const std::string& path, const std::string& session, uint64_t view_seed,
                      const Eigen::Vector3d& shift_m) {
    const StreetWorld world = Street(view_seed);
    Sim3d ecef_from_world = world.EcefFromWorld();
    ecef_from_world.translation += shift_m;
    IngestOptions options;
    options.session_name = session;
    options.codebook.source = CodebookSource::kTrained;
    MapStore store = MapStore::Create(path);
    IngestSession(world.Reconstruct(), ecef_from_world, options, &store, {});
  }

  void WriteCodebook(const std::string& name, const Codebook& codebook, size_t num_bytes_short) {
    const std::vector<uint8_t> bytes = EncodeCodebook(codebook);
    std::ofstream(dir_.File(name), std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size() - num_bytes_short));
  }

  static std::string CodebookOf(const std::string& map) {
    return Json::parse(RunCairn({"info", map, "--json"}).out).value("codebook", "");
  }

  // Neither an output file nor a leftover of one.
  void ExpectNoMap(const std::string& path) const {
    for (const auto& entry : fs::directory_iterator(fs::path(path).parent_path())) {
      EXPECT_NE(entry.path().string().rfind(path, 0), 0u) << entry.path();
    }
  }

  void ExpectRefuses(const std::vector<std::string>& arguments, int exit_code,
                     const std::string& text) const {
    const Finished finished = RunCairn(arguments);
    EXPECT_EQ(finished.exit_code, exit_code) << finished.err;
    EXPECT_THAT(finished.err, HasSubstr(text));
    ExpectNoMap(out_);
  }

  void ExpectNotRecoded(const std::string& codebook, int exit_code, const std::string& text) const {
    const std::string before = RunCairn({"log", a_, "--json"}).out;
    ExpectRefuses({"recode", a_, "--codebook", codebook}, exit_code, text);
    EXPECT_EQ(RunCairn({"log", a_, "--json"}).out, before);
  }

  TempDir dir_;
  const std::string a_ = dir_.File("a.gpkg"), b_ = dir_.File("b.gpkg");
  const std::string out_ = dir_.File("out.gpkg");
};

TEST_F(MergeVerbs, RecodeLetsMapsOfTwoCodebooksMerge) {
  ExpectRefuses({"merge", a_, b_, "--out", out_}, 4,
                "run `cairn recode " + b_ + " --codebook " + a_ + "` first");
  const Finished recoded = RunCairn({"recode", b_, "--codebook", a_});
  EXPECT_EQ(recoded.exit_code, 0) << recoded.err;
  EXPECT_THAT(recoded.out, HasSubstr("coded with codebook " + CodebookOf(a_)));
  EXPECT_EQ(CodebookOf(b_), CodebookOf(a_));
  const Finished merged = RunCairn({"merge", a_, b_, "--out", out_});
  EXPECT_EQ(merged.exit_code, 0) << merged.err;
  EXPECT_THAT(merged.out, HasSubstr("2 sessions, "));
  EXPECT_THAT(merged.out, HasSubstr("the map recognizes"));
  EXPECT_EQ(RunCairn({"check", out_}).exit_code, 0);
}

TEST_F(MergeVerbs, MergeRecodesOnTheWay) {
  const std::string before = CodebookOf(b_);
  EXPECT_EQ(RunCairn({"merge", a_, b_, "--recode", "--out", out_}).exit_code, 0);
  EXPECT_EQ(CodebookOf(out_), CodebookOf(a_));
  EXPECT_EQ(CodebookOf(b_), before);
}

TEST_F(MergeVerbs, MergeRefusesMapsThatContradictEachOther) {
  const std::string moved = dir_.File("moved.gpkg");
  MakeMap(moved, "thursday", 3, Eigen::Vector3d(3.0, 2.0, 2.0));
  ExpectRefuses({"merge", a_, moved, "--recode", "--out", out_}, 4,
                "moved.gpkg contradicts the map");
  EXPECT_EQ(RunCairn({"merge", a_, moved, "--recode", "--apart", "--out", out_}).exit_code, 0);
}

TEST_F(MergeVerbs, MergeRefusesOtherDescriptorsAndMissingMaps) {
  const std::string other = dir_.File("other.gpkg");
  Codebook codebook = *ShippedCodebook();
  codebook.descriptor_type = "superpoint";
  {
    MapStore store = MapStore::Create(other);
    MapUpdate update = store.BeginUpdate();
    update.AddCodebook(codebook);
    update.Publish();
  }
  ExpectRefuses({"merge", a_, other, "--out", out_}, 4, "'superpoint'");
  ExpectRefuses({"merge", a_, dir_.File("none.gpkg"), "--out", out_}, 4, "none.gpkg");
}

TEST_F(MergeVerbs, RecodeRefusesCodebooksThatItCannotUse) {
  WriteCodebook("cut.codebook", *ShippedCodebook(), 4);
  ExpectNotRecoded(dir_.File("cut.codebook"), 5, "cut.codebook");
  WriteCodebook("small.codebook", RandomCodebook({.raw_dim = 64}), 0);
  ExpectNotRecoded(dir_.File("small.codebook"), 4, "cannot be recoded: one codebook is for 128-D");
  ExpectNotRecoded(dir_.File("none.codebook"), 4, "none.codebook");
  std::ofstream(dir_.File("notes.txt")) << "codebook";
  ExpectNotRecoded(dir_.File("notes.txt"), 4, "notes.txt");
  ExpectNotRecoded(a_, 4, "is coded with codebook");
  MapStore::Create(dir_.File("empty.gpkg"));
  ExpectNotRecoded(dir_.File("empty.gpkg"), 4, "has no codebook");
  ExpectRefuses({"recode", dir_.File("none.gpkg"), "--codebook", "shipped"}, 4, "none.gpkg");
  EXPECT_FALSE(fs::exists(dir_.File("none.gpkg")));
}

TEST_F(MergeVerbs, RecodeWaitsForNoOtherUpdate) {
  MapStore store = MapStore::Open(a_, OpenMode::kReadWrite);
  const MapUpdate other = store.BeginUpdate();
  ExpectNotRecoded("shipped", 4, "a.gpkg");
}

TEST_F(MergeVerbs, IngestAndPlanTakeTheShippedCodebookOnRequest) {
  WriteColmapModel(Street(2).Reconstruct(), dir_.path().string(), ColmapModelFormat::kBinary);
  WriteColmapDatabase(Street(2).Reconstruct(), dir_.File("database.db"), {});
  const std::vector<std::string> session = {
      "--model", dir_.path().string(), "--database", dir_.File("database.db"), "--gps", "--session",
      "photos",  "--codebook",         "shipped"};
  const auto with = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), session.begin(), session.end());
    return arguments;
  };
  const std::string ingested = dir_.File("ingested.gpkg"), planned = dir_.File("planned.gpkg");
  RunCairn({"init", ingested});
  RunCairn({"init", planned});
  const Finished finished = RunCairn(with({"ingest", ingested}));
  EXPECT_THAT(finished.out, HasSubstr("codebook         shipped")) << finished.err;
  EXPECT_THAT(RunCairn({"info", ingested}).out, HasSubstr(" (shipped)"));
  const std::string plan = dir_.File("plan");
  EXPECT_EQ(RunCairn(with({"plan", planned, "--out", plan})).exit_code, 0);
  EXPECT_EQ(RunCairn({"build-tiles", "--plan", plan, "--index", "0", "--count", "1"}).exit_code, 0);
  EXPECT_THAT(RunCairn({"publish", "--plan", plan}).out, HasSubstr("codebook         shipped"));
  EXPECT_EQ(CodebookOf(planned), CodebookOf(ingested));
}

TEST_F(MergeVerbs, InfoSaysWhenAMapHasOutgrownItsCodebook) {
  const auto hint = [&] {
    return Json::parse(RunCairn({"info", a_, "--json"}).out)["codebookHint"];
  };
  EXPECT_TRUE(hint().is_null());
  EXPECT_THAT(RunCairn({"info", a_}).out, HasSubstr("(trained on session monday)"));
  StreetWorldOptions options;
  options.num_landmarks = 2400;
  const StreetWorld avenue(options);
  Sim3d ecef_from_world = avenue.EcefFromWorld();
  ecef_from_world.translation += Eigen::Vector3d(0.0, 1500.0, 0.0);
  {
    MapStore store = MapStore::Open(a_, OpenMode::kReadWrite);
    IngestOptions ingest;
    ingest.session_name = "avenue";
    IngestSession(avenue.Reconstruct(), ecef_from_world, ingest, &store, {});
  }
  EXPECT_THAT(hint().get<std::string>(), HasSubstr("session avenue has "));
  EXPECT_THAT(RunCairn({"info", a_}).out, HasSubstr("cairn recode " + a_ + " --codebook"));
  EXPECT_EQ(RunCairn({"recode", a_, "--codebook", b_}).exit_code, 0);
  EXPECT_TRUE(hint().is_null()) << "nothing is known of a codebook that a user chose";
}

}  // namespace
}  // namespace cairn::testing
