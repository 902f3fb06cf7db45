// Tests a server whose map has lost a part. The answer is 500 with `map_damaged` and contains no
// path.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sqlite3.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "core/error.h"
#include "core/wire/feature_codec.h"
#include "http/plain_http.h"
#include "http/server_fixture.h"

namespace cairn {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

class DamagedMap : public testing::ServerFixture {
 protected:
  // A server on a copy of the street's map in which `sql` was run; foreign keys are not enforced.
  static std::unique_ptr<Server> ServeDamaged(const std::string& sql) {
    static int num_maps = 0;
    const std::string path = dir_->File(std::to_string(++num_maps) + "_damaged.gpkg");
    std::filesystem::copy_file(map_path(), path);
    sqlite3* db = nullptr;
    EXPECT_EQ(sqlite3_open(path.c_str(), &db), SQLITE_OK);
    EXPECT_EQ(sqlite3_exec(db, sql.c_str(), nullptr, nullptr, nullptr), SQLITE_OK);
    sqlite3_close(db);
    ServerOptions options = Options();
    options.map_path = path;
    auto server = std::make_unique<Server>(options);
    server->Start();
    return server;
  }

  static void ExpectMapDamaged(const httplib::Result& reply) {
    ASSERT_TRUE(reply);
    EXPECT_EQ(reply->status, 500) << reply->body;
    EXPECT_EQ(nlohmann::json::parse(reply->body)["code"], "map_damaged");
    EXPECT_THAT(reply->body, Not(HasSubstr(dir_->path().string())));
    EXPECT_THAT(reply->body, Not(HasSubstr("damaged.gpkg")));
  }

  // The features of a view that the whole map answers.
  static httplib::Result Localize(Server* server) {
    const LocalizeQuery query = Query();
    const Camera& camera = query.camera;
    const nlohmann::json json = {{"camera",
                                  {{"model", CameraModelName(camera.model())},
                                   {"size", {camera.width_px(), camera.height_px()}},
                                   {"modelParams", camera.params()}}}};
    const std::vector<uint8_t> blob = EncodeFeatures(
        {query.features, "", camera.width_px(), camera.height_px()}, FeatureEncoding());
    const httplib::MultipartFormDataItems items = {
        {"request", json.dump(), "", "application/json"},
        {"features", std::string(blob.begin(), blob.end()), "f", "application/octet-stream"}};
    return httplib::Client("127.0.0.1", server->port()).Post("/v1/localize", items);
  }
};

TEST_F(DamagedMap, AWholeMapAnswers) {
  const auto reply = Localize(server_.get());
  ASSERT_TRUE(reply);
  EXPECT_EQ(reply->status, 200) << reply->body;
}

TEST_F(DamagedMap, AMissingPayloadIsTheServersFault) {
  const auto server = ServeDamaged("DELETE FROM cairn_payloads");
  const std::string tile_id =
      MapStore::Open(map_path(), OpenMode::kReadOnly).Snapshot().AllTiles(1)[0].tile_id.ToString();
  httplib::Client client("127.0.0.1", server->port());
  client.set_read_timeout(60);  // The machine may be busy.
  ExpectMapDamaged(client.Get("/v1/tiles/" + tile_id + "/payload"));
  ExpectMapDamaged(Localize(server.get()));
}

TEST_F(DamagedMap, AMissingCodebookOfATileIsTheServersFault) {
  const auto server = ServeDamaged("UPDATE cairn_tiles SET codebook_id = 1000");
  ExpectMapDamaged(Localize(server.get()));
}

TEST_F(DamagedMap, ACodebookThatIsMissingOrDoesNotDecodeKeepsTheServerFromStarting) {
  for (const char* damage : {"UPDATE cairn_codebooks SET codebook_id = 1000",
                             "UPDATE cairn_codebooks SET bytes = x'00'"}) {
    try {
      ServeDamaged(damage);
      ADD_FAILURE() << "started";
    } catch (const Error& e) {
      EXPECT_THAT(e.what(), HasSubstr("codebook"));
    }
  }
}

}  // namespace
}  // namespace cairn
