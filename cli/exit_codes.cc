#include "cli/exit_codes.h"

namespace cairn {

ExitCode ExitCodeFor(ErrorCode code) {
  switch (code) {
    case ErrorCode::kInvalidArgument:
      return ExitCode::kUsage;
    case ErrorCode::kBadInput:
    case ErrorCode::kNotFound:
    case ErrorCode::kConflict:
      return ExitCode::kBadInput;
    case ErrorCode::kMapDamaged:
      return ExitCode::kMapDamaged;
    case ErrorCode::kIo:
      return ExitCode::kIo;
    case ErrorCode::kUnavailable:
      return ExitCode::kUnreachable;
    case ErrorCode::kInternal:
      return ExitCode::kInternal;
  }
  return ExitCode::kInternal;
}

}  // namespace cairn
