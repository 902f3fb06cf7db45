// The exit codes of the commands.
#ifndef CAIRN_CLI_EXIT_CODES_H_
#define CAIRN_CLI_EXIT_CODES_H_

#include "core/error.h"

namespace cairn {

enum class ExitCode : int {
  kOk = 0,
  kInternal = 1,      // A bug, a failure of a library, or a demo below its target.
  kUsage = 2,         // The command line is invalid.
  kNotLocalized = 3,  // The answer to `cairn localize` has no pose.
  kBadInput = 4,    // A named file, session or value is missing, unusable or does not fit the map.
  kMapDamaged = 5,  // The map file, or an archived session, fails its checks.
  kIo = 6,  // The operating system refused an operation: disk full, permission, broken pipe.
  kUnreachable = 7,    // No server answers at the URL.
  kInterrupted = 130,  // SIGINT.
};

// Maps error codes to exit codes. No other code does.
ExitCode ExitCodeFor(ErrorCode code);

}  // namespace cairn

#endif  // CAIRN_CLI_EXIT_CODES_H_
