// What the shell sees when a command ends.
#ifndef CAIRN_CLI_EXIT_CODES_H_
#define CAIRN_CLI_EXIT_CODES_H_

#include "core/error.h"

namespace cairn {

enum class ExitCode : int {
  kOk = 0,
  kInternal = 1,      // A bug, or a library that misbehaved; also a demo that missed its mark.
  kUsage = 2,         // The command line makes no sense.
  kNotLocalized = 3,  // `cairn localize` got an answer without a pose.
  kBadInput = 4,     // A named file, session or value is missing, unusable or does not fit the map.
  kMapDamaged = 5,   // The map file fails its checks.
  kIo = 6,           // The operating system refused: disk full, permission, broken pipe.
  kUnreachable = 7,  // No server answers at the URL.
  kInterrupted = 130,  // SIGINT.
};

// The one table from error codes to exit codes.
ExitCode ExitCodeFor(ErrorCode code);

}  // namespace cairn

#endif  // CAIRN_CLI_EXIT_CODES_H_
