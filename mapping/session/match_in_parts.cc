#include "mapping/session/match_in_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "mapping/session/stage_codec.h"

namespace cairn {
namespace {

// Pairs whose two views are one file of the work folder: some seconds of work that a kill may cost.
constexpr size_t kPairsPerFile = 256;

}  // namespace

MatchedParts FindTwoViewsInParts(const PhotoSet& set, std::span<const std::pair<int, int>> pairs,
                                 const TwoViewOptions& options, const KeptParts& kept,
                                 const StepProgress& progress) {
  const int num_pairs = static_cast<int>(pairs.size());
  MatchedParts matched;
  matched.is_from_work = kept.work != nullptr;
  for (size_t first = 0; first < pairs.size(); first += kPairsPerFile) {
    const std::string name = fmt::format("{}-{:05}", kept.file, first / kPairsPerFile);
    std::vector<TwoView> part;
    const auto stored = kept.work ? kept.work->Load(name, kept.key) : std::nullopt;
    if (stored) {
      part = DecodeTwoViews(*stored, set, kept.work->PathOf(name));
    } else {
      matched.is_from_work = false;
      const size_t count = std::min(kPairsPerFile, pairs.size() - first);
      part = FindTwoViews(set, pairs.subspan(first, count), options, [&](int done, int) {
        progress(static_cast<int>(first) + done, num_pairs);
      });
      if (kept.work) {
        kept.work->Store(name, kept.key, EncodeTwoViews(part));
      }
    }
    std::move(part.begin(), part.end(), std::back_inserter(matched.views));
  }
  return matched;
}

}  // namespace cairn
