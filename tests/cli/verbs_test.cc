// Tests the verbs on valid input.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "cli/run_cairn.h"
#include "core/error.h"
#include "core/geoid.h"
#include "http/client.h"
#include "ingest/colmap/write_colmap.h"
#include "ingest/ingest_session.h"
#include "storage/map/map_store.h"
#include "support/reconstruction_builder.h"
#include "support/temp_dir.h"

namespace cairn::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

IngestOptions Session(const std::string& name) {
  IngestOptions options;
  options.session_name = name;
  return options;
}

void Ingest(const std::string& map_path, const std::string& session,
            const IngestProgress& progress = {}) {
  StreetWorldOptions options;
  options.view_seed = std::hash<std::string>()(session);  // Each session is a visit of its own.
  const StreetWorld world(options);
  MapStore store = MapStore::Open(map_path, OpenMode::kReadWrite);
  IngestSession(world.Reconstruct(), world.EcefFromWorld(), Session(session), &store, progress);
}

class Verbs : public ::testing::Test {
 protected:
  Verbs() { MapStore::Create(map_); }

  TempDir dir_;
  std::string map_ = dir_.File("map.gpkg");
};

TEST_F(Verbs, EveryVerbHasHelpWithAnExample) {
  for (const char* verb :
       {"init",     "ingest",   "plan",    "build-tiles", "publish", "remove",  "serve",
        "localize", "keys",     "eval",    "info",        "sql",     "check",   "log",
        "diff",     "rollback", "prune",   "copy",        "merge",   "rebuild", "recode",
        "extract",  "compact",  "options", "demo"}) {
    const Finished finished = RunCairn({verb, "--help"});
    EXPECT_EQ(finished.exit_code, 0) << verb;
    EXPECT_THAT(finished.out, HasSubstr(std::string("Example:\n  cairn ") + verb)) << verb;
    EXPECT_EQ(finished.err, "") << verb;
  }
}

TEST_F(Verbs, VersionNamesTheProgram) {
  EXPECT_THAT(RunCairn({"--version"}).out, StartsWith("cairn "));
}

TEST_F(Verbs, InfoAsJsonIsAllThatStandsOnStdout) {
  ASSERT_EQ(RunInChild([&] { Ingest(map_, "monday"); }), 0);
  const Finished finished = RunCairn({"info", map_, "--json"});
  ASSERT_EQ(finished.exit_code, 0) << finished.err;
  const auto json = nlohmann::json::parse(finished.out);
  EXPECT_EQ(json["sessions"][0]["name"], "monday");
  EXPECT_GT(json["landmarks"], 0);
}

TEST_F(Verbs, RemoveTakesTheSessionOut) {
  ASSERT_EQ(RunInChild([&] { Ingest(map_, "monday"); }), 0);
  EXPECT_EQ(RunCairn({"remove", map_, "monday"}).exit_code, 0);
  const auto json = nlohmann::json::parse(RunCairn({"info", map_, "--json"}).out);
  EXPECT_TRUE(json["sessions"].empty());
  EXPECT_EQ(json["tiles"], 0);
}

TEST_F(Verbs, CheckOfAMapWithTilesReportsProgressAsJson) {
  ASSERT_EQ(RunInChild([&] { Ingest(map_, "monday"); }), 0);
  const Finished finished = RunCairn({"check", map_, "--progress", "json"});
  EXPECT_EQ(finished.exit_code, 0) << finished.err;
  EXPECT_THAT(finished.out, HasSubstr("no problems"));
  const auto first = nlohmann::json::parse(finished.err.substr(0, finished.err.find('\n')));
  EXPECT_EQ(first["phase"], "check");
}

TEST_F(Verbs, SqlPrintsTablesCsvAndJson) {
  const std::string query = "SELECT 1 AS a, 'x,\"y\"' AS b, NULL AS c";
  EXPECT_EQ(RunCairn({"sql", map_, query}).out, "a  b      c\n-  -----  -\n1  x,\"y\"\n");
  EXPECT_EQ(RunCairn({"sql", map_, query, "--format", "csv"}).out,
            "a,b,c\r\n1,\"x,\"\"y\"\"\",\r\n");
  const auto json = nlohmann::json::parse(RunCairn({"sql", map_, query, "--format", "json"}).out);
  EXPECT_EQ(json, nlohmann::json::parse(R"([{"a": 1, "b": "x,\"y\"", "c": null}])"));
}

TEST_F(Verbs, SqlReadsStandardInput) {
  EXPECT_EQ(RunCairn({"sql", map_, "--format", "csv"}, "SELECT 6 * 7 AS answer;").out,
            "answer\r\n42\r\n");
}

TEST_F(Verbs, ServeAnswersUntilItIsTerminated) {
  BackgroundCairn server({"serve", map_, "--port", "0", "--log-level", "off"});
  const std::string url = server.ReadLine();
  ASSERT_THAT(url, StartsWith("http://127.0.0.1:"));
  LocalizeClient client(ClientOptions{.url = url});
  EXPECT_NO_THROW(client.Get("/healthz"));
  EXPECT_EQ(server.Stop(SIGTERM), 0);
}

// Whether /readyz answers 503 within a long time.
bool BecomesUnready(const std::string& url) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(120);
  LocalizeClient client(ClientOptions{.url = url});
  while (std::chrono::steady_clock::now() < end) {
    try {
      client.Get("/readyz");
    } catch (const Error& error) {
      return std::string(error.what()).find("draining") != std::string::npos;
    }
  }
  return false;
}

TEST_F(Verbs, ServeDrainsAfterTheFirstSignalAndStopsAfterTheSecond) {
  BackgroundCairn server(
      {"serve", map_, "--port", "0", "--log-level", "off", "--drain-seconds", "3600"});
  const std::string url = server.ReadLine();
  server.Signal(SIGTERM);
  ASSERT_TRUE(BecomesUnready(url));
  LocalizeClient client(ClientOptions{.url = url});
  EXPECT_NO_THROW(client.Get("/version"));
  EXPECT_EQ(server.Stop(SIGTERM), 0);
}

TEST_F(Verbs, ServeStopsByItselfWhenItHasDrained) {
  BackgroundCairn server(
      {"serve", map_, "--port", "0", "--log-level", "off", "--drain-seconds", "1"});
  ASSERT_THAT(server.ReadLine(), StartsWith("http://"));
  EXPECT_EQ(server.Stop(SIGTERM), 0);
}

TEST_F(Verbs, ServeRefusesADrainWithoutSense) {
  for (const char* seconds : {"-1", "1e9", "1000000000", "3601", "nan", "soon", ""}) {
    EXPECT_EQ(RunCairn({"serve", map_, "--port", "0", "--drain-seconds", seconds}).exit_code, 2)
        << seconds;
  }
}

TEST_F(Verbs, ServeSaysThatItWasInterrupted) {
  BackgroundCairn server({"serve", map_, "--port", "0", "--log-level", "off"});
  ASSERT_THAT(server.ReadLine(), StartsWith("http://"));
  EXPECT_EQ(server.Stop(SIGINT), 130);
}

// What /version says of the map, when it has that many sessions, or after a long time.
nlohmann::json MapWithSessions(LocalizeClient* client, int num_sessions) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(120);
  nlohmann::json map;
  do {
    map = nlohmann::json::parse(client->Get("/version"))["map"];
  } while (map["sessions"] != num_sessions && std::chrono::steady_clock::now() < end);
  return map;
}

TEST_F(Verbs, ServeFindsAMapThatReplacesTheOldOne) {
  const std::string next = dir_.File("next.gpkg");
  MapStore::Create(next);
  ASSERT_EQ(RunInChild([&] { Ingest(next, "monday"); }), 0);
  BackgroundCairn server({"serve", map_, "--port", "0", "--log-level", "off"});
  LocalizeClient client(ClientOptions{.url = server.ReadLine()});
  EXPECT_EQ(MapWithSessions(&client, 0)["sessions"], 0);
  std::filesystem::rename(next, map_);
  EXPECT_EQ(MapWithSessions(&client, 1)["sessions"], 1);
  // And sees what is written to it from then on.
  ASSERT_EQ(RunInChild([&] { Ingest(map_, "tuesday"); }), 0);
  EXPECT_EQ(MapWithSessions(&client, 2)["sessions"], 2);
  EXPECT_EQ(server.Stop(SIGTERM), 0);
}

TEST_F(Verbs, ServeSaysThatItsMapIsGoneAndAnswersOn) {
  BackgroundCairn server({"serve", map_, "--port", "0", "--log-level", "off"});
  LocalizeClient client(ClientOptions{.url = server.ReadLine()});
  EXPECT_EQ(nlohmann::json::parse(client.Get("/healthz"))["status"], "ok");
  std::filesystem::remove(map_);
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(120);
  nlohmann::json health;
  do {
    health = nlohmann::json::parse(client.Get("/healthz"));
  } while (health["status"] == "ok" && std::chrono::steady_clock::now() < end);
  EXPECT_EQ(health["status"], "degraded");
  EXPECT_EQ(health["problem"], "the map file is missing");
  EXPECT_EQ(MapWithSessions(&client, 0)["sessions"], 0);
}

TEST_F(Verbs, ServeLosesNoRequestWhenItHangsUp) {
  BackgroundCairn server({"serve", map_, "--port", "0", "--log-level", "off"});
  const std::string url = server.ReadLine();
  std::atomic<bool> done{false};
  std::atomic<int> num_answered{0};
  std::thread asker([&] {
    LocalizeClient client(ClientOptions{.url = url});
    while (!done) {
      EXPECT_NO_THROW(client.Get("/version"));
      ++num_answered;
    }
  });
  for (int i = 0; i < 10; ++i) {
    const std::string next = dir_.File("next.gpkg");
    MapStore::Create(next);
    std::filesystem::rename(next, map_);
    server.Signal(SIGHUP);
    const int num_before = num_answered;
    while (num_answered < num_before + 10) {
      std::this_thread::yield();
    }
  }
  done = true;
  asker.join();
  EXPECT_EQ(server.Stop(SIGTERM), 0);
}

TEST_F(Verbs, ServeRefusesATakenPort) {
  BackgroundCairn server({"serve", map_, "--port", "0", "--log-level", "off"});
  const std::string url = server.ReadLine();
  const std::string port = url.substr(url.rfind(':') + 1);
  const Finished second = RunCairn({"serve", map_, "--port", port, "--log-level", "off"});
  EXPECT_EQ(second.exit_code, 4);
  EXPECT_THAT(second.err, HasSubstr(port));
}

// A reconstruction of a street with the GPS that photos' EXIF has: altitudes above the sea.
class IngestedHeights : public Verbs {
 protected:
  IngestedHeights() : reconstruction_(world_.Reconstruct()) {
    for (ReconImage& image : reconstruction_.images) {
      image.gps->h_m -= Geoid::Egm96().HeightM(image.gps->lat_rad, image.gps->lon_rad);
    }
    WriteColmapModel(reconstruction_, dir_.path().string(), ColmapModelFormat::kBinary);
    WriteColmapDatabase(reconstruction_, dir_.File("database.db"), {});
    WritePositions();
  }

  // Height of the keyframe of image 0 against the truth after `cairn ingest` with these options.
  double HeightErrorM(const std::vector<std::string>& options) {
    std::vector<std::string> arguments = {"ingest",     map_,
                                          "--model",    dir_.path().string(),
                                          "--database", dir_.File("database.db"),
                                          "--session",  "photos"};
    arguments.insert(arguments.end(), options.begin(), options.end());
    const Finished finished = RunCairn(arguments);
    EXPECT_EQ(finished.exit_code, 0) << finished.err;
    const auto rows = nlohmann::json::parse(
        RunCairn({"sql", map_, "SELECT h_m FROM v_keyframes WHERE image_name = '0000.jpg'",
                  "--format", "json"})
            .out);
    const Eigen::Vector3d center = reconstruction_.images[0].cam_from_world.Inverse().translation;
    return rows[0]["h_m"].get<double>() - GeodeticFromEcef(world_.EcefFromWorld() * center).h_m;
  }

  double geoid_m() const {
    const Geodetic& origin = world_.options().origin;
    return Geoid::Egm96().HeightM(origin.lat_rad, origin.lon_rad);
  }

 private:
  void WritePositions() {
    std::ofstream csv(dir_.File("positions.csv"));
    csv << "image,lat_deg,lon_deg,h_m\n" << std::setprecision(12);
    for (const ReconImage& image : reconstruction_.images) {
      csv << image.name << ',' << image.gps->lat_deg() << ',' << image.gps->lon_deg() << ','
          << image.gps->h_m << '\n';
    }
  }

  const StreetWorld world_;
  Reconstruction reconstruction_;
};

TEST_F(IngestedHeights, OfPhotosGpsAreAboveTheEllipsoid) {
  EXPECT_NEAR(HeightErrorM({"--gps"}), 0.0, 0.1);
}

TEST_F(IngestedHeights, OfGpsThatIsSaidToBeEllipsoidalAreKept) {
  ASSERT_GT(std::abs(geoid_m()), 10.0);
  EXPECT_NEAR(HeightErrorM({"--gps", "--height", "ellipsoid"}), -geoid_m(), 0.1);
}

TEST_F(IngestedHeights, OfSurveyedPositionsAreEllipsoidalUnlessTheFlagSaysOtherwise) {
  const std::string csv = dir_.File("positions.csv");
  EXPECT_NEAR(HeightErrorM({"--georef", csv}), -geoid_m(), 0.1);
  EXPECT_NEAR(HeightErrorM({"--georef", csv, "--height", "msl"}), 0.0, 0.1);
}

TEST_F(IngestedHeights, OfNoKnownReferenceAreAUsageError) {
  const Finished finished =
      RunCairn({"ingest", map_, "--model", "m", "--database", "d", "--gps", "--height", "geoid"});
  EXPECT_EQ(finished.exit_code, 2);
  EXPECT_THAT(finished.err, HasSubstr("--height"));
}

TEST_F(Verbs, KilledIngestLeavesTheMapAsItWas) {
  ASSERT_EQ(RunInChild([&] { Ingest(map_, "monday"); }), 0);
  const auto before = nlohmann::json::parse(RunCairn({"info", map_, "--json"}).out);
  const int exit_code = RunInChild([&] {
    Ingest(map_, "tuesday", [](const char* phase, int64_t done, int64_t /*total*/) {
      if (std::string(phase) == "tiles" && done >= 1) {
        raise(SIGKILL);
      }
    });
  });
  ASSERT_EQ(exit_code, 128 + SIGKILL);

  const Finished check = RunCairn({"check", map_});
  EXPECT_EQ(check.exit_code, 0) << check.err << check.out;
  auto after = nlohmann::json::parse(RunCairn({"info", map_, "--json"}).out);
  after["fileBytes"] = before["fileBytes"];  // The write-ahead log may have grown.
  EXPECT_EQ(after, before);

  EXPECT_EQ(RunInChild([&] { Ingest(map_, "tuesday"); }), 0);
  const auto again = nlohmann::json::parse(RunCairn({"info", map_, "--json"}).out);
  EXPECT_EQ(again["sessions"].size(), 2u);
}

}  // namespace
}  // namespace cairn::testing
