// Queries the map about frames and applies its answers to the filter.
#ifndef CAIRN_FUSION_ESTIMATOR_MAP_ANSWERS_H_
#define CAIRN_FUSION_ESTIMATOR_MAP_ANSWERS_H_

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "core/rigid3.h"
#include "fusion/estimator/answer_box.h"
#include "fusion/estimator/fusion_options.h"
#include "fusion/estimator/fusion_types.h"
#include "fusion/estimator/query_schedule.h"
#include "fusion/filter/filter_state.h"
#include "fusion/map_updates/alignment_candidates.h"
#include "fusion/map_updates/contradictions.h"
#include "fusion/map_updates/match_updates.h"
#include "fusion/tracks/track_table.h"

namespace cairn::fusion {

// Counts the alignments that the answers of one frame started and ended.
struct AlignmentCounts {
  int num_alignments = 0;
  int num_realignments = 0;  // Alignments that contradictions ended.
};

// QuerySchedule decides when a frame is queried, and AnswerBox holds the answers until the next
// frame. Before the alignment, answers wait until enough of them agree (AlignmentCandidates).
// Afterwards, each answer updates the state (MatchUpdates) or contradicts it (Contradictions).
// Until the answer to a query has been applied or given up, the observations of the queried frame
// stay reserved in the TrackTable, and the frame's clone must stay in the state. Not thread-safe,
// but for Submit.
class MapAnswers {
 public:
  explicit MapAnswers(const FusionOptions& options);

  // Returns a query of the newest clone of `state` if a query is due, and reserves the frame's
  // observations.
  std::optional<Query> Poll(const FilterState& state, TrackTable* tracks);

  // May be called from any thread.
  SubmitStatus Submit(Answer answer) { return box_.Submit(std::move(answer)); }
  std::vector<AnswerReport> TakeReports() { return box_.TakeReports(); }

  // Ends the queries that have timed out, then applies and reports all waiting answers. `now_ns` is
  // the time of `state`.
  AlignmentCounts TakeUp(int64_t now_ns, FilterState* state, TrackTable* tracks);

  // Returns whether the clone of this frame must stay, because an answer about it is pending or
  // waits for the alignment.
  bool NeedsFrame(int64_t frame_id) const;

  // Returns whether answers wait for the alignment.
  bool awaits_alignment() const { return !candidates_.empty(); }

  // Time of the frame that last applied an answer; nothing unless the state is aligned.
  std::optional<int64_t> last_applied_ns() const { return last_applied_ns_; }

  // To be called when the state and the tracks no longer exist. Waiting answers stay, so that they
  // are reported.
  void Restart();

 private:
  // The state that an answer changes.
  struct Target {
    int64_t now_ns;
    FilterState* state;
    TrackTable* tracks;
  };

  AnswerReport TakeUpOne(const Answer& answer, int64_t frame_id, const Target& target,
                         AlignmentCounts* counts);
  // Applies an answer to an aligned state. `level` is the global_from_local that the answer
  // implies.
  AnswerReport Apply(const Answer& answer, int64_t frame_id, const Rigid3d& level,
                     const Target& target, AlignmentCounts* counts);
  // Adds a candidate, and aligns if enough candidates agree.
  AnswerOutcome AwaitAlignment(AlignmentCandidate candidate, const Target& target,
                               AlignmentCounts* counts);
  // Aligns by the candidates if enough of them agree. Returns whether it did.
  bool TryAlign(const Target& target);
  void ForgetAlignment(const Target& target);

  QuerySchedule queries_;
  AnswerBox box_;
  AlignmentCandidates candidates_;
  Contradictions contradictions_;
  MatchUpdates updates_;
  std::optional<int64_t> last_applied_ns_;
};

}  // namespace cairn::fusion

#endif  // CAIRN_FUSION_ESTIMATOR_MAP_ANSWERS_H_
