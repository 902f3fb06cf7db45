#include "mapping/pairs/find_pairs.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <mutex>
#include <set>
#include <tuple>

#include "core/error.h"
#include "core/parallel_for.h"
#include "core/printable.h"
#include "core/random.h"
#include "core/require.h"
#include "ingest/codebook/shipped_codebook.h"
#include "mapping/pairs/divide_polls.h"
#include "mapping/pairs/electorate.h"

namespace cairn {
namespace {

// A photo is served by partners that look like this share of its voters each: a pair that shares a
// tenth of its largest keypoints has far more matches than a two view needs.
constexpr double kAlikeShare = 0.1;

std::vector<std::pair<int, int>> AllPairs(int num_photos) {
  std::vector<std::pair<int, int>> pairs;
  for (int a = 0; a < num_photos; ++a) {
    for (int b = a + 1; b < num_photos; ++b) {
      pairs.emplace_back(a, b);
    }
  }
  return pairs;
}

// The codebook in which photos vote, and the matching of the pairs, are for these alone.
void RequireSift(const PhotoSet& set) {
  const std::shared_ptr<const Codebook> codebook = ShippedCodebook();
  for (const MappingPhoto& photo : set.photos) {
    if (!photo.keypoints.empty() && (set.descriptor_type != codebook->descriptor_type ||
                                     photo.descriptors.cols() != codebook->raw_dim())) {
      throw Error(
          ErrorCode::kBadInput,
          fmt::format("photo {} has {}-D descriptors of type '{}'; photos are paired by "
                      "{}-D ones of type '{}' alone",
                      Excerpt(photo.name), photo.descriptors.cols(), Excerpt(set.descriptor_type),
                      codebook->raw_dim(), codebook->descriptor_type));
    }
  }
}

// Takes photos out of the pool, all or `max_panel` from all over it. A fixed step would take all
// from one camera if several take turns.
std::vector<int> TakePanel(size_t max_panel, std::vector<int>* pool) {
  if (pool->size() <= max_panel) {
    return std::exchange(*pool, {});
  }
  std::vector<int> panel, rest;
  for (size_t i = 0; i < max_panel; ++i) {
    const size_t begin = i * pool->size() / max_panel, end = (i + 1) * pool->size() / max_panel;
    const size_t taken = begin + HashWord((*pool)[begin]) % (end - begin);
    for (size_t k = begin; k < end; ++k) {
      (k == taken ? panel : rest).push_back((*pool)[k]);
    }
  }
  *pool = std::move(rest);
  return panel;
}

// What the polls have found so far.
class Search {
 public:
  Search(const PhotoSet& set, const PairOptions& options,
         const std::function<void(int done, int total)>& progress)
      : options_(options),
        progress_(progress),
        voters_(set, options),
        whereabouts_(set, options),
        choices_(set.photos.size()),
        num_alike_(set.photos.size(), 0) {}

  void Run() {
    for (const Poll& poll : DividePolls(whereabouts_, static_cast<int>(choices_.size()))) {
      Ask(poll);
    }
  }

  std::vector<std::pair<int, int>> Pairs() const {
    std::set<std::pair<int, int>> pairs;
    for (int photo = 0; photo < static_cast<int>(choices_.size()); ++photo) {
      for (const Ballot& choice : choices_[photo]) {
        pairs.insert(std::minmax(photo, choice.photo));
      }
    }
    return {pairs.begin(), pairs.end()};
  }

 private:
  bool IsServed(int photo) const { return num_alike_[photo] >= options_.max_partners; }

  // Photos that are served neither ask nor are asked any more: who would choose them finds others.
  void Ask(const Poll& poll) {
    std::vector<int> asking = poll.photos, pool = poll.candidates;
    const bool has_panels = pool.size() > static_cast<size_t>(options_.max_panel);
    bool was_last = false;
    while (!asking.empty() && !pool.empty()) {
      const std::vector<int> panel = TakePanel(options_.max_panel, &pool);
      was_last = pool.empty();
      const Electorate electorate(voters_, panel, options_);
      ParallelFor(static_cast<int>(asking.size()), options_.num_threads, [&](int i) {
        Choose(electorate, has_panels, asking[i]);
        if (was_last || IsServed(asking[i])) {
          ReportOneDone();
        }
      });
      const auto is_served = [&](int photo) { return IsServed(photo); };
      std::erase_if(asking, is_served);
      std::erase_if(pool, is_served);
    }
    for (size_t i = 0; i < asking.size() && !was_last; ++i) {
      ReportOneDone();  // Nobody is left whom they could ask.
    }
  }

  // Keeps the photos with the most votes. Each voter has as many votes in each panel, whether the
  // panel shows the same or not, so those of several panels are ranked by what looks alike.
  void Choose(const Electorate& electorate, bool has_panels, int photo) {
    std::vector<Ballot>& choices = choices_[photo];
    for (const Ballot& ballot : electorate.VotesOf(photo, [&](int other) {
           return other != photo && whereabouts_.MayMeet(photo, other);
         })) {
      num_alike_[photo] += ballot.num_alike >= kAlikeShare * voters_.CountOf(photo) ? 1 : 0;
      choices.push_back(ballot);
    }
    const auto rank = [&](const Ballot& ballot) {
      return std::tuple(has_panels ? -ballot.num_alike : 0, -ballot.votes, ballot.photo);
    };
    std::sort(choices.begin(), choices.end(),
              [&](const Ballot& p, const Ballot& q) { return rank(p) < rank(q); });
    choices.resize(std::min<size_t>(choices.size(), options_.max_partners));
  }

  void ReportOneDone() {
    if (progress_) {
      const std::lock_guard lock(mutex_);
      progress_(++num_done_, static_cast<int>(choices_.size()));
    }
  }

  const PairOptions& options_;
  const std::function<void(int done, int total)>& progress_;
  const Voters voters_;
  const Whereabouts whereabouts_;
  std::vector<std::vector<Ballot>> choices_;  // Of each photo, most votes first.
  std::vector<int> num_alike_;                // Photos that look like kAlikeShare of a photo.
  std::mutex mutex_;
  int num_done_ = 0;
};

}  // namespace

void PairOptions::Validate() const {
  RequireWithin("pairs.max_partners", max_partners, 2, 1000);
  RequireWithin("pairs.max_exhaustive", max_exhaustive, 0, 1000);
  RequireWithin("pairs.max_voters", max_voters, 10, 100'000);
  RequireWithin("pairs.max_panel", max_panel, 10, 100'000);
  RequireWithin("pairs.neighbors_per_voter", neighbors_per_voter, 1, 100);
  RequireWithin("pairs.max_distance_m", max_distance_m, 0.0, 1e6);
  RequireWithin("pairs.default_accuracy_m", default_accuracy_m, 0.0, 1e6);
  RequireWithin("pairs.num_threads", num_threads, 1, 1024);
}

std::vector<std::pair<int, int>> FindPairs(
    const PhotoSet& set, const PairOptions& options,
    const std::function<void(int done, int total)>& progress) {
  options.Validate();
  RequireSift(set);
  const int num_photos = static_cast<int>(set.photos.size());
  if (num_photos <= options.max_exhaustive) {
    return AllPairs(num_photos);
  }
  Search search(set, options, progress);
  search.Run();
  return search.Pairs();
}

}  // namespace cairn
