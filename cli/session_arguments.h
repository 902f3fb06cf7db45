// A session that `ingest` or `plan` shall add to a map.
#ifndef CAIRN_CLI_SESSION_ARGUMENTS_H_
#define CAIRN_CLI_SESSION_ARGUMENTS_H_

#include <string>

#include "cli/options/cairn_options.h"
#include "cli/reconstruction_arguments.h"

namespace CLI {
class App;
}  // namespace CLI

namespace cairn {

struct SessionArguments {
  std::string map_path;
  ReconstructionArguments reconstruction;
  std::string image_list_path;
  CairnOptions options;
  bool apart = false;
  bool force = false;
  double wait_s = 30.0;
  bool json = false;
};

// Adds MAP and all options but those of how the work is divided.
void AddSessionArguments(CLI::App* command, SessionArguments* arguments);

// Adds --up: which way is up in a reconstruction.
void AddUpOption(CLI::App* command, CairnOptions* options);

// Adds --wait: how long a command waits while another update of the map runs.
void AddWaitOption(CLI::App* command, double* wait_s);
std::chrono::milliseconds PatienceOf(double wait_s);

// Adds --force: publish although keyframes of the map lose their answers.
void AddForceFlag(CLI::App* command, bool* force);

// A reconstruction that is read and placed on Earth, and how it becomes a session.
struct PlacedReconstruction {
  Reconstruction reconstruction;
  Georegistration georegistration;
  IngestOptions options;
};

// Whether a name of the session was given.
bool HasSessionName(const SessionArguments& arguments);
// The name that was given, or that of the database's folder.
std::string SessionNameOf(const SessionArguments& arguments);

// Throws Error(kInvalidArgument) if the positions are unknown.
void RequirePositions(const SessionArguments& arguments);
PlacedReconstruction ReadSession(const SessionArguments& arguments);

}  // namespace cairn

#endif  // CAIRN_CLI_SESSION_ARGUMENTS_H_
