#include "mapping/matching/settle_planes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

#include "core/parallel_for.h"
#include "core/rotation_between.h"
#include "mapping/matching/pair_pose.h"
#include "mapping/matching/plane_pair.h"

namespace cairn {
namespace {

// A view shows a plane if this share of its inliers lies on it.
constexpr double kShareOnPlane = 0.8;
// The inliers refute a twin that keeps a smaller share of them.
constexpr double kShareOfTwin = 0.9;
// Normals that differ by more do not agree. The right ones differ by their errors, about a
// hundredth; the wrong ones by half the angle between the baselines, seen from the plane.
constexpr double kMaxNormalErrorRad = 0.087;
// The twin replaces a story if the support of the twin (SupportOf) is larger by more than this.
constexpr double kLeastMajority = 0.5;

struct Story {
  TwoView view;
  std::array<Eigen::Vector3d, 2> normals;  // In the frames of the photos a and b; unit vectors.
};

// The stories of a view, first the one that it has. Empty if it shows no plane.
using Stories = std::vector<Story>;

std::optional<SeenPlane> PlaneOf(const PairRays& rays, std::span<const int> inliers,
                                 const Rigid3d& b_from_a) {
  const auto plane = FitPlane(rays.rays, inliers, b_from_a, /*seed=*/1);
  const bool is_plane = plane && plane->normal_in_a.norm() > 0.0 &&
                        plane->num_explained >= kShareOnPlane * static_cast<double>(inliers.size());
  return is_plane ? plane : std::nullopt;
}

Story StoryOf(const TwoView& view, const Eigen::Vector3d& normal_in_a) {
  const Eigen::Vector3d unit = normal_in_a.normalized();
  return {view, {unit, view.b_from_a.rotation * unit}};
}

Stories StoriesOf(const PhotoSet& set, const TwoView& view) {
  const PairRays rays = MakePairRays(SourceOf(set, view.a, view.focal_factor_a),
                                     SourceOf(set, view.b, view.focal_factor_b), view.inliers);
  std::vector<int> all(rays.rays.size());
  std::iota(all.begin(), all.end(), 0);
  const auto plane = PlaneOf(rays, all, view.b_from_a);
  if (!plane) {
    return {};
  }
  Stories stories = {StoryOf(view, plane->normal_in_a)};
  stories.front().view.inliers = {};  // The set has them already.
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const RayMatch& match : rays.rays) {
    sum += match.a;
  }
  const auto twin = TwinOf(view.b_from_a, *plane, sum);
  const auto least = static_cast<int>(std::ceil(kShareOfTwin * static_cast<double>(all.size())));
  const auto settled = twin ? SettlePose(rays.rays, twin->b_from_a, least) : std::nullopt;
  if (settled) {
    if (const auto other = PlaneOf(rays, settled->inliers, settled->pose.b_from_a)) {
      TwoView twin_view = MakeTwoView(rays, *settled, view.inliers);
      twin_view.a = view.a;
      twin_view.b = view.b;
      twin_view.focal_factor_a = view.focal_factor_a;
      twin_view.focal_factor_b = view.focal_factor_b;
      stories.push_back(StoryOf(twin_view, other->normal_in_a));
    }
  }
  return stories;
}

// 1 for the same normal, 0 for another one.
double AgreementOf(const Eigen::Vector3d& p, const Eigen::Vector3d& q) {
  return std::max(0.0, 1.0 - AngleBetweenRad(p, q) / kMaxNormalErrorRad);
}

const Eigen::Vector3d& NormalAt(const Story& story, int photo) {
  return story.normals[story.view.a == photo ? 0 : 1];
}

// The sum of how well each other view of the story's two photos agrees with it, in [0, 1], by that
// view's better story.
double SupportOf(const std::vector<Stories>& stories,
                 const std::vector<std::vector<int>>& views_of_photo, int view, int story) {
  double support = 0.0;
  const Story& own = stories[view][story];
  for (const int photo : {own.view.a, own.view.b}) {
    for (const int other : views_of_photo[photo]) {
      if (other == view) {
        continue;
      }
      double best = 0.0;
      for (const Story& told : stories[other]) {
        best = std::max(best, AgreementOf(NormalAt(own, photo), NormalAt(told, photo)));
      }
      support += best;
    }
  }
  return support;
}

}  // namespace

void SettlePlanes(const PhotoSet& set, int num_threads, std::vector<TwoView>* views) {
  const int num_views = static_cast<int>(views->size());
  std::vector<Stories> stories(num_views);
  ParallelFor(num_views, num_threads, [&](int i) { stories[i] = StoriesOf(set, (*views)[i]); });
  std::vector<std::vector<int>> views_of_photo(set.photos.size());
  for (int i = 0; i < num_views; ++i) {
    if (!stories[i].empty()) {
      views_of_photo[(*views)[i].a].push_back(i);
      views_of_photo[(*views)[i].b].push_back(i);
    }
  }
  for (int i = 0; i < num_views; ++i) {
    if (stories[i].size() == 2 && SupportOf(stories, views_of_photo, i, 1) >
                                      SupportOf(stories, views_of_photo, i, 0) + kLeastMajority) {
      (*views)[i] = stories[i][1].view;
    }
  }
}

}  // namespace cairn
