// Where a test puts its maps: files, or databases of a PostgreSQL server.
#ifndef CAIRN_TESTS_SUPPORT_MAP_PLACE_H_
#define CAIRN_TESTS_SUPPORT_MAP_PLACE_H_

#include <gtest/gtest.h>

#include <map>
#include <string>

#include "support/temp_dir.h"
#ifdef CAIRN_WITH_POSTGRES
#include "support/postgres_cluster.h"
#endif

namespace cairn::testing {

enum class MapKind { kFile, kServer };

// The base of tests that run on both kinds of maps.
class MapPlaceTest : public ::testing::TestWithParam<MapKind> {
 protected:
  // Skips the test if it needs a server and there can be none.
  void SetUp() override {
    if (const std::string reason = WhyNot(); !reason.empty()) {
      GTEST_SKIP() << reason;
    }
  }

  // Returns the path or the URL of a map, which need not exist. Each test has maps of its own.
  std::string Place(const std::string& name) {
    if (GetParam() == MapKind::kFile) {
      return dir_.File(name + ".gpkg");
    }
#ifdef CAIRN_WITH_POSTGRES
    std::string& url = urls_[name];
    if (url.empty()) {
      static int number = 0;
      url = PostgresCluster::Shared().CreateDatabase(name + std::to_string(number++));
    }
    return url;
#else
    return {};
#endif
  }

 private:
  std::string WhyNot() const {
    if (GetParam() == MapKind::kFile) {
      return "";
    }
#ifdef CAIRN_WITH_POSTGRES
    return PostgresCluster::WhyNot();
#else
    return "this Cairn was built without PostgreSQL";
#endif
  }

  TempDir dir_;
  std::map<std::string, std::string> urls_;
};

inline std::string NameOfKind(const ::testing::TestParamInfo<MapKind>& info) {
  return info.param == MapKind::kFile ? "OnFile" : "OnServer";
}

}  // namespace cairn::testing

// Runs the tests of a fixture that derives from MapPlaceTest on both kinds of maps.
#define CAIRN_ON_BOTH_KINDS_OF_MAPS(Fixture)                                                   \
  INSTANTIATE_TEST_SUITE_P(                                                                    \
      , Fixture,                                                                               \
      ::testing::Values(::cairn::testing::MapKind::kFile, ::cairn::testing::MapKind::kServer), \
      ::cairn::testing::NameOfKind)

#endif  // CAIRN_TESTS_SUPPORT_MAP_PLACE_H_
