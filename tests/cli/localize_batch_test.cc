// Tests `cairn localize --images`: lists, output, resuming and failures of single photos.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "cli/batch/localize_photos.h"
#include "cli/batch/result_row.h"
#include "cli/run_cairn.h"
#include "core/csv.h"
#include "http/client.h"
#include "storage/map/map_store.h"
#include "support/expect_error.h"
#include "support/street_map.h"
#include "support/temp_dir.h"

namespace cairn::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

std::string ContentOf(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

class LocalizeBatch : public ::testing::Test {
 protected:
  std::string Write(const std::string& name, const std::string& content) const {
    std::filesystem::create_directories((dir_.path() / name).parent_path());
    std::ofstream(dir_.path() / name, std::ios::binary) << content;
    return dir_.File(name);
  }
  // A gray photo of 4 x 2 pixels.
  void AddPhoto(const std::string& name) const { Write(name, "P5\n4 2\n255\n12345678"); }

  // Names of photos, some of which cannot be read.
  std::vector<ListedPhoto> Photos(int count) const {
    std::vector<ListedPhoto> photos;
    for (int i = 0; i < count; ++i) {
      const std::string name = fmt::format("{}.pgm", i);
      if (i % 7 == 3) {
        Write(name, "no picture");
      } else {
        AddPhoto(name);
      }
      photos.push_back({.name = name, .path = dir_.File(name)});
    }
    return photos;
  }

  static std::vector<std::string> NamesOf(const std::vector<ListedPhoto>& photos) {
    std::vector<std::string> names;
    for (const ListedPhoto& photo : photos) {
      names.push_back(photo.name);
    }
    return names;
  }

  // An answer whose place tells the photo.
  static LocalizeResult AnswerTo(const PhotoQuery& photo) {
    LocalizeResult result;
    if (std::stoi(photo.query.id) % 5 == 0) {
      result.reason = NotLocalizedReason::kTooFewMatches;
      return result;
    }
    result.localized = true;
    result.position = Geodetic::FromDegrees(49.0, 8.0 + 1e-4 * std::stoi(photo.query.id), 100.0);
    result.anchor = result.position;
    result.cam_from_ecef = EcefFromEnu(result.position).Inverse();
    return result;
  }

  // Localizes with made-up answers; stops with an error at photo `last`.
  ResultCounts Run(const std::vector<ListedPhoto>& photos, const std::string& output,
                   int num_threads, int last = 1 << 30, const std::string& digest = "run") const {
    LocalizePhotosOptions options;
    options.num_threads = num_threads;
    options.make_answerer = [last] {
      return [last](PhotoQuery* photo) {
        if (std::stoi(photo->query.id) >= last) {
          throw Error(ErrorCode::kUnavailable, "the server is gone");
        }
        return AnswerTo(*photo);
      };
    };
    ResultFile results(dir_.File(output), digest, NamesOf(photos));
    LocalizePhotos(photos, options, &results);
    return results.Finish();
  }

  TempDir dir_;
};

TEST_F(LocalizeBatch, ListsFindNamesThatAreWrittenInAnotherWay) {
  AddPhoto("photos/day/IMG_1.JPG");
  AddPhoto("photos/img_2.jpg");
  const std::string list = Write("list.txt", "day\\img_1.jpg\nimg_2.jpg\nmissing.jpg\n");
  const std::vector<ListedPhoto> photos = ReadPhotoList(list, dir_.File("photos"));
  ASSERT_EQ(photos.size(), 3u);
  EXPECT_EQ(photos[0].name, "day\\img_1.jpg");
  EXPECT_EQ(photos[0].path, dir_.File("photos/day/IMG_1.JPG"));
  EXPECT_EQ(photos[1].path, dir_.File("photos/img_2.jpg"));
  EXPECT_EQ(photos[2].path, dir_.File("photos/missing.jpg"));
}

TEST_F(LocalizeBatch, ListsInUtf16AreRefusedByName) {
  const std::string list = Write("list.txt", std::string("\xff\xfe\x61\0", 4));
  ExpectError([&] { ReadPhotoList(list, ""); }, ErrorCode::kBadInput, "UTF-16");
}

TEST_F(LocalizeBatch, ListsHoldNamesAndCameras) {
  const std::string list = Write("lists/day.txt",
                                 "\xef\xbb\xbf# query list\r\n"
                                 "db/a.jpg PINHOLE 1600 1200 1000.5 1001 800 600\r\n"
                                 "\n"
                                 "  my photo 2 3.jpg  \n"
                                 "my photo.jpg SIMPLE_RADIAL 640 480 500 320 240 -1e-2\n");
  const std::vector<ListedPhoto> photos = ReadPhotoList(list, "");
  ASSERT_EQ(photos.size(), 3u);
  EXPECT_EQ(photos[0].name, "db/a.jpg");
  EXPECT_EQ(photos[0].path, dir_.File("lists/db/a.jpg"));
  ASSERT_TRUE(photos[0].camera.has_value());
  EXPECT_EQ(photos[0].camera->params(), (std::vector<double>{1000.5, 1001, 800, 600}));
  EXPECT_EQ(photos[1].name, "my photo 2 3.jpg");
  EXPECT_FALSE(photos[1].camera.has_value());
  EXPECT_EQ(photos[2].name, "my photo.jpg");
  EXPECT_EQ(photos[2].camera->model(), CameraModel::kSimpleRadial);
  EXPECT_EQ(ReadPhotoList(list, "/photos")[0].path, "/photos/db/a.jpg");
}

TEST_F(LocalizeBatch, FaultsOfListsAreNamedWithTheLine) {
  const auto expect_refused = [this](const std::string& content, const std::string& text) {
    ExpectError([&] { ReadPhotoList(Write("list.txt", content), ""); }, ErrorCode::kBadInput, text);
  };
  expect_refused("a.jpg\nb.jpg SPHERE 10 10 1\n", "line 2: camera model 'SPHERE'");
  expect_refused("b.jpg PINHOLE 10 10 1\n", "line 1: camera model PINHOLE takes 4 parameters");
  expect_refused("b.jpg PINHOLE 10.5 10 1 1 1 1\n", "'10.5' is not a whole number");
  expect_refused("a.jpg\nb.jpg\na.jpg\n", "line 3: the photo a.jpg is also in line 1");
  expect_refused("# nothing\n", "names no photo");
}

TEST_F(LocalizeBatch, AFolderIsReadWithItsFolders) {
  AddPhoto("photos/b/2.pgm");
  AddPhoto("photos/a/1.pgm");
  Write("photos/notes.txt", "no photo");
  EXPECT_EQ(NamesOf(ReadPhotoList(dir_.File("photos"), "")),
            (std::vector<std::string>{"a/1.pgm", "b/2.pgm"}));
}

TEST_F(LocalizeBatch, PriorsComeFromTheTable) {
  std::vector<ListedPhoto> photos = {{.name = "a.jpg", .path = ""}, {.name = "b.jpg", .path = ""}};
  AddTablePriors(Write("gps.csv", "image,lat_deg,lon_deg,h_m\na.JPG,49,8,100\nc.jpg,1,1,1\n"),
                 HeightReference::kEllipsoid, 12.0, &photos);
  ASSERT_TRUE(photos[0].prior.has_value());
  EXPECT_NEAR(photos[0].prior->position.lat_deg(), 49.0, 1e-12);
  EXPECT_EQ(photos[0].prior->accuracy_m, 12.0);
  EXPECT_FALSE(photos[1].prior.has_value());
}

TEST_F(LocalizeBatch, RowsDoNotDependOnThreads) {
  const std::vector<ListedPhoto> photos = Photos(90);
  Run(photos, "one.jsonl", 1);
  const ResultCounts counts = Run(photos, "four.jsonl", 4);
  const std::string rows = ContentOf(dir_.File("one.jsonl"));
  EXPECT_EQ(rows, ContentOf(dir_.File("four.jsonl")));
  EXPECT_EQ(std::count(rows.begin(), rows.end(), '\n'), 90);
  EXPECT_EQ(counts.num_of_reason.at("BAD_PHOTO"), 13);
  EXPECT_EQ(counts.num_of_reason.at("TOO_FEW_MATCHES"), 15);
  EXPECT_EQ(counts.num_localized, 90 - 13 - 15);
}

TEST_F(LocalizeBatch, AStoppedRunGoesOnAndGivesTheSame) {
  const std::vector<ListedPhoto> photos = Photos(40);
  Run(photos, "whole.csv", 1);
  ExpectError([&] { Run(photos, "resumed.csv", 3, 25); }, ErrorCode::kUnavailable, "gone");
  EXPECT_FALSE(std::filesystem::exists(dir_.File("resumed.csv")));
  {
    const ResultFile rest(dir_.File("resumed.csv"), "run", NamesOf(photos));
    EXPECT_EQ(rest.num_rows(), 25);
  }
  Run(photos, "resumed.csv", 2);
  EXPECT_EQ(ContentOf(dir_.File("whole.csv")), ContentOf(dir_.File("resumed.csv")));
  EXPECT_FALSE(std::filesystem::exists(dir_.File("resumed.csv.part")));
}

TEST_F(LocalizeBatch, ATornRowIsDroppedAndOthersAreKept) {
  const std::vector<ListedPhoto> photos = Photos(10);
  ExpectError([&] { Run(photos, "out.csv", 1, 6); }, ErrorCode::kUnavailable, "gone");
  const std::string part = dir_.File("out.csv.part");
  const std::string rows = ContentOf(part);
  for (const size_t size : {rows.size() - 1, rows.size() - 20}) {
    std::filesystem::resize_file(part, size);
    const ResultFile results(dir_.File("out.csv"), "run", NamesOf(photos));
    EXPECT_EQ(results.num_rows(), 5);
    EXPECT_FALSE(results.is_restarted());
  }
  std::ofstream(part, std::ios::app) << std::string(100, '\0') << "\n";
  EXPECT_EQ(ResultFile(dir_.File("out.csv"), "run", NamesOf(photos)).num_rows(), 5);
}

TEST_F(LocalizeBatch, AnotherRunBeginsAgain) {
  const std::vector<ListedPhoto> photos = Photos(10);
  ExpectError([&] { Run(photos, "out.csv", 1, 6); }, ErrorCode::kUnavailable, "gone");
  const ResultFile results(dir_.File("out.csv"), "other", NamesOf(photos));
  EXPECT_TRUE(results.is_restarted());
  EXPECT_EQ(results.num_rows(), 0);
}

TEST_F(LocalizeBatch, OneOutputHasOneWriter) {
  const ResultFile first(dir_.File("out.csv"), "run", {"a"});
  ExpectError([&] { ResultFile(dir_.File("out.csv"), "run", {"a"}); }, ErrorCode::kConflict,
              "another process writes");
}

TEST_F(LocalizeBatch, WhatFailsForAllPhotosEndsTheRun) {
  const std::vector<ListedPhoto> photos = Photos(3);
  LocalizePhotosOptions options;
  const auto run_with = [&](const auto& error) {
    options.make_answerer = [&error] {
      return [&error](PhotoQuery* /*photo*/) -> LocalizeResult { throw error; };
    };
    ResultFile results(dir_.File("out.csv"), "run", NamesOf(photos));
    LocalizePhotos(photos, options, &results);
    return results.num_rows();
  };
  EXPECT_THROW(run_with(Error(ErrorCode::kMapDamaged, "damaged")), Error);
  EXPECT_THROW(run_with(Error(ErrorCode::kIo, "the disk fails")), Error);
  EXPECT_THROW(run_with(ServerRefusal(ErrorCode::kBadInput, "no key", 401)), ServerRefusal);
  for (const int status : {302, 502, 504}) {
    EXPECT_THROW(run_with(ServerRefusal(ErrorCode::kInternal, "the front", status)), ServerRefusal)
        << status;
  }
  EXPECT_EQ(run_with(ServerRefusal(ErrorCode::kBadInput, "bad image", 400)), 3);
}

TEST_F(LocalizeBatch, FormsAgree) {
  const std::vector<ListedPhoto> photos = Photos(9);
  Run(photos, "out.csv", 1);
  Run(photos, "out.jsonl", 1);
  Run(photos, "out.txt", 1);
  const std::string csv = ContentOf(dir_.File("out.csv"));
  CsvReader records(csv);
  ASSERT_TRUE(records.Next());
  const std::vector<std::string> header = records.cells();
  std::istringstream lines(ContentOf(dir_.File("out.txt"))),
      rows(ContentOf(dir_.File("out.jsonl")));
  std::string row;
  while (std::getline(rows, row)) {
    const auto json = nlohmann::json::parse(row);
    ASSERT_TRUE(records.Next());
    ASSERT_EQ(records.cells().size(), header.size());
    EXPECT_EQ(records.cells()[0], json["image"]);
    EXPECT_EQ(records.cells()[1], json["status"]);
    if (json["status"] != "LOCALIZED") {
      EXPECT_EQ(records.cells()[2], json["reason"]);
      continue;
    }
    std::string name;
    double w = 0, x = 0, y = 0, z = 0, tx = 0, ty = 0, tz = 0;
    ASSERT_TRUE(lines >> name >> w >> x >> y >> z >> tx >> ty >> tz);
    EXPECT_EQ(name, json["image"]);
    EXPECT_EQ(tx, json["camFromWorld"]["translation"][0].get<double>());
    EXPECT_EQ(w, json["camFromWorld"]["quaternion"]["w"].get<double>());
    const double lon_deg = *records.Number(5);
    EXPECT_NEAR(lon_deg, 8.0 + 1e-4 * std::stoi(name), 1e-9);
  }
  std::string rest;
  EXPECT_FALSE(lines >> rest);
}

TEST_F(LocalizeBatch, HlocsLinesRefuseBlanksInNames) {
  ExpectError([&] { ResultFile(dir_.File("out.txt"), "run", {"my photo.jpg"}); },
              ErrorCode::kBadInput, "has a blank");
  ExpectError([&] { ResultFormatOf("out.json"); }, ErrorCode::kInvalidArgument, ".jsonl");
}

TEST(WorldFrames, StatePosesRelativeToTheirOrigin) {
  const Geodetic origin = Geodetic::FromDegrees(49.0, 8.0, 100.0);
  const Eigen::Vector3d x_in_enu(3.0, -2.0, 1.5);
  const Eigen::Vector3d x_in_ecef = EcefFromEnu(origin) * x_in_enu;
  const Rigid3d cam_from_enu(Eigen::Quaterniond(0.5, 0.5, -0.5, 0.5), {1.0, 2.0, 3.0});
  const Rigid3d cam_from_ecef = cam_from_enu * EcefFromEnu(origin).Inverse();
  const WorldFrame enu = EnuFrame(origin);
  EXPECT_LT((enu.CamFromWorld(cam_from_ecef) * x_in_enu - cam_from_enu * x_in_enu).norm(), 1e-8);
  EXPECT_THAT(enu.Text(), HasSubstr("49,8,100"));
  const WorldFrame ecef;
  EXPECT_LT((ecef.CamFromWorld(cam_from_ecef) * x_in_ecef - cam_from_enu * x_in_enu).norm(), 1e-8);
}

class LocalizeImagesVerb : public LocalizeBatch {
 protected:
  LocalizeImagesVerb() : map_(MakeStreetMap(dir_.File("map.gpkg"))) {
    AddPhoto("photos/1.pgm");
    Write("photos/2.pgm", "no picture");
    AddPhoto("photos/3.pgm");
  }
  Finished Localize(const std::vector<std::string>& more) const {
    std::vector<std::string> arguments = {"localize", map_, "--images", dir_.File("photos")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return RunCairn(arguments);
  }

  std::string map_;
};

TEST_F(LocalizeImagesVerb, WritesARowForEachPhotoAndASummary) {
  const std::string output = dir_.File("out.csv");
  const Finished finished = Localize({"--output", output, "--prior", "49.011,8.416,115", "--json"});
  EXPECT_EQ(finished.exit_code, 3) << finished.err;  // No photo shows the street.
  const auto summary = nlohmann::json::parse(finished.out);
  EXPECT_EQ(summary["photos"], 3);
  EXPECT_EQ(summary["reasons"]["BAD_PHOTO"], 1);
  const std::string csv = ContentOf(output);
  EXPECT_THAT(csv, StartsWith("image,status,reason,"));
  EXPECT_THAT(csv, HasSubstr("\r\n2.pgm,FAILED,BAD_PHOTO,"));
  EXPECT_THAT(csv, HasSubstr("\r\n3.pgm,NOT_LOCALIZED,TOO_FEW_FEATURES,"));
}

TEST_F(LocalizeImagesVerb, RefusesArgumentsThatDoNotFit) {
  const auto expect_refused = [this](const std::vector<std::string>& more, const char* text) {
    const Finished finished = Localize(more);
    EXPECT_EQ(finished.exit_code, 2) << text;
    EXPECT_THAT(finished.err, HasSubstr(text));
  };
  expect_refused({}, "--images needs --output");
  expect_refused({"--output", "a.xml"}, ".csv, .jsonl");
  expect_refused({"--output", "a.csv", "--image", "b.jpg"}, "give either --image FILE or");
  expect_refused({"--output", "a.csv", "--rig", "b.json"}, "for one photo");
  expect_refused({"--output", "a.csv", "--frame", "ecef", "--origin", "49,8,1"}, "--origin is for");
  EXPECT_EQ(RunCairn({"localize", map_}).exit_code, 2);
}

TEST_F(LocalizeImagesVerb, AServerThatIsGoneEndsTheRunAndKeepsTheRows) {
  const Finished finished = RunCairn({"localize", "--server", "http://127.0.0.1:1", "--images",
                                      dir_.File("photos"), "--output", dir_.File("out.csv")});
  EXPECT_EQ(finished.exit_code, 7) << finished.err;
  EXPECT_FALSE(std::filesystem::exists(dir_.File("out.csv")));
  EXPECT_TRUE(std::filesystem::exists(dir_.File("out.csv.part")));
}

TEST_F(LocalizeImagesVerb, AServerAnswersAsTheMapDoes) {
  BackgroundCairn server({"serve", map_, "--port", "0", "--log-level", "off"});
  const std::string url = server.ReadLine();
  const std::vector<std::string> prior = {"--prior", "49.011,8.416,115"};
  Localize({"--output", dir_.File("map.csv"), prior[0], prior[1]});
  const Finished finished = RunCairn({"localize", "--server", url, "--images", dir_.File("photos"),
                                      "--output", dir_.File("server.csv"), prior[0], prior[1]});
  EXPECT_EQ(finished.exit_code, 3) << finished.err;
  // The messages for the broken photo differ.
  const auto status_of = [](const std::string& csv) {
    std::set<std::string> cells;
    CsvReader records(csv);
    while (records.Next()) {
      cells.insert(records.cells()[0] + " " + records.cells()[1] + " " + records.cells()[2]);
    }
    return cells;
  };
  EXPECT_EQ(status_of(ContentOf(dir_.File("map.csv"))),
            status_of(ContentOf(dir_.File("server.csv"))));
}

}  // namespace
}  // namespace cairn::testing
