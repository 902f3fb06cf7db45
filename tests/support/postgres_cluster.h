// A PostgreSQL server of a test's own, thrown away at its end.
#ifndef CAIRN_TESTS_SUPPORT_POSTGRES_CLUSTER_H_
#define CAIRN_TESTS_SUPPORT_POSTGRES_CLUSTER_H_

#include <sys/types.h>

#include <memory>
#include <string>
#include <vector>

namespace cairn::testing {

// Runs as the user nobody if the test runs as root, because PostgreSQL refuses to. Listens on a
// socket in a temporary folder only. The server ends with the test, however the test ends.
class PostgresCluster {
 public:
  // Returns why there can be no server here; empty if there can be one.
  static std::string WhyNot();
  // Returns the server that all tests of this process share. Starts it at the first call.
  static PostgresCluster& Shared();

  PostgresCluster();
  ~PostgresCluster();
  PostgresCluster(const PostgresCluster&) = delete;
  PostgresCluster& operator=(const PostgresCluster&) = delete;

  // Returns the URL of a database of the superuser "cairn", which need not exist.
  std::string Url(const std::string& database, const std::string& user = "cairn") const;
  // Creates a database and returns its URL.
  std::string CreateDatabase(const std::string& name);
  void Execute(const std::string& database, const std::string& sql);

  void Kill();    // As a loss of power would.
  void Start();   // After Kill; returns once the server answers.
  void Freeze();  // Stops all its processes, with their connections open.
  void Thaw();

  const std::string& folder() const { return folder_; }

 private:
  // The server and the processes that it has started.
  std::vector<pid_t> Processes() const;

  std::string folder_;
  pid_t server_ = -1;
};

}  // namespace cairn::testing

#endif  // CAIRN_TESTS_SUPPORT_POSTGRES_CLUSTER_H_
