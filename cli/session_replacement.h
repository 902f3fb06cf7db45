// Keeps a session from replacing another one by accident.
#ifndef CAIRN_CLI_SESSION_REPLACEMENT_H_
#define CAIRN_CLI_SESSION_REPLACEMENT_H_

#include "cli/session_arguments.h"
#include "storage/map/map_store.h"

namespace cairn {

// Call it before the session is planned. Does nothing if the map has no session of this name.
//
// Tools put the database of every capture into a folder of the same name, and that name is the
// default for the session. So, if no name was given, throws Error(kConflict) unless most photos of
// the map's session have a photo of the same name in the new session that stands within 50 m. If
// the name was given, warns of a session that stands elsewhere.
void CheckReplacement(const MapSnapshot& map, const PlacedReconstruction& session,
                      bool name_was_given);

}  // namespace cairn

#endif  // CAIRN_CLI_SESSION_REPLACEMENT_H_
