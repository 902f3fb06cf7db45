// The summary of a session or a map that joined a map, for `cairn ingest`, `cairn plan` and `cairn
// merge`.
#ifndef CAIRN_CLI_JOIN_SUMMARY_H_
#define CAIRN_CLI_JOIN_SUMMARY_H_

#include <nlohmann/json_fwd.hpp>

#include "ingest/adjust_session.h"
#include "ingest/place/ask_keyframes.h"
#include "ingest/place/compare_with_map.h"
#include "ingest/tile_changes.h"

namespace cairn {

// Prints what the map recognizes, unless nothing was to be recognized, and says if that is too
// little to judge the placement. `queries` names what was
// asked for: "photos" or "keyframes".
void PrintComparison(const MapComparison& comparison, const char* queries);

// Prints the adjustment of a session with the landmarks of the map; nothing if there was none.
void PrintAdjustment(const JointAdjustment& adjustment);

// Prints how many keyframes of the map were asked before the publication, and how many lost their
// answer; nothing if there were none.
void PrintAnswers(const KeyframeAnswers& answers);

// Prints what became of landmarks and keyframes.
void PrintChanges(const TileChanges& changes);

nlohmann::ordered_json ComparisonJson(const MapComparison& comparison);
nlohmann::ordered_json AdjustmentJson(const JointAdjustment& adjustment);
nlohmann::ordered_json AnswersJson(const KeyframeAnswers& answers);
nlohmann::ordered_json ChangesJson(const TileChanges& changes);

}  // namespace cairn

#endif  // CAIRN_CLI_JOIN_SUMMARY_H_
