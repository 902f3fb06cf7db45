// A PostgreSQL server of a test's own, thrown away at its end.
#ifndef CAIRN_TESTS_SUPPORT_POSTGRES_CLUSTER_H_
#define CAIRN_TESTS_SUPPORT_POSTGRES_CLUSTER_H_

#include <sys/types.h>

#include <memory>
#include <string>
#include <vector>

namespace cairn::testing {

// Runs as the user nobody if the test runs as root, because PostgreSQL refuses to. Listens on a
// socket in a temporary folder, and on a port of 127.0.0.1 if it has rules for one. The server ends
// with the test, however the test ends.
class PostgresCluster {
 public:
  // Returns why there can be no server here; empty if there can be one.
  static std::string WhyNot();
  // Returns the server that all tests of this process share. Starts it at the first call. Its
  // databases have PostGIS.
  static PostgresCluster& Shared();

  // `host_rules` are lines of pg_hba.conf for clients on 127.0.0.1.
  explicit PostgresCluster(const std::string& host_rules = "");
  ~PostgresCluster();
  PostgresCluster(const PostgresCluster&) = delete;
  PostgresCluster& operator=(const PostgresCluster&) = delete;

  // Returns the URL of a database of the superuser "cairn", which need not exist.
  std::string Url(const std::string& database, const std::string& user = "cairn") const;
  // Returns the same by way of 127.0.0.1. There must be rules.
  std::string HostUrl(const std::string& database, const std::string& user) const;
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
  int port_ = 0;  // On 127.0.0.1; 0 if the server does not listen there.
  pid_t server_ = -1;
};

}  // namespace cairn::testing

#endif  // CAIRN_TESTS_SUPPORT_POSTGRES_CLUSTER_H_
