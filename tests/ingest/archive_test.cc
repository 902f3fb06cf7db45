// Tests archives of sessions and maps that are made of them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>
#include <streambuf>
#include <string>
#include <utility>
#include <vector>

#include "core/error.h"
#include "ingest/maps/archive_codec.h"
#include "ingest/maps/archive_folder.h"
#include "ingest/maps/rebuild_plan.h"
#include "ingest/session_digest.h"
#include "support/map_builder.h"
#include "support/reconstruction_builder.h"
#include "support/temp_dir.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using testing::ExpectError;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using Use = ArchiveFolder::Use;

Reconstruction SmallReconstruction(uint64_t view_seed = 2) {
  testing::StreetWorldOptions options;
  options.length_m = 9.0;
  options.num_landmarks = 60;
  options.view_seed = view_seed;
  return testing::StreetWorld(options).Reconstruct();
}

constexpr const char* kCreatedAt = "2026-01-01T00:00:00Z";

ArchiveManifest ManifestOf(const std::string& name, char digit = '1',
                           const std::vector<SessionKey>& earlier = {}) {
  ArchiveManifest manifest;
  manifest.session = {name, std::string(48, digit)};
  manifest.source = "a test";
  manifest.recorded_at = "2026-01-31T12:00:00Z";
  manifest.options_json = "{}";
  manifest.map_created_at = kCreatedAt;
  manifest.first_ids = {CodebookId(1), SessionId(7), KeyframeId(100), LandmarkId(5000)};
  manifest.is_apart = true;
  manifest.georef_median_residual_m = 0.25;
  manifest.ecef_from_world = testing::StreetWorld().EcefFromWorld();
  manifest.earlier_sessions = earlier;
  return manifest;
}

// The session of ManifestOf in a map.
MapSession Published(const std::string& name, char digit) {
  const ArchiveManifest manifest = ManifestOf(name, digit);
  return {manifest.session, manifest.first_ids.session};
}

ArchivedMap MapWith(const std::vector<MapSession>& sessions,
                    const std::string& created_at = kCreatedAt) {
  return {created_at, MapVersion(5), sessions};
}

constexpr const char* kOtherTime = "2026-01-01T00:00:01Z";

std::string Encoded(const ArchiveManifest& manifest, const Reconstruction& reconstruction) {
  std::string bytes;
  EncodeSession(manifest, reconstruction,
                [&](std::span<const uint8_t> part) { bytes.append(part.begin(), part.end()); });
  return bytes;
}

ArchivedSession Decoded(const std::string& bytes) {
  std::istringstream stream(bytes);
  return DecodeSession(&stream, "a file");
}

void SetFirstValue(float value, ReconImage* image) {
  DescriptorMatrix descriptors = image->features.descriptors.Unpacked();
  descriptors(0, 0) = value;
  image->features.descriptors = descriptors;
}

TEST(ArchiveCodec, KeepsASessionToTheBit) {
  Reconstruction reconstruction = SmallReconstruction();
  SetFirstValue(-0.0f, &reconstruction.images[1]);  // Not a byte, though equal to one.
  SetFirstValue(1.5f, &reconstruction.images[2]);
  const ArchiveManifest manifest = ManifestOf("monday", '1', {{"sunday", std::string(48, '2')}});
  const std::string bytes = Encoded(manifest, reconstruction);
  const ArchivedSession session = Decoded(bytes);
  EXPECT_EQ(DigestOf(session.reconstruction), DigestOf(reconstruction));
  EXPECT_EQ(Encoded(session.manifest, session.reconstruction), bytes);
  EXPECT_EQ(session.manifest.session, manifest.session);
  EXPECT_EQ(session.manifest.earlier_sessions, manifest.earlier_sessions);
  EXPECT_EQ(session.manifest.ecef_from_world.rotation.coeffs(),
            manifest.ecef_from_world.rotation.coeffs());
  EXPECT_EQ(session.manifest.num_images, reconstruction.images.size());
  EXPECT_EQ(session.manifest.descriptor_dim, 128);
  EXPECT_EQ(session.manifest.first_ids.session, manifest.first_ids.session);
  EXPECT_EQ(session.manifest.first_ids.landmark, manifest.first_ids.landmark);
  EXPECT_TRUE(session.manifest.is_apart);
}

TEST(ArchiveCodec, DescriptorsOfBytesTakeABytePerDimension) {
  const Reconstruction reconstruction = SmallReconstruction();
  int64_t num_values = 0;
  for (const ReconImage& image : reconstruction.images) {
    num_values += image.features.descriptors.rows() * image.features.descriptors.cols();
  }
  EXPECT_LT(std::ssize(Encoded(ManifestOf("monday"), reconstruction)), num_values);
}

TEST(ArchiveCodec, RefusesDamagedBytes) {
  const std::string bytes = Encoded(ManifestOf("monday"), SmallReconstruction());
  for (size_t i = 0; i < bytes.size(); i += 1 + i / 16) {
    std::string damaged = bytes;
    damaged[i] = static_cast<char>(damaged[i] ^ 0x10);
    ExpectError([&] { Decoded(damaged); }, ErrorCode::kMapDamaged, "a file");
    ExpectError([&] { Decoded(bytes.substr(0, i)); }, ErrorCode::kMapDamaged, "a file");
  }
  ExpectError([&] { Decoded(bytes + "x"); }, ErrorCode::kMapDamaged, "longer");
}

TEST(ArchiveCodec, RefusesDigestsAndTimesThatAreNone) {
  const auto expect_refused = [](const ArchiveManifest& manifest, const std::string& text) {
    const std::string bytes = Encoded(manifest, SmallReconstruction());
    ExpectError([&] { Decoded(bytes); }, ErrorCode::kMapDamaged, text);
  };
  expect_refused(ManifestOf("monday", 'A'), "digest");
  for (std::string ArchiveManifest::*time :
       {&ArchiveManifest::recorded_at, &ArchiveManifest::given_recorded_at,
        &ArchiveManifest::map_created_at}) {
    ArchiveManifest manifest = ManifestOf("monday");
    manifest.*time = "2026-02-31T12:00:00Z";
    expect_refused(manifest, "a time is not like");
  }
}

// Bytes of a disk that fails.
class FailingDisk : public std::streambuf {
 public:
  explicit FailingDisk(std::string good) : good_(std::move(good)) {
    setg(good_.data(), good_.data(), good_.data() + good_.size());
  }

 protected:
  int_type underflow() override { throw std::ios_base::failure("the disk fails"); }

 private:
  std::string good_;
};

TEST(ArchiveCodec, TellsAFailureOfTheDiskFromTheEnd) {
  const std::string bytes = Encoded(ManifestOf("monday"), SmallReconstruction());
  for (const size_t size : {size_t{0}, size_t{30}, bytes.size() / 2, bytes.size()}) {
    FailingDisk disk(bytes.substr(0, size));
    std::istream stream(&disk);
    ExpectError([&] { DecodeSession(&stream, "a file"); }, ErrorCode::kIo, "cannot be read");
  }
}

class Archive : public ::testing::Test {
 protected:
  Archive() { fs::create_directory(path_); }

  std::string Add(const ArchiveManifest& manifest) const {
    ArchiveFolder folder(path_, Use::kIngest);
    folder.Stage(manifest, SmallReconstruction());
    return folder.Commit();
  }
  std::vector<std::string> Names() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(path_)) {
      names.push_back(entry.path().filename().string());
    }
    std::ranges::sort(names);
    return names;
  }
  std::vector<std::string> Planned(const std::vector<std::string>& without = {}) const {
    const ArchiveFolder folder(path_, Use::kRebuild);
    std::vector<std::string> names;
    for (const ArchiveFile& file : PlanRebuild(folder, without)) {
      names.push_back(file.manifest.session.name);
    }
    return names;
  }
  void ExpectNoPlan(ErrorCode code, const std::string& text,
                    const std::vector<std::string>& without = {}) const {
    ExpectError([&] { Planned(without); }, code, text);
  }

  testing::TempDir dir_;
  const std::string path_ = dir_.File("archive");
};

TEST_F(Archive, NumbersSessionsInOrder) {
  Add(ManifestOf("monday"));
  Add(ManifestOf("a/b c"));
  EXPECT_THAT(Names(), ElementsAre("0001-monday.cairnsession", "0002-a_b_c.cairnsession"));
  EXPECT_THAT(Planned(), ElementsAre("monday", "a/b c"));
  EXPECT_THAT(Planned({"monday"}), ElementsAre("a/b c"));
}

// The map may have got the session though the ingest failed, as when a connection breaks.
TEST_F(Archive, LeavesWhatIsNotCommittedToTheNextIngest) {
  const auto stage = [&] {
    ArchiveFolder(path_, Use::kIngest).Stage(ManifestOf("monday", '1'), SmallReconstruction());
    EXPECT_THAT(Names(), ElementsAre("0001-monday.cairnsession.unfinished"));
  };
  stage();
  ArchiveFolder(path_, Use::kIngest).Recover(MapWith({}), "tuesday");
  EXPECT_THAT(Names(), IsEmpty());
  stage();
  ArchiveFolder(path_, Use::kIngest).Recover(MapWith({Published("monday", '1')}), "tuesday");
  EXPECT_THAT(Names(), ElementsAre("0001-monday.cairnsession"));
}

TEST_F(Archive, LeavesNothingOfAFileThatCannotBeWritten) {
  ArchiveManifest too_large = ManifestOf("monday");
  too_large.options_json = std::string(size_t{1} << 21, ' ');
  ArchiveFolder folder(path_, Use::kIngest);
  ExpectError([&] { folder.Stage(too_large, SmallReconstruction()); }, ErrorCode::kBadInput,
              "an archive takes");
  EXPECT_THAT(Names(), IsEmpty());
}

// Who may write to the folder may not choose a file of the user that Cairn overwrites or reads.
TEST_F(Archive, FollowsNoLinks) {
  const std::string precious = dir_.File("precious");
  std::ofstream(precious) << "text";
  fs::create_symlink(precious, path_ + "/0001-monday.cairnsession.unfinished");
  {
    ArchiveFolder folder(path_, Use::kIngest);
    folder.Stage(ManifestOf("monday"), SmallReconstruction());
    folder.Commit();
  }
  EXPECT_THAT(Names(), ElementsAre("0001-monday.cairnsession"));
  EXPECT_TRUE(fs::is_regular_file(fs::symlink_status(path_ + "/0001-monday.cairnsession")));
  EXPECT_EQ(fs::file_size(precious), 4u);
  fs::create_symlink(precious, path_ + "/0002-tuesday.cairnsession");
  ExpectError([&] { ArchiveFolder(path_, Use::kIngest); }, ErrorCode::kBadInput, "is a link");
}

TEST_F(Archive, ReplacesASession) {
  Add(ManifestOf("monday", '1'));
  Add(ManifestOf("tuesday"));
  Add(ManifestOf("monday", '2'));
  EXPECT_THAT(Names(), ElementsAre("0002-tuesday.cairnsession", "0003-monday.cairnsession"));
}

TEST_F(Archive, FinishesWhatAKilledIngestLeft) {
  const std::string name = Add(ManifestOf("monday", '1'));
  const std::string replaced = Add(ManifestOf("tuesday"));
  fs::copy_file(name, path_ + "/0003-monday.cairnsession.unfinished");
  const std::string cut = path_ + "/0004-tuesday.cairnsession.unfinished";
  fs::copy_file(replaced, cut);
  fs::resize_file(cut, fs::file_size(cut) - 1);
  fs::copy_file(replaced, path_ + "/0005-wednesday.cairnsession.unfinished");
  ExpectNoPlan(ErrorCode::kConflict, "did not finish");
  std::ofstream(path_ + "/notes.cairnsession.unfinished") << "not of an ingest";
  ArchiveFolder(path_, Use::kIngest).Recover(MapWith({Published("monday", '1')}), "friday");
  EXPECT_THAT(Names(), ElementsAre("0002-tuesday.cairnsession", "0003-monday.cairnsession",
                                   "notes.cairnsession.unfinished"));
}

TEST_F(Archive, KeepsUnfinishedFilesThatItDoesNotUnderstand) {
  const std::string unfinished = path_ + "/0001-monday.cairnsession.unfinished";
  const auto expect_kept = [&](ErrorCode code, const std::string& text) {
    ExpectError([&] { ArchiveFolder(path_, Use::kIngest).Recover(MapWith({}), "friday"); }, code,
                text);
    EXPECT_THAT(Names(), ElementsAre("0001-monday.cairnsession.unfinished"));
  };
  fs::rename(Add(ManifestOf("monday")), unfinished);
  std::fstream(unfinished, std::ios::binary | std::ios::in | std::ios::out).seekp(4).put(2);
  expect_kept(ErrorCode::kMapDamaged, "format version 2 is unknown");
  fs::remove(unfinished);
  fs::rename(Add(ManifestOf("monday")), unfinished);
  std::fstream(unfinished, std::ios::binary | std::ios::in | std::ios::out).seekp(60).put('\x7f');
  expect_kept(ErrorCode::kMapDamaged, "delete it if the map does not have its session");
  fs::remove(unfinished);
  fs::create_directory(unfinished);
  expect_kept(ErrorCode::kBadInput, "is not a file");
}

TEST_F(Archive, OfAnotherMapStaysAsItIs) {
  const std::string monday = Add(ManifestOf("monday", '1'));
  fs::copy_file(monday, path_ + "/0003-monday.cairnsession");
  const auto expect_refused = [&](const ArchivedMap& map, const std::string& text) {
    const std::vector<std::string> names = Names();
    ExpectError([&] { ArchiveFolder(path_, Use::kIngest).Recover(map, "monday"); },
                ErrorCode::kConflict, text);
    EXPECT_EQ(Names(), names);
  };
  expect_refused(MapWith({}, kOtherTime), "lacks session 'monday'");
  fs::rename(path_ + "/0003-monday.cairnsession", path_ + "/0003-monday.cairnsession.unfinished");
  expect_refused(MapWith({Published("monday", '1')}, kOtherTime), "an ingest into another map");
  fs::remove(monday);  // No finished file tells whose archive it is.
  expect_refused(MapWith({}, kOtherTime), "an ingest into another map");
}

TEST_F(Archive, DeletesAReplacedSessionThatAKilledIngestLeft) {
  fs::copy_file(Add(ManifestOf("monday", '1')), dir_.File("old"));
  const std::string newer = Add(ManifestOf("monday", '2'));
  fs::copy_file(dir_.File("old"), path_ + "/0001-monday.cairnsession");
  ExpectNoPlan(ErrorCode::kConflict, "both of session 'monday'");
  ArchiveFolder(path_, Use::kIngest).Recover(MapWith({Published("monday", '2')}), "friday");
  EXPECT_THAT(Planned(), ElementsAre("monday"));
  EXPECT_TRUE(fs::exists(newer));
}

TEST_F(Archive, BelongsToOneMap) {
  Add(ManifestOf("monday", '1'));
  const std::vector<MapSession> monday = {Published("monday", '1')};
  const std::vector<MapSession> other_monday = {Published("monday", '2')};
  ArchiveFolder folder(path_, Use::kIngest);
  folder.Recover(MapWith(monday), "tuesday");
  folder.Recover(MapWith(monday, kOtherTime), "tuesday");  // A rebuilt map.
  folder.Recover(MapWith(other_monday), "monday");
  folder.Recover(MapWith({}), "monday");  // All sessions were removed.
  const auto expect_refused = [&](const ArchivedMap& map, const std::string& incoming,
                                  const std::string& text) {
    ExpectError([&] { folder.Recover(map, incoming); }, ErrorCode::kConflict, text);
  };
  expect_refused(MapWith({}, kOtherTime), "monday", "lacks session 'monday'");
  expect_refused(MapWith({Published("friday", '1')}, kOtherTime), "friday", "a folder of its own");
  expect_refused(MapWith(other_monday), "tuesday", "another session 'monday'");
  ArchivedMap of_the_same_second = MapWith({});
  of_the_same_second.version = MapVersion(1);
  expect_refused(of_the_same_second, "monday", "lacks session 'monday'");
}

TEST_F(Archive, IsUsedByOneIngestAtATime) {
  const auto first = std::make_unique<ArchiveFolder>(path_, Use::kRebuild);
  const ArchiveFolder second(path_, Use::kRebuild);
  ExpectError([&] { ArchiveFolder(path_, Use::kIngest); }, ErrorCode::kConflict, "another process");
}

TEST_F(Archive, IsMadeByTheFirstIngest) {
  const ArchiveFolder made(dir_.File("new"), Use::kIngest);
  EXPECT_TRUE(fs::is_directory(dir_.File("new")));
  EXPECT_TRUE(made.files().empty());
}

TEST_F(Archive, RefusesFoldersThatAreNone) {
  ExpectError([&] { ArchiveFolder(dir_.File("none/none"), Use::kIngest); }, ErrorCode::kNotFound,
              "mkdir");
  EXPECT_FALSE(fs::exists(dir_.File("none")));
  ExpectError([&] { ArchiveFolder(dir_.File("none"), Use::kRebuild); }, ErrorCode::kNotFound,
              "no such folder");
  std::ofstream(dir_.File("file")) << "x";
  ExpectError([&] { ArchiveFolder(dir_.File("file"), Use::kIngest); }, ErrorCode::kBadInput,
              "is a file");
}

TEST_F(Archive, NamesTheDamagedFile) {
  const std::string file = Add(ManifestOf("monday"));
  std::fstream(file, std::ios::binary | std::ios::in | std::ios::out).seekp(40).put('x');
  ExpectNoPlan(ErrorCode::kMapDamaged, file);
  fs::remove(file);
  std::ofstream(path_ + "/0001-x.cairnsession") << "";
  ExpectNoPlan(ErrorCode::kMapDamaged, "0001-x.cairnsession: ends too early");
}

TEST_F(Archive, SaysWhatARebuildLacks) {
  ExpectNoPlan(ErrorCode::kBadInput, "has no session to make a map of");
  Add(ManifestOf("tuesday", '1', {{"monday", std::string(48, '2')}}));
  ExpectNoPlan(ErrorCode::kNotFound, "lacks session 'monday'");
  EXPECT_THAT(Planned({"monday"}), ElementsAre("tuesday"));
  ExpectNoPlan(ErrorCode::kNotFound, "has no session 'friday'", {"friday"});
  ExpectNoPlan(ErrorCode::kBadInput, "has no session to make a map of", {"tuesday"});
  fs::copy_file(path_ + "/0001-tuesday.cairnsession", path_ + "/001-copy.cairnsession");
  ExpectNoPlan(ErrorCode::kBadInput, "have one number");
}

TEST_F(Archive, RefusesSessionsOfDifferentDescriptors) {
  Add(ManifestOf("monday"));
  ArchiveFolder folder(path_, Use::kIngest);
  Reconstruction other = SmallReconstruction();
  other.descriptor_type = "surf";
  folder.Stage(ManifestOf("tuesday"), other);
  folder.Commit();
  ExpectError([&] { PlanRebuild(folder, {}); }, ErrorCode::kConflict, "not of one map");
}

}  // namespace
}  // namespace cairn
