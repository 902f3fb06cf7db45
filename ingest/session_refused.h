// The error of a session that the map does not take.
#ifndef CAIRN_INGEST_SESSION_REFUSED_H_
#define CAIRN_INGEST_SESSION_REFUSED_H_

#include <string>

#include "core/error.h"

namespace cairn {

// An Error(kConflict) that is about this session: it contradicts the map, is not anchored, is in
// the map already, or would cost the map answers. Another session may join, and this one may, too,
// once the map has grown. Other conflicts, as an update by another program, are plain Errors.
class SessionRefused : public Error {
 public:
  explicit SessionRefused(const std::string& message) : Error(ErrorCode::kConflict, message) {}
};

}  // namespace cairn

#endif  // CAIRN_INGEST_SESSION_REFUSED_H_
