// Runs the clients that users have against a `cairn serve` of a rendered street.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "cli/demo/demo_world.h"
#include "cli/npm_folder.h"
#include "cli/open_page.h"
#include "cli/run_cairn.h"
#include "core/angles.h"
#include "core/error.h"
#include "core/images/orient_image.h"
#include "core/wire/base64.h"
#include "core/wire/inner_frame.h"
#include "eval/pictures/encode_png.h"
#include "http/client.h"
#include "support/exif_bytes.h"
#include "support/temp_dir.h"

namespace cairn::testing {
namespace {

namespace fs = std::filesystem;
using ::nlohmann::json;
using ::testing::HasSubstr;

class Clients : public ::testing::Test {
 protected:
  // Made once a process, since mapping a street takes seconds. No test changes the map.
  static DemoWorld& World() {
    static const TempDir dir;
    static DemoWorld world = [] {
      Progress silent(ProgressMode::kPlain);
      return MakeDemoWorld({.output_dir = dir.path(), .quick = true}, &silent);
    }();
    return world;
  }

  // Height, latitude and longitude of an answer against the truth.
  static double ErrorM(const json& geopose, const EvalQuery& query) {
    const json& position = geopose.at("position");
    const Geodetic answer = Geodetic::FromDegrees(position["lat"], position["lon"], position["h"]);
    return (EcefFromGeodetic(answer) - query.cam_from_ecef.Inverse().translation).norm();
  }

  // Angle between the answer's quaternion and the pose of the photo, FLU.
  static double ErrorDeg(const json& geopose, const EvalQuery& query) {
    const json& q = geopose.at("quaternion");
    const Eigen::Quaterniond answer(q["w"], q["x"], q["y"], q["z"]);
    return kDegPerRad *
           RotationAngleRad(
               answer, GeoPoseFromCamera(query.cam_from_ecef, InnerFrame::kFlu).enu_from_inner);
  }

  TempDir dir_;
  DemoWorld& world_ = World();
};

class NpmClient : public Clients {
 protected:
  // Writes the request to a file, runs the command of the folder with the name of the file, and
  // returns what the command prints.
  json Ask(const NpmFolder& folder, const std::string& command, const json& request) {
    std::ofstream(dir_.File("ask.json")) << request;
    const auto [text, code] = folder.Run(command + " '" + dir_.File("ask.json") + "'");
    EXPECT_EQ(code, 0) << text;
    const json answer = json::parse(text, nullptr, false);
    EXPECT_TRUE(answer.is_object()) << text;
    return answer;
  }
};

TEST_F(NpmClient, OfGeoPoseProtocolIsAnswered) {
  const NpmFolder folder("gpp_access");
  if (!folder.why_not().empty()) {
    GTEST_SKIP() << folder.why_not();
  }
  BackgroundCairn server({"serve", world_.map_path, "--port", "0", "--log-level", "off"});
  const EvalQuery& query = world_.queries[1];
  const Camera& camera = query.query.camera;
  const Geodetic& prior = query.query.prior->position;
  json ask = {{"url", server.ReadLine()},
              {"photo", query.image_path},
              {"size", {camera.width_px(), camera.height_px()}},
              {"modelParams", camera.params()},
              {"lat", prior.lat_deg()},
              {"lon", prior.lon_deg()},
              {"accuracy", 15}};
  const json known = Ask(folder, "node ask.mjs", ask);
  ASSERT_TRUE(known.contains("geopose")) << known;
  EXPECT_EQ(known["id"], "asked-by-npm");
  EXPECT_LT(ErrorM(known["geopose"], query), 0.5);
  EXPECT_LT(ErrorDeg(known["geopose"], query), 2.0);

  // The client's own defaults for a camera that nobody knows.
  json unknown = ask;
  unknown["modelParams"] = nullptr;
  unknown["size"] = {0, 0};
  const json estimated = Ask(folder, "node ask.mjs", unknown);
  ASSERT_TRUE(estimated.contains("geopose")) << estimated;
  EXPECT_LT(ErrorM(estimated["geopose"], query), 2.0);

  // Its GPS is read, although it spells the member in its own way: elsewhere there is no map.
  ask["lat"] = prior.lat_deg() + 1.0;
  const json elsewhere = Ask(folder, "node ask.mjs", ask);
  ASSERT_TRUE(elsewhere.contains("error")) << elsewhere;
  EXPECT_THAT(elsewhere["error"].get<std::string>(), HasSubstr("NO_COVERAGE"));
}

TEST(OpenApi, HasNoWarningsOfSpectral) {
  const NpmFolder folder("typescript");
  if (!folder.why_not().empty()) {
    GTEST_SKIP() << folder.why_not();
  }
  const auto [text, code] = folder.Run(
      "npx spectral lint --ruleset .spectral.yaml --fail-severity warn "
      "'" CAIRN_SOURCE_DIR "/http/openapi.json'");
  EXPECT_EQ(code, 0) << text;
}

TEST_F(NpmClient, GeneratedFromTheDescriptionCompilesAndIsAnswered) {
  const NpmFolder folder("typescript");
  if (!folder.why_not().empty()) {
    GTEST_SKIP() << folder.why_not();
  }
  const auto [text, code] = folder.Run("npx openapi-typescript '" CAIRN_SOURCE_DIR
                                       "/http/openapi.json' -o schema.d.ts && npx tsc -p .");
  ASSERT_EQ(code, 0) << text;
  BackgroundCairn server({"serve", world_.map_path, "--port", "0", "--log-level", "off"});
  const EvalQuery& query = world_.queries[1];
  const Camera& camera = query.query.camera;
  const Geodetic& prior = query.query.prior->position;
  const std::vector<uint8_t> photo = EncodePng(world_.photos[1]);
  const json found =
      Ask(folder, "node run.mjs " + server.ReadLine(),
          {{"camera",
            {{"model", CameraModelName(camera.model())},
             {"size", {camera.width_px(), camera.height_px()}},
             {"modelParams", camera.params()}}},
           {"image", {{"data", EncodeBase64(photo)}}},
           {"prior", {{"position", {{"lat", prior.lat_deg()}, {"lon", prior.lon_deg()}}}}},
           {"options", {{"timeoutMs", 60000}}}});
  EXPECT_EQ(found["covered"], true);
  EXPECT_GE(found["tilesListed"].get<int>(), 1);
  EXPECT_EQ(found["firstTileHasLandmarks"], true);
  EXPECT_EQ(found["codeOfRefusal"], "bad_input");
  ASSERT_TRUE(found.contains("pose")) << found;
  EXPECT_LT(ErrorM(found["pose"], query), 0.5);
}

// The picture as a camera that is held upright stores it: the sensor's landscape pixels, with an
// EXIF that turns them by 90 degrees clockwise.
std::vector<uint8_t> StoredOnItsSide(const GrayImage& upright) {
  constexpr int kTurnClockwise = 6, kTurnAnticlockwise = 8;
  return PngWithExifBlock(EncodePng(OrientImage(upright, kTurnAnticlockwise)),
                          ExifBlock({.orientation = kTurnClockwise}));
}

class PortraitPhotos : public Clients {
 protected:
  PortraitPhotos() : bytes_(StoredOnItsSide(world_.photos[1])) {
    std::ofstream file(path_, std::ios::binary);
    file.write(reinterpret_cast<const char*>(bytes_.data()),
               static_cast<std::streamsize>(bytes_.size()));
  }

  // A pinhole camera of these pixels, as --camera has it.
  static std::string CameraOption(const Camera& camera) {
    std::string text = std::string(CameraModelName(camera.model())) + "," +
                       std::to_string(camera.width_px()) + "," + std::to_string(camera.height_px());
    for (const double param : camera.params()) {
      text += "," + std::to_string(param);
    }
    return text;
  }

  // `cairn localize` of the photo; the answer's geopose.
  json Localize(const std::vector<std::string>& options) {
    std::vector<std::string> arguments = {"localize", "--image", path_, "--json"};
    arguments.insert(arguments.end(), options.begin(), options.end());
    const Finished finished = RunCairn(arguments);
    EXPECT_EQ(finished.exit_code, 0) << finished.err << finished.out;
    const json answer = json::parse(finished.out, nullptr, false);
    return answer.is_object() ? answer["geopose"] : json();
  }

  const EvalQuery& query() const { return world_.queries[1]; }

  // The stored pixels' camera: what was right is above, what was below is right.
  Camera StoredCamera() const {
    const Camera& upright = query().query.camera;
    const std::vector<double>& p = upright.params();
    return Camera(CameraModel::kPinhole, upright.height_px(), upright.width_px(),
                  {p[1], p[0], p[3], upright.width_px() - p[2]});
  }

  std::vector<uint8_t> bytes_;
  std::string path_ = dir_.File("portrait.png");
};

TEST_F(PortraitPhotos, AreAnsweredAsTheirOwnerHeldTheCamera) {
  // Nothing said: the photo is upright, and so is the pose.
  const json guessed = Localize({world_.map_path});
  EXPECT_LT(ErrorM(guessed, query()), 2.0);
  EXPECT_LT(ErrorDeg(guessed, query()), 4.0);
  // The camera of the upright picture, as its size says.
  const json upright = Localize({world_.map_path, "--camera", CameraOption(query().query.camera)});
  EXPECT_LT(ErrorM(upright, query()), 0.5);
  EXPECT_LT(ErrorDeg(upright, query()), 2.0);
  // The camera of the stored pixels: the same place, turned by 90 degrees about the optical axis.
  const json stored = Localize({world_.map_path, "--camera", CameraOption(StoredCamera())});
  EXPECT_LT(ErrorM(stored, query()), 0.5);
  EXPECT_NEAR(ErrorDeg(stored, query()), 90.0, 2.0);
}

TEST_F(PortraitPhotos, AreAnsweredTheSameByAServer) {
  BackgroundCairn server({"serve", world_.map_path, "--port", "0", "--log-level", "off"});
  const std::string url = server.ReadLine();
  const json guessed = Localize({"--server", url});
  EXPECT_LT(ErrorM(guessed, query()), 2.0);
  EXPECT_LT(ErrorDeg(guessed, query()), 4.0);
  const json stored = Localize({"--server", url, "--camera", CameraOption(StoredCamera())});
  EXPECT_NEAR(ErrorDeg(stored, query()), 90.0, 2.0);
  // Neither of the two pictures.
  EvalQuery other = query();
  other.query.camera = Camera(CameraModel::kSimplePinhole, 100, 100, {90, 50, 50});
  EXPECT_THROW(LocalizeClient({.url = url}).LocalizeImages(other.query, {bytes_}), Error);
}

// Photos with a rough position in their EXIF.
class PlacedPhotos : public PortraitPhotos {
 protected:
  // Writes the photo of the query with this position, and returns its path.
  std::string WritePhoto(double lat_deg, double lon_deg) {
    ExifContent exif;
    exif.lat_deg = lat_deg;
    exif.lon_deg = lon_deg;
    exif.altitude_m = 400.0;
    exif.error_m = 20.0;
    const std::vector<uint8_t> png = PngWithExifBlock(EncodePng(world_.photos[1]), ExifBlock(exif));
    const std::string path = dir_.File("placed.png");
    std::ofstream file(path, std::ios::binary);
    file.write(reinterpret_cast<const char*>(png.data()), static_cast<std::streamsize>(png.size()));
    return path;
  }
  std::string WritePlacedPhoto() {
    const Geodetic& near = query().query.prior->position;
    return WritePhoto(near.lat_deg(), near.lon_deg());
  }

  // As WritePhoto, with sides four times as long.
  std::string WriteLargePhoto(double lat_deg, double lon_deg) {
    const GrayImage& photo = world_.photos[1];
    GrayImage large = BlankImage(4 * photo.width_px, 4 * photo.height_px);
    for (size_t i = 0; i < large.pixels.size(); ++i) {
      const size_t x = i % large.width_px / 4, y = i / large.width_px / 4;
      large.pixels[i] = photo.pixels[y * photo.width_px + x];
    }
    std::swap(world_.photos[1], large);
    const std::string path = WritePhoto(lat_deg, lon_deg);
    std::swap(world_.photos[1], large);
    return path;
  }

  static json Ask(const std::vector<std::string>& arguments) {
    const Finished finished = RunCairn(arguments);
    const json answer = json::parse(finished.out, nullptr, false);
    EXPECT_TRUE(answer.is_object()) << finished.err << finished.out;
    return answer;
  }
};

TEST_F(PlacedPhotos, ArePriorsOfTheirOwn) {
  const std::string photo = WritePlacedPhoto();
  const json answer = Ask({"localize", world_.map_path, "--image", photo, "--json"});
  EXPECT_EQ(answer["status"], "LOCALIZED");
  EXPECT_EQ(answer["prior"]["source"], "exif");
  EXPECT_NEAR(answer["prior"]["accuracy"].get<double>(), 20.0, 1e-6);
  const Finished text = RunCairn({"localize", world_.map_path, "--image", photo});
  EXPECT_THAT(text.out, HasSubstr("+- 20 m, from the photo's EXIF"));
  const json without =
      Ask({"localize", world_.map_path, "--image", photo, "--json", "--no-exif-prior"});
  EXPECT_TRUE(without["prior"].is_null());
  const Geodetic& near = query().query.prior->position;
  const json with_prior =
      Ask({"localize", world_.map_path, "--image", photo, "--json", "--prior",
           std::to_string(near.lat_deg()) + "," + std::to_string(near.lon_deg()) + ",0"});
  EXPECT_EQ(with_prior["prior"]["source"], "request");
}

TEST_F(PlacedPhotos, AreFarFromTheMapInWords) {
  const Geodetic& near = query().query.prior->position;
  const std::string swapped = WritePhoto(near.lon_deg(), near.lat_deg());
  const Finished text = RunCairn({"localize", world_.map_path, "--image", swapped});
  EXPECT_THAT(text.out, HasSubstr("NO_COVERAGE: the nearest tile is "));
  EXPECT_THAT(text.out, HasSubstr("are latitude and longitude swapped?"));
}

TEST_F(PlacedPhotos, AreUnderstoodByAServer) {
  BackgroundCairn server({"serve", world_.map_path, "--port", "0", "--log-level", "off"});
  const std::string url = server.ReadLine();
  const Geodetic& near = query().query.prior->position;
  const auto curl = [&](const std::string& photo, const std::string& options) {
    const Camera& camera = query().query.camera;
    const json request = {{"camera", {{"size", {camera.width_px(), camera.height_px()}}}},
                          {"options", json::parse(options)}};
    const auto [text, code] =
        RunShell("curl -s '" + url + "/v1/localize' -F 'request=" + request.dump() +
                 ";type=application/json' -F 'image=@" + photo + "'");
    EXPECT_EQ(code, 0) << text;
    return json::parse(text, nullptr, false);
  };
  const std::string placed = WritePlacedPhoto();
  EXPECT_EQ(curl(placed, "{}")["prior"]["source"], "exif");
  EXPECT_TRUE(curl(placed, R"({"exifPrior":false})")["prior"].is_null());
  const json far = curl(WritePhoto(near.lat_deg(), -near.lon_deg()), "{}");
  EXPECT_EQ(far["reason"], "NO_COVERAGE");
  EXPECT_THAT(far["reasonText"].get<std::string>(), HasSubstr("West is negative"));
  // Without the position, the photo of the same file is found.
  EXPECT_EQ(curl(dir_.File("placed.png"), R"({"exifPrior":false})")["status"], "LOCALIZED");
}

class Page : public PlacedPhotos {
 protected:
  json Open(const json& todo) { return OpenPage(todo, dir_); }

  // Meters between the position that the page shows, "55.1234567°, 13.1234567°, 12.34 m", and the
  // truth.
  double ShownErrorM(const std::string& answer) const {
    double lat_deg = 0.0, lon_deg = 0.0, h_m = 0.0;
    EXPECT_EQ(std::sscanf(answer.c_str(), "%lf°, %lf°, %lf m", &lat_deg, &lon_deg, &h_m), 3)
        << answer;
    return ErrorM({{"position", {{"lat", lat_deg}, {"lon", lon_deg}, {"h", h_m}}}}, query());
  }
};

TEST_F(Page, LocalizesPhotosInABrowser) {
  if (const std::string why_not = WhyNoBrowser(); !why_not.empty()) {
    GTEST_SKIP() << why_not;
  }
  std::ofstream(dir_.File("letter.jpg")) << "This is no photo.";
  BackgroundCairn server({"serve", world_.map_path, "--port", "0", "--log-level", "off"});
  const Geodetic& prior = query().query.prior->position;
  const json near = {{"photo", query().image_path},
                     {"lat", prior.lat_deg()},
                     {"lon", prior.lon_deg()},
                     {"accuracy", 15},
                     {"focal", query().query.camera.params()[0]}};
  const std::string large = WriteLargePhoto(prior.lat_deg() + 1.0, prior.lon_deg());
  json elsewhere = near;
  elsewhere["lat"] = prior.lat_deg() + 1.0;
  const json seen = Open({{"url", server.ReadLine()},
                          {"visits",
                           {near,
                            {{"photo", query().image_path}},
                            {{"photo", path_}},
                            elsewhere,
                            {{"photo", dir_.File("letter.jpg")}},
                            {{"photo", large}},
                            {{"photo", large}, {"exif", false}}}}});
  const std::vector<std::string> answers = seen.value("answers", std::vector<std::string>());
  ASSERT_EQ(answers.size(), 7u) << seen;
  EXPECT_LT(ShownErrorM(answers[0]), 0.5);
  EXPECT_LT(ShownErrorM(answers[1]), 2.0);
  EXPECT_THAT(answers[1], HasSubstr("focal length"));
  EXPECT_LT(ShownErrorM(answers[2]), 2.0);  // Stored on its side.
  EXPECT_THAT(answers[3], HasSubstr("NO_COVERAGE"));
  EXPECT_THAT(answers[3], HasSubstr("the nearest tile is "));
  EXPECT_THAT(answers[4], HasSubstr("letter.jpg is not a photo"));
  // The page shrinks this photo, and its position still counts, unless the person says otherwise.
  EXPECT_THAT(answers[5], HasSubstr("NO_COVERAGE"));
  EXPECT_THAT(answers[5], HasSubstr("from the photo's EXIF"));
  EXPECT_LT(ShownErrorM(answers[6]), 2.0);
  EXPECT_EQ(seen["console"], json::array());
  EXPECT_THAT(seen["status"].get<std::string>(), HasSubstr("running"));
}

TEST_F(Page, ReadsNumbersAsPeopleWriteThem) {
  if (const std::string why_not = WhyNoBrowser(); !why_not.empty()) {
    GTEST_SKIP() << why_not;
  }
  BackgroundCairn server({"serve", world_.map_path, "--port", "0", "--log-level", "off"});
  const Geodetic& prior = query().query.prior->position;
  const std::string lat = fmt::format("{:.6f}", prior.lat_deg());
  const std::string lon = fmt::format("{:.6f}", prior.lon_deg());
  const std::string focal = fmt::format("{:.1f} px", query().query.camera.params()[0]);
  const std::string photo = query().image_path;
  const json seen =
      Open({{"url", server.ReadLine()},
            {"visits",
             {{{"photo", photo}, {"lat", lat + ", " + lon}, {"accuracy", 15}, {"focal", focal}},
              {{"photo", photo}, {"lat", lat + "° N"}, {"lon", lon + " E"}},
              {{"photo", photo}, {"lat", lat}},
              {{"photo", photo}, {"focal", "long"}}}}});
  const std::vector<std::string> answers = seen.value("answers", std::vector<std::string>());
  ASSERT_EQ(answers.size(), 4u) << seen;
  EXPECT_LT(ShownErrorM(answers[0]), 0.5);
  EXPECT_THAT(answers[0], HasSubstr("from the form"));
  EXPECT_THAT(answers[1], HasSubstr("from the form"));
  EXPECT_EQ(answers[2], "Latitude without longitude: give both or none");
  EXPECT_THAT(answers[3], HasSubstr("Focal length: \"long\" is not a number"));
}

TEST_F(Page, AsksForTheKeyOfAServerThatWantsOne) {
  if (const std::string why_not = WhyNoBrowser(); !why_not.empty()) {
    GTEST_SKIP() << why_not;
  }
  const std::string keys = dir_.File("keys.json");
  const Finished made =
      RunCairn({"keys", "new", keys, "--label", "page", "--may", "localize,look"});
  ASSERT_EQ(made.exit_code, 0) << made.err;
  BackgroundCairn server(
      {"serve", world_.map_path, "--port", "0", "--log-level", "off", "--api-keys", keys});
  const json seen = Open({{"url", server.ReadLine()},
                          {"key", made.out.substr(0, made.out.find('\n'))},
                          {"visits", {{{"photo", query().image_path}}}}});
  EXPECT_THAT(seen.value("before", ""), HasSubstr("this route needs an API key"));
  EXPECT_THAT(seen.value("status", ""), HasSubstr("running"));
  const std::vector<std::string> answers = seen.value("answers", std::vector<std::string>());
  ASSERT_EQ(answers.size(), 1u) << seen;
  EXPECT_LT(ShownErrorM(answers[0]), 2.0);
}

}  // namespace
}  // namespace cairn::testing
