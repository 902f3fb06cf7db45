#include "ingest/anchor/consistent_frames.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include "core/angles.h"
#include "ingest/anchor/bending.h"

namespace cairn {
namespace {

constexpr int kNumSeeds = 100;
constexpr int kNumFrames = 60;
constexpr double kStepM = 3.4;  // 200 m in all.

// A walk along a street that a map knows, with photos that look at the facade.
struct Walk {
  std::vector<PosePair> pairs;  // By the map: what it answers.
  std::vector<Rigid3d> in_map;  // The truth: cam_from_ecef.
  std::mt19937_64 random;

  double Normal(double sigma) { return sigma * std::normal_distribution<double>()(random); }
  Eigen::Vector3d Noise(double sigma) { return {Normal(sigma), Normal(sigma), Normal(sigma)}; }
  double Uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  }

  void Answer(size_t i, const Rigid3d& ecef_from_cam) {
    const Rigid3d noisy(ExpSo3(Noise(0.002)) * ecef_from_cam.rotation,
                        ecef_from_cam.translation + Noise(0.03));
    pairs[i].cam_from_ecef_in_map = noisy.Inverse();
    pairs[i].accuracy_m = 0.06;
    pairs[i].accuracy_rad = 0.004;
  }
  void AnswerShifted(size_t i, const Eigen::Vector3d& shift) {
    Rigid3d ecef_from_cam = in_map[i].Inverse();
    ecef_from_cam.translation += shift;
    Answer(i, ecef_from_cam);
  }
  // Keeps the photos of two ranges.
  void Keep(size_t begin, size_t end, size_t begin_2, size_t end_2) {
    const auto keep = [&](auto* of_photos) {
      of_photos->erase(of_photos->begin() + end_2, of_photos->end());
      of_photos->erase(of_photos->begin() + end, of_photos->begin() + begin_2);
      of_photos->erase(of_photos->begin(), of_photos->begin() + begin);
    };
    keep(&pairs);
    keep(&in_map);
  }
  void AnswerAnywhere(size_t i) {
    const Eigen::Vector3d turn(Uniform(-1, 1), Uniform(-1, 1), Uniform(-3, 3));
    Answer(i, {ExpSo3(turn), Eigen::Vector3d(Uniform(0, 200), Uniform(-50, 50), Uniform(-3, 3))});
  }
};

// All answers are right. The session is shifted by 3 m, turned by a degree and raised by 2 m, and
// drifts by 0.3 m in 100 m.
Walk WalkOf(int seed, int num_frames = kNumFrames, double step_m = kStepM) {
  Walk walk;
  walk.random.seed(static_cast<uint64_t>(seed));
  const Rigid3d session_from_map(ExpSo3(Eigen::Vector3d(0, 0, 0.017)), Eigen::Vector3d(2, -2, 2));
  Eigen::Vector3d drift = Eigen::Vector3d::Zero();
  for (int i = 0; i < num_frames; ++i) {
    const Rigid3d in_map(ExpSo3(Eigen::Vector3d(0.1, 0, 0.5 * std::sin(0.3 * i))),
                         Eigen::Vector3d(step_m * i, 2.0 * std::sin(0.1 * i), 1.6));
    drift += walk.Noise(0.3 * std::sqrt(step_m / 100.0));
    Rigid3d in_session = session_from_map * in_map;
    in_session.translation += drift;
    walk.in_map.push_back(in_map.Inverse());
    walk.pairs.push_back({in_session.Inverse(), Rigid3d()});
    walk.Answer(static_cast<size_t>(i), in_map);
  }
  return walk;
}

AnchorEvidence EvidenceOf(const Walk& walk, const ConsistentFrames& frames) {
  AnchorEvidence evidence;
  evidence.num_answers = static_cast<int>(walk.pairs.size());
  evidence.winner = frames.winner;
  evidence.rival = frames.rival;
  evidence.rival_is_apart = frames.rival_is_apart;
  std::vector<Rigid3d> poses;
  for (const PosePair& pair : walk.pairs) {
    poses.push_back(pair.cam_from_ecef);
  }
  evidence.session = {static_cast<int>(poses.size()), CountPlaces(poses, 2 * kIslandPlaces),
                      ExtentM(poses)};
  return evidence;
}

struct Verdict {
  bool is_anchored = false;
  double worst_m = 0.0;  // Of the frames that agree: the answer's distance from the truth.
};

Verdict Judge(const Walk& walk) {
  const ConsistentFrames frames = FindConsistentFrames(walk.pairs, {});
  Verdict verdict = {IsAnchored(EvidenceOf(walk, frames)), 0.0};
  for (size_t i = 0; i < walk.pairs.size(); ++i) {
    if (frames.agrees[i]) {
      verdict.worst_m =
          std::max(verdict.worst_m, (walk.pairs[i].cam_from_ecef_in_map.Inverse().translation -
                                     walk.in_map[i].Inverse().translation)
                                        .norm());
    }
  }
  return verdict;
}

// Returns in how many of the seeds the walk is anchored. None may be anchored by a wrong answer.
int CountAnchored(const std::function<void(Walk*)>& spoil, double step_m = kStepM) {
  int num_anchored = 0;
  for (int seed = 0; seed < kNumSeeds; ++seed) {
    Walk walk = WalkOf(seed, kNumFrames, step_m);
    spoil(&walk);
    const Verdict verdict = Judge(walk);
    num_anchored += verdict.is_anchored ? 1 : 0;
    EXPECT_TRUE(!verdict.is_anchored || verdict.worst_m < 1.0)
        << "seed " << seed << ": " << verdict.worst_m << " m";
  }
  return num_anchored;
}

TEST(ConsistentFrames, AgreeWhereTheSessionDriftsAndIsTurned) {
  EXPECT_EQ(CountAnchored([](Walk*) {}), kNumSeeds);
  EXPECT_GE(FindConsistentFrames(WalkOf(1).pairs, {}).winner.num_frames, kNumFrames - 3);
}

// Bends the session to and fro in waves of 120 m. What lies on a bend is turned with it, as in a
// model that was adjusted.
void Bend(double amplitude_m, Walk* walk) {
  const double radians_per_m = 2.0 * kPi / 120.0;
  const double phase_rad = walk->Uniform(0, 2.0 * kPi);
  for (PosePair& pair : walk->pairs) {
    const Rigid3d ecef_from_cam = pair.cam_from_ecef.Inverse();
    const double at_rad = radians_per_m * ecef_from_cam.translation.x() + phase_rad;
    const Eigen::Vector3d turn(0, 0, amplitude_m * radians_per_m * std::cos(at_rad));
    const Eigen::Vector3d shift(0, amplitude_m * std::sin(at_rad), 0);
    pair.cam_from_ecef =
        Rigid3d(ExpSo3(turn) * ecef_from_cam.rotation, ecef_from_cam.translation + shift).Inverse();
  }
}

TEST(ConsistentFrames, AgreeWhereTheSessionBendsAndTurns) {
  constexpr int kFewFrames = 30;  // 100 m.
  int num_anchored = 0;
  for (int seed = 0; seed < kNumSeeds; ++seed) {
    Walk walk = WalkOf(seed, kFewFrames);
    Bend(0.6, &walk);
    num_anchored += Judge(walk).is_anchored ? 1 : 0;
  }
  EXPECT_EQ(num_anchored, kNumSeeds);
}

TEST(ConsistentFrames, OutweighHalfWrongAnswers) {
  EXPECT_GE(CountAnchored([](Walk* walk) {
              for (size_t i = 0; i < walk->pairs.size(); i += 2) {
                walk->AnswerAnywhere(i);
              }
            }),
            95);
}

// Facades resemble others, here and there.
TEST(ConsistentFrames, OutweighWrongRunsThatAgreeWithThemselves) {
  EXPECT_GE(CountAnchored([](Walk* walk) {
              for (size_t first = 0; first < walk->pairs.size(); first += 10) {
                const double side = walk->Uniform(0, 1) < 0.5 ? 1.0 : -1.0;
                const Eigen::Vector3d shift(side * walk->Uniform(8, 40), walk->Uniform(-10, 10), 0);
                for (size_t i = first; i < first + 5; ++i) {
                  walk->AnswerShifted(i, shift);
                }
              }
            }),
            95);
}

constexpr double kWindowsM[] = {1.1, 1.5, 2.0, 3.0, 5.0};
const Eigen::Vector3d kDirections[] = {Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY()};

// As on facades with equal windows. Neither the drift nor the size of the session excuses it.
TEST(ConsistentFrames, OutweighRunsThatAreMovedByAWindow) {
  for (const double window_m : kWindowsM) {
    for (const Eigen::Vector3d& direction : kDirections) {
      const auto move = [&](size_t run, Walk* walk) {
        for (size_t first = 0; first < walk->pairs.size(); first += 10) {
          const double side = walk->Uniform(0, 1) < 0.5 ? 1.0 : -1.0;
          const double shift_m = side * window_m * walk->Uniform(1.0, 1.3);
          for (size_t i = first; i < first + run; ++i) {
            walk->AnswerShifted(i, shift_m * direction);
          }
        }
      };
      EXPECT_GE(CountAnchored([&](Walk* walk) { move(3, walk); }), 95) << window_m;
      CountAnchored([&](Walk* walk) { move(5, walk); });  // None by a wrong answer.
    }
  }
}

TEST(ConsistentFrames, AreNotAnchoredIfAThirdIsMovedByAWindow) {
  for (const double window_m : kWindowsM) {
    for (const Eigen::Vector3d& direction : kDirections) {
      EXPECT_EQ(CountAnchored([&](Walk* walk) {
                  for (size_t i = 0; i < 20; ++i) {
                    walk->AnswerShifted(i, window_m * direction);
                  }
                }),
                0)
          << window_m;
    }
  }
}

// The first third stands far from the last one: only photos at the seam contradict each other.
TEST(ConsistentFrames, AreNotAnchoredIfAThirdOfALongWalkIsMoved) {
  constexpr double kLongStepM = 10.0;
  for (const double shift_m : {1.5, 3.0, 5.0}) {
    EXPECT_EQ(CountAnchored(
                  [&](Walk* walk) {
                    for (size_t i = 0; i < 20; ++i) {
                      walk->AnswerShifted(i, {shift_m, 0, 0});
                    }
                  },
                  kLongStepM),
              0)
        << shift_m;
  }
}

// What lies beyond a gap does not tell the size of the session.
TEST(ConsistentFrames, AreNotAnchoredByARunThatIsMovedBeyondAGap) {
  for (const double gap_m : {20.0, 30.0}) {
    for (int seed = 0; seed < kNumSeeds; ++seed) {
      Walk walk = WalkOf(seed, 50, 2.0);
      const size_t after = 20 + static_cast<size_t>(gap_m / 2.0);
      for (size_t i = after; i < after + 10; ++i) {
        walk.AnswerShifted(i, {3, 0, 0});
      }
      walk.Keep(0, 20, after, after + 10);
      const Verdict verdict = Judge(walk);
      EXPECT_TRUE(!verdict.is_anchored || verdict.worst_m < 1.0)
          << gap_m << " m, seed " << seed << ": " << verdict.worst_m << " m";
    }
  }
}

// The second time around, each photo stands near one of the first time.
TEST(ConsistentFrames, OfALoopThatClosesAgree) {
  constexpr double kRadiusM = 32.0;
  int num_anchored = 0;
  for (int seed = 0; seed < kNumSeeds; ++seed) {
    Walk walk = WalkOf(seed);
    for (size_t i = 0; i < walk.pairs.size(); ++i) {
      const double angle_rad = 4.0 * kPi * static_cast<double>(i) / kNumFrames;
      Rigid3d pose = walk.in_map[i].Inverse();
      pose.translation = kRadiusM * Eigen::Vector3d(std::cos(angle_rad), std::sin(angle_rad), 0);
      walk.in_map[i] = pose.Inverse();
      walk.Answer(i, pose);
      pose.translation += Eigen::Vector3d(3, -2, 2) + walk.Noise(0.05);
      walk.pairs[i].cam_from_ecef = pose.Inverse();
    }
    num_anchored += Judge(walk).is_anchored ? 1 : 0;
  }
  EXPECT_EQ(num_anchored, kNumSeeds);
}

// Differences of positions that are noise tell no size.
TEST(ConsistentFrames, OfABurstAtOnePlaceAreNotAnchored) {
  for (int seed = 0; seed < kNumSeeds; ++seed) {
    Walk walk = WalkOf(seed, 10);
    Rigid3d place = walk.pairs[0].cam_from_ecef.Inverse();
    const Eigen::Vector3d center = place.translation;
    for (size_t i = 0; i < walk.pairs.size(); ++i) {
      place.translation = center + walk.Noise(0.05);
      walk.pairs[i].cam_from_ecef = place.Inverse();
      walk.in_map[i] = walk.in_map[0];
      walk.AnswerShifted(i, Eigen::Vector3d(30, 0, 0) + walk.Noise(0.2));
      walk.pairs[i].accuracy_m = 0.37;
    }
    EXPECT_FALSE(Judge(walk).is_anchored) << seed;
  }
}

// Three against two are no majority.
TEST(ConsistentFrames, OfASmallWalkAreNotAnchoredIfTwoContradictThree) {
  int num_anchored = 0;
  for (int seed = 0; seed < kNumSeeds; ++seed) {
    Walk walk = WalkOf(seed, 5);
    for (const size_t i : {0, 2, 4}) {
      walk.AnswerShifted(i, {1.5, 0, 0});
    }
    num_anchored += Judge(walk).is_anchored ? 1 : 0;
  }
  EXPECT_EQ(num_anchored, 0);
}

// A run of wrong answers has right ones next to it, and both are far from the others.
TEST(ConsistentFrames, FarFromTheOthersDoNotCountWhereTheyAreContested) {
  for (int seed = 0; seed < kNumSeeds; ++seed) {
    Walk walk = WalkOf(seed);
    for (size_t i = 0; i < 12; ++i) {
      walk.AnswerShifted(i, {1.8, 0, 0});
    }
    for (size_t i = 22; i < 40; ++i) {
      walk.AnswerAnywhere(i);
    }
    const Verdict verdict = Judge(walk);
    EXPECT_TRUE(!verdict.is_anchored || verdict.worst_m < 1.0) << seed << ": " << verdict.worst_m;
  }
}

// Whichever of the two is right: nobody can tell.
TEST(ConsistentFrames, AreNotAnchoredIfARunContradictsThem) {
  EXPECT_EQ(CountAnchored([](Walk* walk) {
              for (size_t i = 0; i < 25; ++i) {
                walk->AnswerShifted(i, {12, 0, 0});
              }
            }),
            0);
}

TEST(ConsistentFrames, AreNotAnchoredIfTheFirstPartStandsElsewhere) {
  EXPECT_EQ(CountAnchored([](Walk* walk) {
              for (size_t i = 0; i < 10; ++i) {
                walk->AnswerShifted(i, {0, 30, 0});
              }
              for (size_t i = 10; i < 30; ++i) {
                walk->AnswerAnywhere(i);
              }
            }),
            0);
}

TEST(ConsistentFrames, AreFewInAnotherTown) {
  EXPECT_EQ(CountAnchored([](Walk* walk) {
              for (size_t i = 0; i < walk->pairs.size(); ++i) {
                walk->AnswerAnywhere(i);
              }
            }),
            0);
}

// The other side of the street looks like this one in a mirror.
TEST(ConsistentFrames, AreFewInAMirror) {
  EXPECT_EQ(CountAnchored([](Walk* walk) {
              for (size_t i = 0; i < walk->pairs.size(); ++i) {
                const Rigid3d truth = walk->in_map[i].Inverse();
                const Eigen::Quaterniond turn(Eigen::AngleAxisd(3.14159, Eigen::Vector3d::UnitZ()));
                const Eigen::Vector3d& center = truth.translation;
                walk->Answer(i, {turn * truth.rotation,
                                 Eigen::Vector3d(center.x(), 20.0 - center.y(), center.z())});
              }
            }),
            0);
}

TEST(ConsistentFrames, CountOncePerPlace) {
  Walk walk = WalkOf(1);
  for (size_t i = 1; i < walk.pairs.size(); ++i) {
    walk.pairs[i] = walk.pairs[0];
    walk.in_map[i] = walk.in_map[0];
    walk.Answer(i, walk.in_map[0].Inverse());
  }
  EXPECT_EQ(FindConsistentFrames(walk.pairs, {}).winner.num_places, 1);
  EXPECT_FALSE(Judge(walk).is_anchored);
}

// A walk of eight photos needs half of them, not ten.
TEST(ConsistentFrames, OfASmallWalkNeedHalfOfItsPhotos) {
  Walk walk = WalkOf(1, 8);
  for (size_t i = 0; i < 3; ++i) {
    walk.AnswerAnywhere(i);
  }
  EXPECT_TRUE(Judge(walk).is_anchored);
  walk.AnswerAnywhere(3);
  walk.AnswerAnywhere(4);
  EXPECT_FALSE(Judge(walk).is_anchored);
}

TEST(ConsistentFrames, DoNotDependOnTheirOrder) {
  for (int seed = 0; seed < 10; ++seed) {
    Walk walk = WalkOf(seed);
    for (size_t i = 0; i < walk.pairs.size(); i += 3) {
      walk.AnswerAnywhere(i);
    }
    std::vector<PosePair> reversed(walk.pairs.rbegin(), walk.pairs.rend());
    std::vector<bool> agrees = FindConsistentFrames(reversed, {}).agrees;
    std::reverse(agrees.begin(), agrees.end());
    EXPECT_EQ(agrees, FindConsistentFrames(walk.pairs, {}).agrees);
  }
}

// Its positions, or those of a small map, err by meters.
TEST(ConsistentFrames, OfAShortWalkMayHaveAnotherSize) {
  Walk walk = WalkOf(1, 8);
  for (PosePair& pair : walk.pairs) {
    pair.cam_from_ecef = CamFromTarget(
        pair.cam_from_ecef, {1.2, Eigen::Quaterniond::Identity(), Eigen::Vector3d::Zero()});
  }
  EXPECT_EQ(FindConsistentFrames(walk.pairs, {}).winner.num_frames, 8);
  EXPECT_EQ(FindConsistentFrames(walk.pairs, {.scale_sigma = 0.2}).winner.num_frames, 8);
}

// A run of wrong answers far from all others is tied to them by the drift alone.
TEST(ConsistentFrames, FarFromTheOthersAnchorThemselvesOrDoNotCount) {
  Walk walk = WalkOf(1);
  for (size_t i = 26; i < 57; ++i) {
    walk.AnswerAnywhere(i);
  }
  for (size_t i = 57; i < 60; ++i) {
    walk.AnswerShifted(i, {1.5, 0, 0});
  }
  const ConsistentFrames frames = FindConsistentFrames(walk.pairs, {});
  EXPECT_FALSE(frames.agrees[57] || frames.agrees[58] || frames.agrees[59]);
  EXPECT_GE(frames.winner.num_frames, 25);
}

}  // namespace
}  // namespace cairn
