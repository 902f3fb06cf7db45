#include "mapping/growth/segment_guests.h"

#include <set>
#include <vector>

#include "mapping/growth/draft.h"
#include "mapping/growth/gps_check.h"
#include "mapping/growth/propose_photo.h"

namespace cairn {

Segment WithGuests(const GrowthScene& scene, const Segment& host, std::span<const int> views) {
  Draft draft(scene.set, scene.tracks, host, scene.options.num_threads);
  std::set<int> outside;
  for (const int i : views) {
    const TwoView& view = scene.graph.View(i);
    outside.insert(draft.Has(view.a) ? view.b : view.a);
  }
  const GpsCheck gps(scene.set, draft, scene.options.default_gps_accuracy_m, scene.options.seed);
  std::vector<Proposal> proposals;
  for (const int photo : outside) {
    proposals.push_back(scene.proposer.Propose(draft, gps, photo, /*is_last_resort=*/true));
  }
  std::vector<int> guests;
  for (const Proposal& proposal : proposals) {
    if (proposal.verdict == PhotoVerdict::kInSegment) {
      draft.Add(proposal.photo, *proposal.pose);
      guests.push_back(proposal.photo);
    }
  }
  draft.Triangulate(guests);
  if (draft.AdjustAround(guests)) {
    draft.Triangulate(guests);
  }
  return draft.Finish();
}

}  // namespace cairn
