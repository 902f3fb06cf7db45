#include "fusion/map_updates/alignment_candidates.h"

#include <algorithm>
#include <utility>

#include "fusion/map_updates/alignment.h"

namespace cairn::fusion {
namespace {

constexpr size_t kMaxCandidates = 5;  // Each keeps one clone and costs the filter its six columns.
// Number of answers that must agree before the filter accepts an alignment.
constexpr size_t kMinAgreeing = 3;

}  // namespace

bool AlignmentCandidates::HasFrame(int64_t frame_id) const {
  return std::any_of(
      candidates_.begin(), candidates_.end(),
      [frame_id](const AlignmentCandidate& candidate) { return candidate.frame_id == frame_id; });
}

std::optional<int64_t> AlignmentCandidates::Add(AlignmentCandidate candidate) {
  std::optional<int64_t> given_back;
  if (candidates_.size() == kMaxCandidates) {
    given_back = candidates_.front().frame_id;
    candidates_.erase(candidates_.begin());
  }
  candidates_.push_back(std::move(candidate));
  return given_back;
}

std::vector<const AlignmentCandidate*> AlignmentCandidates::Agreeing(
    const Eigen::Vector3d& x_in_local) const {
  std::vector<Rigid3d> poses;
  for (const AlignmentCandidate& candidate : candidates_) {
    poses.push_back(candidate.global_from_local);
  }
  std::vector<const AlignmentCandidate*> agreeing;
  for (const int i : LargestAgreeingSet(poses, x_in_local)) {
    agreeing.push_back(&candidates_[static_cast<size_t>(i)]);
  }
  if (agreeing.size() < kMinAgreeing) {
    agreeing.clear();
  }
  return agreeing;
}

std::vector<int64_t> AlignmentCandidates::Release() {
  std::vector<int64_t> frame_ids;
  for (const AlignmentCandidate& candidate : candidates_) {
    frame_ids.push_back(candidate.frame_id);
  }
  candidates_.clear();
  return frame_ids;
}

}  // namespace cairn::fusion
