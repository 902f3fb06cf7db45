// The two views of many pairs, in parts that the work folder keeps.
#ifndef CAIRN_MAPPING_SESSION_MATCH_IN_PARTS_H_
#define CAIRN_MAPPING_SESSION_MATCH_IN_PARTS_H_

#include <span>
#include <string>
#include <utility>
#include <vector>

#include "mapping/matching/two_view.h"
#include "mapping/photo_set.h"
#include "mapping/work_folder.h"

namespace cairn {

// Where the parts are kept: in files of the work folder named `file` and a number.
struct KeptParts {
  WorkFolder* work = nullptr;  // Null: nowhere.
  std::string file;
  std::string key;
};

struct MatchedParts {
  std::vector<TwoView> views;
  bool is_from_work = false;  // The folder had all parts.
};

// As FindTwoViews.
MatchedParts FindTwoViewsInParts(const PhotoSet& set, std::span<const std::pair<int, int>> pairs,
                                 const TwoViewOptions& options, const KeptParts& kept,
                                 const StepProgress& progress);

}  // namespace cairn

#endif  // CAIRN_MAPPING_SESSION_MATCH_IN_PARTS_H_
