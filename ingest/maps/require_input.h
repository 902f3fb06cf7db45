// The check that all readers of a plan's files use; private to ingest.
#ifndef CAIRN_INGEST_MAPS_REQUIRE_INPUT_H_
#define CAIRN_INGEST_MAPS_REQUIRE_INPUT_H_

#include "core/error.h"

namespace cairn {

// Throws Error(kBadInput) with the message `what` unless the condition holds.
inline void RequireInput(bool condition, const char* what) {
  if (!condition) {
    throw Error(ErrorCode::kBadInput, what);
  }
}

}  // namespace cairn

#endif  // CAIRN_INGEST_MAPS_REQUIRE_INPUT_H_
