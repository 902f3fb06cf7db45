// Judges the links between the sessions of a simulated city.
#ifndef CAIRN_LAB_EXPERIMENTS_MEASURE_LINK_JUDGE_H_
#define CAIRN_LAB_EXPERIMENTS_MEASURE_LINK_JUDGE_H_

#include <cstdint>
#include <unordered_map>
#include <unordered_set>

#include "ingest/ingest_session.h"
#include "lab/city/city_sessions.h"

namespace cairn {

// Counts links between sessions against the simulation. A link is false if it joins two things. A
// link is possible if the map knows the thing from a direction and scale that matching can connect.
class LinkJudge {
 public:
  // `report` is of the ingest of `session`. `ids_in_map` are the landmarks that the map holds
  // after it.
  void Add(const CitySession& session, const IngestReport& report,
           const std::unordered_set<uint64_t>& ids_in_map);

  double FalseShare() const;  // Of the links.
  double FoundShare() const;  // Of the possible links.

 private:
  void Remember(const CitySession& session, const IngestReport& report);
  void Forget(const std::unordered_set<uint64_t>& ids_in_map);

  std::unordered_map<uint64_t, uint64_t> thing_of_id_;
  std::unordered_map<uint64_t, std::unordered_set<uint64_t>> views_of_id_;
  std::unordered_set<uint64_t> known_views_;  // Of all of them.
  int64_t num_linked_ = 0, num_false_ = 0, num_found_ = 0, num_possible_ = 0;
};

}  // namespace cairn

#endif  // CAIRN_LAB_EXPERIMENTS_MEASURE_LINK_JUDGE_H_
