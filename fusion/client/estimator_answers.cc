// The part of Estimator that asks the map and takes up its answers.
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "fusion/client/estimator.h"
#include "fusion/client/pose_covariance.h"
#include "fusion/map_updates/alignment.h"
#include "fusion/tracks/track_update.h"

namespace cairn::fusion {
namespace {

constexpr size_t kMaxReports = 64;
constexpr size_t kMaxGivenUp = 64;
constexpr size_t kMaxCandidates = 5;
constexpr size_t kMaxContradictions = 16;

double Seconds(int64_t duration_ns) { return 1e-9 * static_cast<double>(duration_ns); }

bool IsFinite(const Answer& answer) {
  const Rigid3d& pose = answer.global_from_cam;
  return pose.rotation.coeffs().allFinite() && pose.translation.allFinite() &&
         std::abs(pose.rotation.norm() - 1.0) < 1e-3 &&
         std::all_of(answer.matches.begin(), answer.matches.end(), [](const MapMatch& match) {
           return match.pixel.allFinite() && match.x_in_global.allFinite() &&
                  std::isfinite(match.sigma_m) && match.sigma_m >= 0.0;
         });
}

// Of yaw and position of the newest clone's camera in global.
Eigen::Matrix4d PlaceCovariance(const FilterState& state) {
  const int newest = static_cast<int>(state.clones().size()) - 1;
  return CameraPrior(state, newest).covariance.bottomRightCorner<4, 4>();
}

}  // namespace

std::optional<Query> Estimator::PollQuery() {
  if (!state_ || state_->clones().empty() ||
      pending_.size() >= static_cast<size_t>(options_.query.max_pending)) {
    return std::nullopt;
  }
  const Clone& clone = state_->clones().back();
  if (last_query_ns_ &&
      Seconds(clone.timestamp_ns - *last_query_ns_) < options_.query.min_interval_s) {
    return std::nullopt;
  }
  Query query;
  for (const Track& track : tracks_.tracks()) {
    if (!track.observations.empty() && track.observations.back().frame_id == clone.frame_id) {
      query.features.push_back({track.track_id, track.observations.back().pixel});
    }
  }
  if (static_cast<int>(query.features.size()) < options_.query.min_features) {
    return std::nullopt;
  }
  query.query_id = next_query_id_++;
  query.timestamp_ns = clone.timestamp_ns;
  const Eigen::Quaterniond cam_from_local =
      state_->rig().cam_from_imu.rotation * clone.local_from_imu.rotation.conjugate();
  query.down_in_cam = cam_from_local * -Eigen::Vector3d::UnitZ();
  const int offset = state_->CloneIdx(static_cast<int>(state_->clones().size()) - 1);
  query.down_sigma_rad = std::sqrt(state_->covariance().diagonal().segment<2>(offset).maxCoeff());
  if (state_->global_from_local()) {
    query.prior = CameraPrior(*state_, static_cast<int>(state_->clones().size()) - 1);
  }
  pending_.push_back({query.query_id, clone.frame_id, clone.timestamp_ns});
  tracks_.SetReserved(clone.frame_id, true);
  last_query_ns_ = clone.timestamp_ns;
  return query;
}

SubmitStatus Estimator::Submit(Answer answer) {
  if (!has_room_for_answer()) {
    return SubmitStatus::kQueueFull;
  }
  inbox_.push_back(std::move(answer));
  return SubmitStatus::kQueued;
}

std::vector<AnswerReport> Estimator::TakeReports() {
  std::vector<AnswerReport> reports(reports_.begin(), reports_.end());
  reports_.clear();
  return reports;
}

void Estimator::Report(const AnswerReport& report) {
  if (reports_.size() == kMaxReports) {
    reports_.pop_front();
  }
  reports_.push_back(report);
}

void Estimator::ExpireQueries() {
  std::erase_if(pending_, [this](const PendingQuery& query) {
    if (Seconds(filter_time_ns_ - query.timestamp_ns) <= options_.query.timeout_s) {
      return false;
    }
    tracks_.SetReserved(query.frame_id, false);
    given_up_.push_back(query.query_id);
    return true;
  });
  if (given_up_.size() > kMaxGivenUp) {
    given_up_.erase(given_up_.begin(), given_up_.end() - kMaxGivenUp);
  }
}

void Estimator::ProcessAnswers() {
  // In the order of the queries, so that the order of arrival since the last frame does not matter.
  std::stable_sort(inbox_.begin(), inbox_.end(),
                   [](const Answer& a, const Answer& b) { return a.query_id < b.query_id; });
  for (const Answer& answer : inbox_) {
    const auto query = std::find_if(
        pending_.begin(), pending_.end(),
        [&answer](const PendingQuery& pending) { return pending.query_id == answer.query_id; });
    if (query == pending_.end()) {
      const bool gone =
          std::find(given_up_.begin(), given_up_.end(), answer.query_id) != given_up_.end();
      Report({answer.query_id, gone ? AnswerOutcome::kCloneGone : AnswerOutcome::kUnknownQuery, 0});
      continue;
    }
    const int64_t frame_id = query->frame_id;
    pending_.erase(query);
    const AnswerReport report = ProcessAnswer(answer, frame_id);
    if (report.outcome != AnswerOutcome::kAwaitsAlignment) {
      tracks_.SetReserved(frame_id, false);
    }
    Report(report);
  }
  inbox_.clear();
}

AnswerReport Estimator::ProcessAnswer(const Answer& answer, int64_t frame_id) {
  if (!answer.localized) {
    return {answer.query_id, AnswerOutcome::kNotLocalized, 0};
  }
  if (!IsFinite(answer)) {
    return {answer.query_id, AnswerOutcome::kBadInput, 0};
  }
  if (static_cast<int>(answer.matches.size()) < options_.map.min_matches) {
    return {answer.query_id, AnswerOutcome::kTooFewMatches, 0};
  }
  const Rigid3d& local_from_imu =
      state_->clones()[static_cast<size_t>(FindClone(*state_, frame_id))].local_from_imu;
  const Rigid3d global_from_local =
      answer.global_from_cam * state_->rig().cam_from_imu * local_from_imu.Inverse();
  const LevelTransform candidate = Level(global_from_local, local_from_imu.translation);
  if (candidate.tilt_rad > options_.alignment.max_tilt_rad) {
    return {answer.query_id, AnswerOutcome::kGravityMismatch, 0};
  }
  if (state_->global_from_local()) {
    return Apply(answer, frame_id, candidate.level);
  }
  return {answer.query_id, AwaitAlignment(answer, frame_id, candidate.level), 0};
}

void Estimator::LedgerSights::Add(const MapSight& sight, const MapMatch& match) {
  sights.push_back(sight);
  track_ids.push_back(match.track_id);
  landmark_ids.push_back(match.landmark_id);
}

void Estimator::AppendSights(const std::vector<MapMatch>& matches, int64_t frame_id,
                             LedgerSights* sights) {
  int match_idx = 0;
  for (const MapMatch& match : matches) {
    MapSight sight{match_idx,     FindClone(*state_, frame_id),
                   match.pixel,   match.x_in_global,
                   match.sigma_m, match.tile_id};
    sight.sigma_m *= std::sqrt(landmark_uses_.VarianceFactor(match.landmark_id));
    if (!match.track_id) {
      sights->Add(sight, match);
    } else if (const Track* track = tracks_.Find(*match.track_id)) {
      AppendTrack(*track, match, frame_id, sight, sights);
    }
    ++match_idx;
  }
}

void Estimator::AppendTrack(const Track& track, const MapMatch& match, int64_t frame_id,
                            MapSight sight, LedgerSights* sights) const {
  const auto queried = std::find_if(
      track.observations.begin(), track.observations.end(),
      [frame_id](const Observation& observation) { return observation.frame_id == frame_id; });
  if (queried == track.observations.end()) {
    return;  // It has been used.
  }
  const auto is_free = [&](const Observation& observation) {
    return !observation.reserved && observation.frame_id != frame_id &&
           FindClone(*state_, observation.frame_id) >= 0;
  };
  const auto num_others =
      std::count_if(track.observations.begin(), track.observations.end(), is_free);
  const double factor = std::sqrt(static_cast<double>(1 + num_others));
  const bool takes_others = LandmarkNoisePx(sight) * factor < options_.map.sigma_px;
  sight.pixel = queried->pixel;
  sight.sigma_m *= takes_others ? factor : 1.0;
  sights->Add(sight, match);
  for (const Observation& observation : track.observations) {
    if (takes_others && is_free(observation)) {
      sight.clone = FindClone(*state_, observation.frame_id);
      sight.pixel = observation.pixel;
      sights->Add(sight, match);
    }
  }
}

double Estimator::LandmarkNoisePx(const MapSight& sight) const {
  const auto& global_from_local = state_->global_from_local();
  if (!global_from_local) {
    return std::numeric_limits<double>::infinity();
  }
  const Rigid3d& local_from_imu = state_->clones()[static_cast<size_t>(sight.clone)].local_from_imu;
  const double distance_m =
      (*global_from_local * local_from_imu.translation - sight.x_in_global).norm();
  return options_.camera.focal_px() * sight.sigma_m / distance_m;
}

void Estimator::TakeOut(const LedgerSights& sights, const std::vector<bool>& used) {
  int last_match = -1;
  for (size_t i = 0; i < sights.sights.size(); ++i) {
    if (!used[i]) {
      continue;
    }
    Track* track = sights.track_ids[i] ? tracks_.Find(*sights.track_ids[i]) : nullptr;
    if (sights.sights[i].match != last_match) {
      last_match = sights.sights[i].match;
      landmark_uses_.Add(sights.landmark_ids[i]);
      const bool alone = i + 1 == sights.sights.size() || sights.sights[i + 1].match != last_match;
      if (track != nullptr && alone) {
        NoteDistance(sights.sights[i], track);
      }
    }
    if (track != nullptr) {
      const int64_t frame_id =
          state_->clones()[static_cast<size_t>(sights.sights[i].clone)].frame_id;
      std::erase_if(track->observations, [frame_id](const Observation& observation) {
        return observation.frame_id == frame_id;
      });
    }
  }
}

void Estimator::NoteDistance(const MapSight& sight, Track* track) const {
  if (track->map_distance || !(sight.sigma_m > 0.0)) {
    return;
  }
  const Eigen::Vector3d center_in_local =
      CameraView(state_->rig(), state_->clones()[static_cast<size_t>(sight.clone)]).center_in_local;
  const Eigen::Vector3d ray = sight.x_in_global - *state_->global_from_local() * center_in_local;
  track->map_distance = {sight.x_in_global, ray.normalized(), sight.sigma_m, sight.tile_id};
}

void Estimator::ForgetUses() {
  // Of each direction's information, the mean share that is left.
  const Eigen::Matrix4d now = PlaceCovariance(*state_);
  landmark_uses_.Forget(std::clamp(now.ldlt().solve(known_of_place_).trace() / 4.0, 0.0, 1.0));
}

MapUpdateResult Estimator::UpdateFromMatches(const std::vector<MapMatch>& matches,
                                             int64_t frame_id) {
  ForgetUses();
  LedgerSights sights;
  AppendSights(matches, frame_id, &sights);
  MapUpdateResult result =
      UpdateFromMap(options_.camera, sights.sights, options_.map, state_.get());
  if (result.status == MapUpdateStatus::kApplied) {
    TakeOut(sights, result.used_sights);
  }
  known_of_place_ = PlaceCovariance(*state_);
  return result;
}

AnswerReport Estimator::Apply(const Answer& answer, int64_t frame_id, const Rigid3d& candidate) {
  const MapUpdateResult result = UpdateFromMatches(answer.matches, frame_id);
  if (result.status == MapUpdateStatus::kApplied) {
    last_applied_ns_ = filter_time_ns_;
    contradictions_.clear();
    return {answer.query_id, AnswerOutcome::kApplied, result.num_matches};
  }
  if (result.status == MapUpdateStatus::kTooFewMatches) {
    return {answer.query_id, AnswerOutcome::kTooFewMatches, 0};
  }
  NoteContradiction(frame_id, candidate);
  return {answer.query_id, AnswerOutcome::kDisagrees, 0};
}

void Estimator::NoteContradiction(int64_t frame_id, const Rigid3d& candidate) {
  const int clone = FindClone(*state_, frame_id);
  contradictions_.push_back({state_->clones()[static_cast<size_t>(clone)].timestamp_ns, candidate});
  if (contradictions_.size() > kMaxContradictions) {
    contradictions_.erase(contradictions_.begin());
  }
  const Eigen::Vector3d position = state_->imu().local_from_imu.translation;
  // Those before the last one that disagrees with the newest do not count: in a row is in a row.
  const auto differs = [&](const Contradiction& contradiction) {
    return !Agree(contradiction.global_from_local, candidate, position, options_.alignment);
  };
  const auto last_differing =
      std::find_if(contradictions_.rbegin(), contradictions_.rend(), differs);
  contradictions_.erase(contradictions_.begin(), last_differing.base());
  const auto [oldest, newest] =
      std::minmax_element(contradictions_.begin(), contradictions_.end(),
                          [](const Contradiction& a, const Contradiction& b) {
                            return a.timestamp_ns < b.timestamp_ns;
                          });
  if (static_cast<int>(contradictions_.size()) >= options_.alignment.min_contradictions &&
      Seconds(newest->timestamp_ns - oldest->timestamp_ns) >=
          options_.alignment.min_contradiction_span_s) {
    state_->ForgetGlobal();
    for (Track& track : tracks_.tracks()) {
      track.map_distance.reset();
    }
    landmark_uses_.Clear();
    contradictions_.clear();
    last_applied_ns_.reset();
    ++counters_.num_realignments;
  }
}

AnswerOutcome Estimator::AwaitAlignment(const Answer& answer, int64_t frame_id,
                                        const Rigid3d& candidate) {
  if (candidates_.size() == kMaxCandidates) {
    ReleaseCandidates(1);
  }
  candidates_.push_back({frame_id, candidate, answer.matches});
  TryAlign();
  return state_->global_from_local() ? AnswerOutcome::kApplied : AnswerOutcome::kAwaitsAlignment;
}

void Estimator::TryAlign() {
  std::vector<Rigid3d> poses;
  for (const Candidate& candidate : candidates_) {
    poses.push_back(candidate.global_from_local);
  }
  const std::vector<int> agreeing =
      LargestAgreeingSet(poses, state_->imu().local_from_imu.translation, options_.alignment);
  if (static_cast<int>(agreeing.size()) < options_.alignment.min_agreeing) {
    return;
  }
  // One frame alone first: global_from_local takes up all the drift of its clone, so that the
  // clones' errors cannot pass for wrong matches. The other answers follow as updates, gated by all
  // that is then known.
  const auto newest = static_cast<size_t>(agreeing.back());
  LedgerSights sights;
  AppendSights(candidates_[newest].matches, candidates_[newest].frame_id, &sights);
  if (!Align(options_.camera, sights.sights, poses[newest], options_.map, state_.get())) {
    return;
  }
  TakeOut(sights, std::vector<bool>(sights.sights.size(), true));
  known_of_place_ = PlaceCovariance(*state_);
  for (auto other = agreeing.rbegin() + 1; other != agreeing.rend(); ++other) {
    const Candidate& candidate = candidates_[static_cast<size_t>(*other)];
    UpdateFromMatches(candidate.matches, candidate.frame_id);
  }
  ReleaseCandidates(candidates_.size());
  last_applied_ns_ = filter_time_ns_;
  ++counters_.num_alignments;
}

void Estimator::ReleaseCandidates(size_t num_oldest) {
  for (size_t i = 0; i < num_oldest; ++i) {
    tracks_.SetReserved(candidates_[i].frame_id, false);
  }
  candidates_.erase(candidates_.begin(),
                    candidates_.begin() + static_cast<std::ptrdiff_t>(num_oldest));
}

}  // namespace cairn::fusion
