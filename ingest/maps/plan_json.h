// The manifest of a plan as JSON. The format is docs/formats/plan_v1.md.
#ifndef CAIRN_INGEST_MAPS_PLAN_JSON_H_
#define CAIRN_INGEST_MAPS_PLAN_JSON_H_

#include <string>
#include <string_view>
#include <vector>

#include "ingest/session_plan.h"

namespace cairn {

// The content of the manifest. The codebook, which is a file of its own, has only its id.
struct PlanManifest {
  SessionPlan plan;
  std::string map_path;  // Absolute, or a URL.
  std::string codebook_digest;
  std::vector<std::string> shard_digests;  // Parallel to plan.tiles.
};

// Ends with a line feed. Numbers are exact. Names the version of this program.
std::string ManifestAsJson(const PlanManifest& manifest);

// Throws Error(kBadInput) if the text is no manifest of this version of Cairn, or if a value makes
// no sense. Untrusted text cannot cause allocations of more than a few times its size.
PlanManifest ManifestFromJson(std::string_view json);

}  // namespace cairn

#endif  // CAIRN_INGEST_MAPS_PLAN_JSON_H_
