// The answers that the places of a map give to a query without a prior.
#ifndef CAIRN_ENGINE_PLACE_ANSWERS_H_
#define CAIRN_ENGINE_PLACE_ANSWERS_H_

#include <set>
#include <vector>

#include "engine/localizer_options.h"
#include "engine/query/localize_result.h"

namespace cairn {

class PlaceAnswers {
 public:
  // `options` must outlive the object.
  explicit PlaceAnswers(const LocalizerOptions* options) : options_(*options) {}

  bool empty() const { return answers_.empty(); }

  // Adds the answer of a place with this many votes (RankedPlace::score). Places are added in the
  // order of their votes.
  void Add(double num_votes, LocalizeResult answer);

  // Returns true if no place with `next_num_votes` or less needs to be searched: the deadline has
  // passed, or an answer has PlacesOptions::convincing_confidence and its place far more votes.
  // Where streets look alike, the other street has about as many, and its answer must be heard.
  bool AreEnough(double next_num_votes) const;

  // Returns the answer with the highest score. The result is AMBIGUOUS if the answer of another
  // place rivals it (AnswerOptions::ambiguous_score_ratio), and has the reason of the place that
  // came nearest to an answer if no place has one. The counters of the tiles and the times are
  // those of all places. There must be an answer.
  LocalizeResult Best() const;

 private:
  const LocalizerOptions& options_;
  std::vector<LocalizeResult> answers_;
  double convincing_num_votes_ = -1.0;  // Of the first convincing answer; negative: there is none.
  bool timed_out_ = false;
  std::set<TileId> tiles_;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_PLACE_ANSWERS_H_
