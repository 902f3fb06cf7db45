#include "ingest/place/find_up.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/angles.h"
#include "core/rotation_between.h"

namespace cairn {
namespace {

constexpr double kSameStartRad = 10.0 * kRadPerDeg;
constexpr double kSameKindRad = 25.0 * kRadPerDeg;
// An error of up that nobody would overlook.
constexpr double kTurnedRad = 35.0 * kRadPerDeg;
constexpr double kStartsAroundLine = 24.0;
constexpr double kFirstStepRad = 6.0 * kRadPerDeg, kLastStepRad = 0.05 * kRadPerDeg;
constexpr int kMaxClimbingSteps = 200;
constexpr size_t kMaxViewsToStartFrom = 40, kMaxClimbs = 40;
// A camera that looks steeply down is too far from level for a climb.
constexpr double kSteepStartRad = -40.0 * kRadPerDeg;
// Odds beyond this are no more than words.
constexpr double kMaxLogOdds = 20.0;

struct Start {
  Eigen::Vector3d up_in_world;
  UpScore score;
};

bool IsNear(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double angle_rad) {
  return a.dot(b) > std::cos(angle_rad);
}

// The direction of which the line of the walk climbs as the positions say. Positions pin the slope
// of the line far better than cameras do.
Eigen::Vector3d AcrossTheLine(const UpEvidence& evidence, const Eigen::Vector3d& up_in_world) {
  const Eigen::Vector3d& line = evidence.line_in_world();
  const Eigen::Vector3d across = up_in_world - up_in_world.dot(line) * line;
  if (across.norm() < 0.1) {
    return up_in_world;
  }
  const double climb_sine = (evidence.loose_enu_from_world().rotation * line).z();
  return std::sqrt(std::max(0.0, 1.0 - climb_sine * climb_sine)) * across.normalized() +
         climb_sine * line;
}

// Up in a camera that is held so and looks up by the pitch.
Eigen::Vector3d PitchedUpInCam(PictureUp up, double pitch_rad) {
  return std::cos(pitch_rad) * UpInCam(up) + std::sin(pitch_rad) * Eigen::Vector3d::UnitZ();
}

std::vector<Start> Starts(const UpEvidence& evidence) {
  std::vector<Start> starts;
  const auto add = [&](const Eigen::Vector3d& up_in_world) {
    const bool is_known = std::any_of(starts.begin(), starts.end(), [&](const Start& known) {
      return IsNear(known.up_in_world, up_in_world, kSameStartRad);
    });
    if (!is_known) {
      starts.push_back({up_in_world, evidence.Score(up_in_world)});
    }
  };
  const Eigen::Quaterniond world_from_enu = evidence.loose_enu_from_world().rotation.conjugate();
  const Eigen::Vector3d loose_up = world_from_enu * Eigen::Vector3d::UnitZ();
  add(loose_up);
  for (double i = 1.0; i < kStartsAroundLine; i += 1.0) {
    add(Eigen::AngleAxisd(2.0 * kPi * i / kStartsAroundLine, evidence.line_in_world()) * loose_up);
  }
  const std::vector<UpView>& views = evidence.problem().views;
  const size_t stride = std::max<size_t>(1, views.size() / kMaxViewsToStartFrom);
  for (size_t i = 0; i < views.size(); i += stride) {
    const Eigen::Quaterniond world_from_cam = views[i].cam_from_world.conjugate();
    for (const PictureUp up : kPictureUps) {
      const Eigen::Vector3d up_in_world = world_from_cam * UpInCam(up);
      add(up_in_world);
      add(AcrossTheLine(evidence, up_in_world));
      if (up != PictureUp::kBack) {
        add(world_from_cam * PitchedUpInCam(up, kSteepStartRad));
      }
    }
    if (views[i].up_in_cam) {
      add(world_from_cam * *views[i].up_in_cam);
    }
  }
  return starts;
}

void SortByScore(std::vector<Start>* starts) {
  std::stable_sort(starts->begin(), starts->end(), [](const Start& a, const Start& b) {
    return a.score.Total() > b.score.Total();
  });
}

// Goes to the best of four neighbors until none is better, in ever smaller steps.
Start Climb(const UpEvidence& evidence, const Start& from) {
  Start best = from;
  double step_rad = kFirstStepRad;
  for (int i = 0; i < kMaxClimbingSteps && step_rad > kLastStepRad; ++i) {
    const Eigen::Quaterniond world_from_level =
        RotationBetween(Eigen::Vector3d::UnitZ(), best.up_in_world);
    Start next = best;
    for (int direction = 0; direction < 4; ++direction) {
      const double azimuth_rad = 0.5 * kPi * direction;
      const Eigen::Vector3d up_in_level(std::sin(step_rad) * std::cos(azimuth_rad),
                                        std::sin(step_rad) * std::sin(azimuth_rad),
                                        std::cos(step_rad));
      const Eigen::Vector3d up_in_world = (world_from_level * up_in_level).normalized();
      const UpScore score = evidence.Score(up_in_world);
      if (score.Total() > next.score.Total()) {
        next = {up_in_world, score};
      }
    }
    if (next.score.Total() > best.score.Total()) {
      best = next;
    } else {
      step_rad *= 0.5;
    }
  }
  return best;
}

}  // namespace

double UpChoice::Odds() const {
  return std::exp(std::min(score.Total() - next_score.Total(), kMaxLogOdds));
}

UpChoice FindUp(const UpEvidence& evidence) {
  std::vector<Start> tops = Starts(evidence);
  SortByScore(&tops);
  tops.resize(std::min(tops.size(), kMaxClimbs));
  for (Start& top : tops) {
    top = Climb(evidence, top);
  }
  SortByScore(&tops);
  UpChoice choice;
  choice.up_in_world = tops[0].up_in_world;
  choice.score = tops[0].score;
  // Positions on a line leave directions about it that no climb ends at, and that may be as likely.
  for (const double angle_rad : {-kTurnedRad, kTurnedRad}) {
    const Eigen::Vector3d turned =
        Eigen::AngleAxisd(angle_rad, evidence.line_in_world()) * choice.up_in_world;
    tops.push_back({turned, evidence.Score(turned)});
  }
  SortByScore(&tops);
  // Up and down are of different kinds, and at least one start is far from any direction.
  for (const Start& top : tops) {
    if (!IsNear(top.up_in_world, choice.up_in_world, kSameKindRad)) {
      choice.next_in_world = top.up_in_world;
      choice.next_score = top.score;
      return choice;
    }
  }
  choice.next_score.positions = choice.score.Total() - kMaxLogOdds;
  return choice;
}

}  // namespace cairn
