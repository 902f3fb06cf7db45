// One page about an evaluation: what `cairn eval --report` writes.
#ifndef CAIRN_EVAL_REPORT_REPORT_PAGE_H_
#define CAIRN_EVAL_REPORT_REPORT_PAGE_H_

#include <string>
#include <vector>

#include "eval/eval_query.h"
#include "eval/evaluation.h"
#include "storage/map/map_store.h"

namespace cairn {

// Returns an HTML page without scripts that refers to no other file but `report.json` and
// `answers.csv` beside it: the measures, the map in plan, curves with 95 % intervals, calibration,
// times by stage, the ten worst queries with their matches, and a table of all. It follows the
// light or dark scheme of the reader's browser. report.answers[i] answers queries[i]; photos are
// read from the paths of the queries, and a photo that cannot be read is left out. `map_name` is
// text.
std::string MakeReportPage(const std::string& map_name, const MapSnapshot& map,
                           const std::vector<EvalQuery>& queries, const EvalReport& report);

}  // namespace cairn

#endif  // CAIRN_EVAL_REPORT_REPORT_PAGE_H_
