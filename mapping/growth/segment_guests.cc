#include "mapping/growth/segment_guests.h"

#include <set>
#include <vector>

#include "core/parallel_for.h"
#include "mapping/growth/draft.h"
#include "mapping/growth/gps_check.h"
#include "mapping/growth/propose_photo.h"

namespace cairn {
namespace {

std::vector<int> LinkedWith(const Draft& draft, const ViewGraph& graph,
                            std::span<const int> views) {
  std::set<int> linked;
  for (const int i : views) {
    const TwoView& view = graph.View(i);
    linked.insert(draft.Has(view.a) ? view.b : view.a);
  }
  return {linked.begin(), linked.end()};
}

// The host does not know cameras that only the other segment has.
void TakeNewCameras(const Segment& other, Draft* draft) {
  for (const ReconImage& image : other.model.images) {
    if (draft->IsNewCamera(image.camera_idx)) {
      draft->SetCamera(image.camera_idx, other.model.cameras[image.camera_idx]);
    }
  }
}

void RemoveWeak(const std::vector<int>& guests, int min_inliers, Draft* draft) {
  const std::vector<int> counts = draft->CountObservations();
  std::vector<int> weak;
  for (const int photo : guests) {
    if (counts[photo] < min_inliers) {
      weak.push_back(photo);
    }
  }
  draft->Remove(weak);
}

}  // namespace

std::optional<Segment> WithGuests(const GrowthScene& scene, const Segment& host,
                                  const Segment& other, std::span<const int> views) {
  Draft draft(scene.set, scene.tracks, host, scene.options.num_threads);
  TakeNewCameras(other, &draft);
  const GpsCheck gps(scene.set, draft, scene.options.default_gps_accuracy_m, scene.options.seed);
  const std::vector<int> linked = LinkedWith(draft, scene.graph, views);
  std::vector<Proposal> proposals(linked.size());
  ParallelFor(static_cast<int>(linked.size()), scene.options.num_threads, [&](int i) {
    proposals[i] = scene.proposer.Propose(draft, gps, linked[i], /*is_last_resort=*/true);
  });
  std::vector<int> guests;
  for (const Proposal& proposal : proposals) {
    if (proposal.verdict == PhotoVerdict::kInSegment) {
      draft.Add(proposal.photo, *proposal.pose);
      guests.push_back(proposal.photo);
    }
  }
  draft.Triangulate(guests);
  if (guests.empty() || !draft.AdjustAround(guests)) {
    return std::nullopt;
  }
  draft.Triangulate(guests);
  RemoveWeak(guests, scene.options.min_inliers, &draft);
  return draft.num_photos() > static_cast<int>(host.photo_of_image.size())
             ? std::optional(draft.Finish())
             : std::nullopt;
}

}  // namespace cairn
