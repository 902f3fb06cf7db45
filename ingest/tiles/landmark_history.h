// How long a landmark has been seen, and whether it still exists. Persistence filter after Rosen et
// al., "Towards lifelong feature-based mapping in semi-static environments" (ICRA 2016).
#ifndef CAIRN_INGEST_TILES_LANDMARK_HISTORY_H_
#define CAIRN_INGEST_TILES_LANDMARK_HISTORY_H_

#include <map>
#include <span>
#include <vector>

#include "storage/ids.h"
#include "storage/map/map_store.h"
#include "storage/tile/tile.h"

namespace cairn {

// When each session recorded its photos, years since any common origin.
using SessionTimes = std::map<SessionId, double>;

// By SessionRecord::recorded_at.
SessionTimes TimesOf(const std::vector<SessionRecord>& sessions);

// Adds the entry of the newest session, or the sum of sessions that are not in the history
// (session 0). A history that would exceed Tile::kMaxHistory adds its oldest session to the sum
// of all older ones.
void AppendToHistory(const HistoryEntry& entry, std::vector<HistoryEntry>* history);

struct PersistenceOptions {
  // The probability that a landmark disappears within a year: a compromise between posters,
  // shop fronts and facades.
  double loss_per_year = 0.1;
  // The least probability that a session misses a landmark that exists, however many chances the
  // session had: light, season and parked cars spoil all chances of a session together.
  double least_miss_share = 0.3;
};

// Returns the probability that a landmark exists at the time of its last entry, in [0, 1]. A
// observation sets the probability to 1. The probability then falls with time, and with each
// session that had chances and no observation. The probability of an observation at a chance is the
// landmark's own share of observations in chances until then.
double ExistenceProbability(std::span<const HistoryEntry> history, const SessionTimes& times,
                            const PersistenceOptions& options);

// Returns the number of observations that a future session of the same density can expect:
// existence probability x share of observations in chances x chances of a session.
double ExpectedObservations(std::span<const HistoryEntry> history, const SessionTimes& times,
                            const PersistenceOptions& options);

}  // namespace cairn

#endif  // CAIRN_INGEST_TILES_LANDMARK_HISTORY_H_
