#include "lab/experiments/measure/link_judge.h"

#include <algorithm>
#include <cstddef>

namespace cairn {

void LinkJudge::Add(const CitySession& session, const IngestReport& report,
                    const std::unordered_set<uint64_t>& ids_in_map) {
  for (size_t i = 0; i < report.landmark_ids.size(); ++i) {
    const LandmarkId id = report.landmark_ids[i];
    if (id == LandmarkId{}) {
      continue;
    }
    const bool is_possible = known_views_.contains(session.views[i]);
    num_possible_ += is_possible ? 1 : 0;
    if (id < report.first_new_landmark) {
      const auto known = thing_of_id_.find(Value(id));
      const bool is_right = known != thing_of_id_.end() && known->second == session.things[i];
      ++num_linked_;
      num_false_ += is_right ? 0 : 1;
      num_found_ += is_right && is_possible ? 1 : 0;
    }
  }
  Remember(session, report);
  Forget(ids_in_map);
}

double LinkJudge::FalseShare() const {
  return static_cast<double>(num_false_) / static_cast<double>(std::max<int64_t>(1, num_linked_));
}

double LinkJudge::FoundShare() const {
  return static_cast<double>(num_found_) / static_cast<double>(std::max<int64_t>(1, num_possible_));
}

void LinkJudge::Remember(const CitySession& session, const IngestReport& report) {
  for (size_t i = 0; i < report.landmark_ids.size(); ++i) {
    const LandmarkId id = report.landmark_ids[i];
    if (id == LandmarkId{}) {
      continue;
    }
    if (id >= report.first_new_landmark) {
      thing_of_id_.emplace(Value(id), session.things[i]);
    }
    // The map has seen the view: in a landmark of its own, or in one that was linked rightly.
    if (const auto known = thing_of_id_.find(Value(id));
        known != thing_of_id_.end() && known->second == session.things[i]) {
      views_of_id_[Value(id)].insert(session.views[i]);
    }
  }
}

// Landmarks that the map has not taken, or has dropped, cannot be found again.
void LinkJudge::Forget(const std::unordered_set<uint64_t>& ids_in_map) {
  known_views_.clear();
  std::erase_if(views_of_id_, [&](const auto& entry) { return !ids_in_map.contains(entry.first); });
  for (const auto& [id, views] : views_of_id_) {
    known_views_.insert(views.begin(), views.end());
  }
}

}  // namespace cairn
