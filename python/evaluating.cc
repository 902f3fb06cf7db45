#include "python/evaluating.h"

#include <fmt/format.h>
#include <pybind11/stl.h>

#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "cli/eval_queries.h"
#include "cli/query_features.h"
#include "core/error.h"
#include "core/features/sift/sift_extractor.h"
#include "core/parallel_for.h"
#include "core/printable.h"
#include "engine/localizer.h"
#include "eval/evaluation.h"
#include "python/arguments.h"
#include "python/arrays.h"
#include "python/docs.h"
#include "python/interruptible.h"

namespace cairn::python {
namespace {

struct EvaluateArguments {
  std::string map_path;
  EvalQueryArguments queries;
  CairnOptions options;
  PriorNoiseOptions noise;
  bool given_priors = false;
  int num_threads = 1;
};

EvaluateArguments ArgumentsOf(const py::object& path, const py::kwargs& keywords) {
  EvaluateArguments arguments;
  arguments.map_path = PathOf("path", path);
  arguments.options = OptionsOf(keywords["options"]);
  EvalQueryArguments& queries = arguments.queries;
  queries.query_list_path = PathOrEmpty("queries", keywords["queries"]);
  queries.reconstruction.model_dir = PathOrEmpty("model", keywords["model"]);
  queries.reconstruction.database_path = PathOrEmpty("database", keywords["database"]);
  queries.reconstruction.georef_path = PathOrEmpty("georef", keywords["georef"]);
  queries.reconstruction.use_gps = FlagOf("gps", keywords["gps"]);
  queries.image_list_path = PathOrEmpty("images", keywords["images"]);
  queries.image_dir = PathOrEmpty("image_dir", keywords["image_dir"]);
  if (queries.query_list_path.empty() == queries.reconstruction.model_dir.empty()) {
    RefuseArgument("queries",
                   "give either a query list or a model, with its database or image_dir");
  }
  arguments.noise = arguments.options.noise;
  arguments.noise.with_prior = FlagOf("with_prior", keywords["with_prior"]);
  arguments.noise.with_gravity = FlagOf("with_gravity", keywords["with_gravity"]);
  arguments.noise.seed = arguments.options.localizer.seed;
  arguments.given_priors = FlagOf("given_priors", keywords["given_priors"]);
  arguments.num_threads = ThreadsOf("threads", keywords["threads"]);
  return arguments;
}

// The features of the query, of its photo if it has none.
void RequireFeatures(const FeatureExtractor& extractor, EvalQuery* query) {
  if (query->query.features.size() == 0) {
    ExtractQueryFeatures(extractor, query);
  }
}

EvalReport Measure(const EvaluateArguments& arguments, const WorkProgress& report) {
  const Localizer localizer = Localizer::Open(arguments.map_path, arguments.options.localizer);
  std::vector<EvalQuery> queries =
      LoadEvalQueries(arguments.queries, arguments.options.georegister, localizer.map().Snapshot());
  if (!arguments.given_priors) {
    AddNoisyPriors(arguments.noise, &queries);
  }
  const SiftExtractor extractor(arguments.options.sift);
  std::vector<LocalizeResult> results(queries.size());
  std::mutex mutex;
  int64_t num_done = 0;
  ParallelFor(static_cast<int>(queries.size()), arguments.num_threads, [&](int i) {
    RequireFeatures(extractor, &queries[i]);
    results[i] = localizer.Localize(queries[i].query);
    const std::lock_guard lock(mutex);
    report("localize", ++num_done, static_cast<int64_t>(queries.size()));
  });
  return MeasureResults(queries, std::move(results));
}

EvalReport EvaluateMap(const py::object& path, const py::kwargs& keywords) {
  const EvaluateArguments arguments = ArgumentsOf(path, keywords);
  EvalReport result;
  RunInterruptibly(keywords["progress"],
                   [&](const WorkProgress& report) { result = Measure(arguments, report); });
  return result;
}

// A column of the answers.
template <typename Get>
auto Column(const Get& get) {
  return [get](const EvalReport& report) {
    using Value = decltype(get(report.answers[0]));
    py::array_t<Value> column(static_cast<py::ssize_t>(report.answers.size()));
    for (size_t i = 0; i < report.answers.size(); ++i) {
      column.mutable_data()[i] = get(report.answers[i]);
    }
    return column;
  };
}

py::tuple TupleOf(const Interval& interval) {
  return py::make_tuple(interval.value, interval.low, interval.high);
}

template <Interval EvalReport::*kMember>
py::tuple IntervalOf(const EvalReport& report) {
  return TupleOf(report.*kMember);
}

py::list RecallsOf(const EvalReport& report) {
  const py::object recall = py::module_::import("cairn._report").attr("Recall");
  py::list recalls;
  for (const auto& [threshold, share] : report.recalls) {
    recalls.append(
        recall(threshold.position_m, threshold.rotation_rad, share.value, share.low, share.high));
  }
  return recalls;
}

py::array_t<double> CurveOf(const EvalReport& report) {
  Eigen::MatrixXd curve(report.precision_recall.size(), 3);
  for (size_t i = 0; i < report.precision_recall.size(); ++i) {
    const PrecisionRecallPoint& point = report.precision_recall[i];
    curve.row(static_cast<Eigen::Index>(i)) << point.score, point.precision, point.recall;
  }
  return ArrayOf(curve);
}

void BindAnswers(py::class_<EvalReport>* report) {
  report
      ->def_property_readonly(
          "names",
          [](const EvalReport& self) {
            py::list names;
            for (const EvalAnswer& answer : self.answers) {
              names.append(TextOut(answer.name));
            }
            return names;
          },
          "Names of the queries. The arrays below have a row for each.")
      .def_property_readonly(
          "localized", Column([](const EvalAnswer& answer) { return answer.result.localized; }),
          "bool (N,): whether there is a pose.")
      .def_property_readonly(
          "position_error_m",
          Column([](const EvalAnswer& answer) { return answer.position_error_m; }),
          "float64 (N,): distance from the true position, meters; inf without a pose.")
      .def_property_readonly(
          "rotation_error_rad",
          Column([](const EvalAnswer& answer) { return answer.rotation_error_rad; }),
          "float64 (N,): angle to the true orientation, radians; inf without a pose.")
      .def_property_readonly("position_accuracy_m", Column([](const EvalAnswer& answer) {
                               return answer.position_accuracy_m;
                             }),
                             "float64 (N,): the 68 % radii that the answers state, meters.")
      .def_property_readonly(
          "confidence", Column([](const EvalAnswer& answer) { return answer.result.confidence; }),
          "float64 (N,): stated probability of being within 3 m and 10 degrees.")
      .def_property_readonly("score",
                             Column([](const EvalAnswer& answer) { return answer.result.score; }),
                             "float64 (N,): how far the evidence is from chance.")
      .def_property_readonly("seconds", Column([](const EvalAnswer& answer) {
                               return answer.result.times.total_seconds;
                             }),
                             "float64 (N,): time of the answer, seconds.");
}

}  // namespace

void BindEvaluating(py::module_* module) {
  using py::arg;
  py::class_<EvalReport> report(*module, "Report", py::dynamic_attr(), docs::kReport);
  BindAnswers(&report);
  report.def_readonly("num_queries", &EvalReport::num_queries, "Number of queries.")
      .def_readonly("num_localized", &EvalReport::num_localized, "Queries with a pose.")
      .def_property_readonly("recalls", &RecallsOf, docs::kRecalls)
      .def_property_readonly("median_position_error_m",
                             &IntervalOf<&EvalReport::median_position_error_m>,
                             "(value, low, high) over the localized queries, meters.")
      .def_property_readonly("median_rotation_error_rad",
                             &IntervalOf<&EvalReport::median_rotation_error_rad>,
                             "(value, low, high) over the localized queries, radians.")
      .def_property_readonly("average_precision", &IntervalOf<&EvalReport::average_precision>,
                             "(value, low, high): area under precision over recall.")
      .def_property_readonly("precision_recall", &CurveOf,
                             "float64 (M, 3): score, precision, recall; the highest score first.")
      .def("to_json", &ReportAsJson, "The report as `cairn eval --json` writes it.")
      .def("to_csv", &ReportAsCsv, "A line for each answer, as `cairn eval --csv` writes it.")
      .def("__str__", &ReportAsText);
  module->def("_evaluate", &EvaluateMap, arg("path"));
}

}  // namespace cairn::python
