#include "mapping/growth/view_graph.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/rotation_between.h"
#include "mapping/growth/localize_photo.h"
#include "mapping/matching/pair_rays.h"
#include "mapping/matching/relative_pose.h"

namespace cairn {
namespace {

// A view whose direction is less certain does not tell a wrong pose from a right one.
constexpr double kMaxDirectionSigmaRad = 0.1;
// Views under a guessed focal length may differ by this factor more. If the guess is off by a
// sixth, a turn of 20 degrees is off by 3 degrees.
constexpr double kGuessTolerance = 2.5;
// The same for a focal length that the photos told, whose error is less than half of that.
constexpr double kPhotosTolerance = 1.5;

// Of the inliers of a right view, whose errors were found under other focal lengths, some leave; a
// wrong pose keeps those whose epipolar lines happen to point the right way.
constexpr double kMinShareThatFits = 0.7;

// The angle between a direction and the arc from `first` to `last`, all unit vectors.
double AngleToArc(const Eigen::Vector3d& direction, const Eigen::Vector3d& first,
                  const Eigen::Vector3d& last) {
  const double to_ends =
      std::min(AngleBetweenRad(direction, first), AngleBetweenRad(direction, last));
  const Eigen::Vector3d normal = first.cross(last);
  if (normal.norm() < 1e-9) {
    return to_ends;
  }
  const Eigen::Vector3d unit = normal.normalized();
  const Eigen::Vector3d in_plane = direction - unit * unit.dot(direction);
  const bool is_between =
      first.cross(in_plane).dot(unit) >= 0.0 && in_plane.cross(last).dot(unit) >= 0.0;
  return is_between ? std::asin(std::min(1.0, std::abs(unit.dot(direction)))) : to_ends;
}

// The view as seen from `from`: rotation from `from` to `to`, and the direction to the center of
// `to` in the frame of `from`.
struct Leg {
  Eigen::Quaterniond to_from_from;
  Eigen::Vector3d direction_in_from;
};

Leg LegOf(const TwoView& view, int from) {
  const Rigid3d to_from_from = view.a == from ? view.b_from_a : view.b_from_a.Inverse();
  return {to_from_from.rotation, to_from_from.Inverse().translation.normalized()};
}

// A photo and its view with the photo at hand.
struct Spoke {
  int photo;
  int view;
};

bool IsUncertain(const PhotoSet& set, int photo) {
  const FocalSource source = set.cameras[set.photos[photo].camera_idx].Certainty();
  return source == FocalSource::kGuess || source == FocalSource::kPhotos;
}

}  // namespace

ViewErrors CompareWithView(const TwoView& view, const Rigid3d& a_from_world,
                           const Rigid3d& b_from_world) {
  const Rigid3d b_from_a = b_from_world * a_from_world.Inverse();
  return {RotationAngleRad(b_from_a.rotation, view.b_from_a.rotation),
          AngleBetweenRad(b_from_a.translation, view.b_from_a.translation)};
}

ViewGraph::ViewGraph(const PhotoSet& set, std::span<const TwoView> views,
                     const GrowthOptions& options)
    : set_(set), views_(views), options_(options), views_of_photo_(set.photos.size()) {
  for (int i = 0; i < static_cast<int>(views.size()); ++i) {
    views_of_photo_[views[i].a].push_back(i);
    views_of_photo_[views[i].b].push_back(i);
  }
}

int ViewGraph::Find(int photo, int other) const {
  for (const int view : views_of_photo_[photo]) {
    if (OtherOf(view, photo) == other) {
      return view;
    }
  }
  return -1;
}

ViewTolerances ViewGraph::TolerancesOf(const TwoView& view) const {
  const auto factor_of = [&](int photo) {
    const FocalSource source = set_.cameras[set_.photos[photo].camera_idx].Certainty();
    return source == FocalSource::kGuess    ? kGuessTolerance
           : source == FocalSource::kPhotos ? kPhotosTolerance
                                            : 1.0;
  };
  const double factor = std::max(factor_of(view.a), factor_of(view.b));
  return {factor * std::max(options_.max_rotation_error_rad, 3.0 * view.rotation_sigma_rad),
          factor * std::max(options_.max_direction_error_rad, 3.0 * view.direction_sigma_rad)};
}

bool ViewGraph::CanTestify(const TwoView& view) const {
  return view.kind == TwoViewKind::kGeneral && view.direction_sigma_rad <= kMaxDirectionSigmaRad;
}

bool ViewGraph::IsGuessed(const TwoView& view) const {
  return IsUncertain(set_, view.a) || IsUncertain(set_, view.b);
}

bool ViewGraph::MostInliersFit(const TwoView& view, const Posed& a, const Posed& b) const {
  constexpr double kSlack = kMaxDraftSigmas / kMaxEpipolarSigmas;
  Rigid3d b_from_a = b.cam_from_world * a.cam_from_world.Inverse();
  b_from_a.translation.normalize();
  const PairRays rays = MakePairRays({set_.photos[view.a], a.camera, kSlack},
                                     {set_.photos[view.b], b.camera, kSlack}, view.inliers);
  const auto num_fit = RelativePoseProblem(rays.rays, 0).InliersOf(b_from_a).size();
  return static_cast<double>(num_fit) >
         kMinShareThatFits * static_cast<double>(view.inliers.size());
}

Testimony ViewGraph::Ask(int photo, const Posed& posed,
                         const std::function<std::optional<Posed>(int photo)>& posed_of) const {
  Testimony testimony;
  for (const int i : views_of_photo_[photo]) {
    const TwoView& view = views_[i];
    if (!CanTestify(view)) {
      continue;
    }
    const std::optional<Posed> other = posed_of(OtherOf(i, photo));
    if (!other) {
      continue;
    }
    const bool is_first = view.a == photo;
    if (Agrees(view, is_first ? posed : *other, is_first ? *other : posed)) {
      ++testimony.num_witnesses;
      testimony.agreeing_inliers += static_cast<int>(view.inliers.size());
    } else {
      testimony.contradicting_inliers += static_cast<int>(view.inliers.size());
    }
  }
  return testimony;
}

bool ViewGraph::Agrees(const TwoView& view, const Posed& a, const Posed& b) const {
  if (IsGuessed(view)) {
    return MostInliersFit(view, a, b);
  }
  const ViewErrors errors = CompareWithView(view, a.cam_from_world, b.cam_from_world);
  const ViewTolerances tolerances = TolerancesOf(view);
  return errors.rotation_rad <= tolerances.rotation_rad &&
         errors.direction_rad <= tolerances.direction_rad;
}

std::vector<Seed> FindSeeds(const ViewGraph& graph, int num_photos) {
  std::vector<Seed> seeds;
  for (int i = 0; i < num_photos; ++i) {
    std::vector<Spoke> spokes;
    for (const int view : graph.ViewsOf(i)) {
      if (graph.OtherOf(view, i) > i && graph.CanTestify(graph.View(view))) {
        spokes.push_back({graph.OtherOf(view, i), view});
      }
    }
    for (const Spoke& j : spokes) {
      for (const Spoke& k : spokes) {
        const int view_jk = j.photo < k.photo ? graph.Find(j.photo, k.photo) : -1;
        if (view_jk < 0 || !graph.CanTestify(graph.View(view_jk))) {
          continue;
        }
        const TwoView &ij = graph.View(j.view), &ik = graph.View(k.view);
        const TwoView& jk = graph.View(view_jk);
        const Leg leg_ij = LegOf(ij, i), leg_ik = LegOf(ik, i), leg_jk = LegOf(jk, j.photo);
        const Eigen::Quaterniond around =
            leg_ik.to_from_from.conjugate() * leg_jk.to_from_from * leg_ij.to_from_from;
        const Eigen::Vector3d j_to_k_in_i =
            leg_ij.to_from_from.conjugate() * leg_jk.direction_in_from;
        double max_turn = 0.0, max_bend = 0.0;
        for (const TwoView* view : {&ij, &ik, &jk}) {
          max_turn = std::max(max_turn, graph.TolerancesOf(*view).rotation_rad);
          max_bend = std::max(max_bend, graph.TolerancesOf(*view).direction_rad);
        }
        if (RotationAngleRad(around, Eigen::Quaterniond::Identity()) > max_turn ||
            AngleToArc(leg_ik.direction_in_from, leg_ij.direction_in_from, j_to_k_in_i) >
                max_bend) {
          continue;
        }
        Seed seed{j.view, k.photo, 0.0};
        double parallax = ij.parallax_rad;
        const auto consider = [&](const TwoView& view, int view_idx, int third) {
          if (view.parallax_rad > parallax) {
            parallax = view.parallax_rad;
            seed.base_view = view_idx;
            seed.third = third;
          }
        };
        consider(ik, k.view, j.photo);
        consider(jk, view_jk, i);
        seed.score = static_cast<double>(
                         std::min({ij.inliers.size(), ik.inliers.size(), jk.inliers.size()})) *
                     std::min(parallax, kEnoughParallaxRad);
        seeds.push_back(seed);
      }
    }
  }
  std::stable_sort(seeds.begin(), seeds.end(),
                   [](const Seed& p, const Seed& q) { return p.score > q.score; });
  return seeds;
}

}  // namespace cairn
