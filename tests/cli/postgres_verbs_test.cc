// Tests the commands with maps in PostgreSQL: exit codes and messages of what goes wrong, and that
// a password is never shown.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <string>
#include <vector>

#include "cli/run_cairn.h"
#include "support/postgres_cluster.h"
#include "support/temp_dir.h"

namespace cairn::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::StartsWith;

void ExpectRefusal(const std::vector<std::string>& arguments, int exit_code,
                   const std::string& message_part) {
  const Finished finished = RunCairn(arguments);
  EXPECT_EQ(finished.exit_code, exit_code) << finished.err;
  EXPECT_THAT(finished.out, IsEmpty());
  EXPECT_THAT(finished.err, StartsWith("cairn: "));
  EXPECT_THAT(finished.err, HasSubstr(message_part));
}

TEST(PostgresVerbs, APasswordInTheUrlIsRefusedAndNeverShown) {
  const TempDir dir;
  const std::string file = dir.File("map.gpkg");
  ASSERT_EQ(RunCairn({"init", file}).exit_code, 0);
  const std::string url = "postgresql://u:secret@127.0.0.1:1/m";
  const std::vector<std::vector<std::string>> commands = {
      {"init", url},
      {"info", url},
      {"check", url},
      {"log", url},
      {"diff", url, "1", "2"},
      {"sql", url, "SELECT 1"},
      {"serve", url},
      {"remove", url, "s"},
      {"rollback", url, "1"},
      {"prune", url, "--keep", "1"},
      {"recode", url, "--codebook", "shipped"},
      {"extract", url, "--bbox", "1,1,2,2", "--out", dir.File("out.gpkg")},
      {"copy", url, dir.File("copy.gpkg")},
      {"copy", file, url},
      {"merge", url, file, "--out", dir.File("merged.gpkg")},
      {"compact", url}};
  for (const std::vector<std::string>& arguments : commands) {
    const Finished finished = RunCairn(arguments);
    EXPECT_EQ(finished.exit_code, 2) << arguments[0] << ": " << finished.err;
    EXPECT_THAT(finished.out + finished.err, Not(HasSubstr("secret"))) << arguments[0];
  }
}

TEST(PostgresVerbs, EveryRefusalSaysWhatToDo) {
  if (const std::string reason = PostgresCluster::WhyNot(); !reason.empty()) {
    GTEST_SKIP() << reason;
  }
  PostgresCluster cluster(
      "host all guarded 127.0.0.1/32 scram-sha-256\n"
      "hostssl all encrypted 127.0.0.1/32 trust\n"
      "hostnossl all cairn,nobody,maker 127.0.0.1/32 trust");
  cluster.Execute("postgres",
                  "CREATE ROLE guarded LOGIN PASSWORD 'right'; CREATE ROLE encrypted LOGIN; "
                  "CREATE ROLE maker LOGIN");
  cluster.CreateDatabase("city");
  cluster.CreateDatabase("replica");
  cluster.CreateDatabase("bare");
  cluster.Execute("postgres", "ALTER DATABASE bare OWNER TO maker");
  const auto url = [&](const char* database, const char* user) {
    return cluster.HostUrl(database, user);
  };
  ASSERT_EQ(RunCairn({"init", url("city", "cairn")}).exit_code, 0);
  ASSERT_EQ(RunCairn({"init", url("replica", "cairn")}).exit_code, 0);
  ASSERT_EQ(RunCairn({"info", url("city", "cairn")}).exit_code, 0);

  setenv("PGPASSWORD", "wrong", 1);
  ExpectRefusal({"info", url("city", "guarded")}, 6, "PGPASSFILE");
  EXPECT_THAT(RunCairn({"info", url("city", "guarded")}).err, Not(HasSubstr("wrong")));
  setenv("PGPASSWORD", "right", 1);
  ExpectRefusal({"info", url("city", "guarded")}, 6, "GRANT cairn_reader");
  unsetenv("PGPASSWORD");
  ExpectRefusal({"info", url("city", "guarded")}, 6, "PGPASSFILE");

  ExpectRefusal({"info", url("city", "encrypted")}, 6, "sslmode=require");
  ExpectRefusal({"info", url("city", "cairn") + "?sslmode=require"}, 6, "TLS on the server");
  ExpectRefusal({"info", url("none", "cairn")}, 4, "createdb");
  ExpectRefusal({"info", url("city", "nobody")}, 4, "createuser");
  ExpectRefusal({"info", url("bare", "cairn")}, 4, "cairn init");
  ExpectRefusal({"init", url("city", "cairn")}, 4, "has a map already");
  ExpectRefusal({"init", url("bare", "maker")}, 6, "CREATE EXTENSION postgis");

  // What libpq says of a standby.
  cluster.Execute("postgres", "ALTER DATABASE replica SET default_transaction_read_only = on");
  ExpectRefusal({"prune", url("replica", "cairn"), "--keep", "1"}, 4, "address of the primary");
  cluster.Execute("city", "INSERT INTO cairn.cairn_migrations VALUES (99, 'later')");
  ExpectRefusal({"info", url("city", "cairn")}, 4, "newer Cairn");
  cluster.Kill();
  ExpectRefusal({"info", url("city", "cairn")}, 7, "is the server running");
}

}  // namespace
}  // namespace cairn::testing
