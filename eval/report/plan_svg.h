// The map and the queries of a report in plan; private to eval/report.
#ifndef CAIRN_EVAL_REPORT_PLAN_SVG_H_
#define CAIRN_EVAL_REPORT_PLAN_SVG_H_

#include <string>
#include <vector>

#include "eval/eval_query.h"
#include "eval/evaluation.h"
#include "storage/map/map_store.h"

namespace cairn {

// How right an answer is, by the bounds of the recalls, which the page's colors tell apart.
enum class AnswerGrade { kFine, kGood, kFair, kWrong, kNone };
AnswerGrade GradeOf(const EvalAnswer& answer);
const char* GradeClass(AnswerGrade grade);  // The CSS class: "fine", ...
const char* GradeText(AnswerGrade grade);   // "within 0.25 m and 2 degrees", ...

// SVG, north up: tiles, landmarks, keyframes, and for each query the truth, the answer and the line
// between them, which is a link to #q<number>. Shows what LoadPlanContent loads.
std::string PlanAsSvg(const MapSnapshot& map, const std::vector<EvalQuery>& queries,
                      const EvalReport& report);

}  // namespace cairn

#endif  // CAIRN_EVAL_REPORT_PLAN_SVG_H_
