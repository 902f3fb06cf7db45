// Says when a map has outgrown its codebook.
#ifndef CAIRN_CLI_CODEBOOK_HINT_H_
#define CAIRN_CLI_CODEBOOK_HINT_H_

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "storage/map/map_store.h"

namespace cairn {

// Returns the name of the session whose descriptors trained the map's codebook: that of the first
// ingest. Returns nothing if the codebook is shipped, or if the versions do not tell: the first
// ones were pruned, or the map was recoded, merged, extracted or rolled back. `versions`: all,
// newest first, as of MapSnapshot::Versions.
std::optional<std::string> SessionThatTrained(const std::vector<VersionRecord>& versions,
                                              bool codebook_is_shipped);

// Returns the session whose descriptors would train a better codebook, or null. That is the session
// with the most landmarks, if it has kOutgrownFactor times the landmarks of the session that
// trained the codebook, or if the codebook is shipped and the session could train one. A session of
// the same size says nothing: the codes of all codebooks are equally good, and only how much the
// photos of the session differ decides (docs/decisions/0034-inliers-follow-the-radius.md).
inline constexpr int64_t kOutgrownFactor = 2;
const SessionRecord* SessionToTrainOn(const std::vector<SessionRecord>& sessions,
                                      const std::optional<std::string>& trained_on,
                                      bool codebook_is_shipped);

// What `session` would do for the map at `map_path`, and the commands, for people.
std::string RecodeHint(const SessionRecord& session, const std::string& map_path);

}  // namespace cairn

#endif  // CAIRN_CLI_CODEBOOK_HINT_H_
