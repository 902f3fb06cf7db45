// Measures queries that show nothing of the map: how many are answered, and with what confidence.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "eval/elsewhere.h"
#include "lab/experiments/measure/variants.h"
#include "lab/experiments/runs/cities.h"
#include "lab/experiments/runs/runs.h"

namespace cairn {
namespace {

// Largest acceptable share of queries from elsewhere that get an answer with a confidence above
// 0.5.
constexpr double kMaxConfidentShare = 0.002;

struct NamedWorld {
  std::string city;
  std::shared_ptr<const ExperimentWorld> world;
};

// Returns one city's queries with priors of another city, as if the photos had been taken there.
std::vector<EvalQuery> AskedIn(const ExperimentWorld& world, std::vector<EvalQuery> queries,
                               bool with_priors, uint64_t seed) {
  PlaceElsewhere(KeyframePlaces(world.store->Snapshot()), seed, &queries);
  PriorNoiseOptions noise;
  noise.with_prior = noise.with_gravity = with_priors;
  noise.seed = seed;
  AddNoisyPriors(noise, &queries);
  return queries;
}

// Queries the engine as users run it.
std::vector<EvalAnswer> Ask(const ExperimentWorld& world, std::vector<EvalQuery> queries,
                            const ExperimentContext& context) {
  ExperimentWorld asked = world;
  asked.queries = std::move(queries);
  return MeasureVariants(asked, {{"elsewhere", 0.0, LocalizerOptions()}}, context)
      .front()
      .report.answers;
}

void AddRow(const std::string& map, const std::string& queries,
            const std::vector<EvalAnswer>& answers, ResultTable* table,
            std::vector<EvalAnswer>* all) {
  const ElsewhereReport report = MeasureElsewhere(answers);
  table->AddRow({map, queries, static_cast<double>(report.num_queries),
                 static_cast<double>(report.num_answered),
                 static_cast<double>(report.num_confident), static_cast<double>(report.num_sure),
                 report.highest_confidence});
  all->insert(all->end(), answers.begin(), answers.end());
}

// Draws the share of the queries that are answered with more than a given confidence.
Figure ShareOverConfidence(const std::vector<EvalAnswer>& answers) {
  Figure figure{.name = "22_elsewhere",
                .title = "Queries from elsewhere that are answered",
                .x_label = "with a confidence of more than",
                .y_label = "share of the queries"};
  FigureSeries series{"four cities", {}};
  for (const double confidence : {0.0, 0.5, 0.6, 0.7, 0.8, 0.9}) {
    const auto num_above =
        std::count_if(answers.begin(), answers.end(), [confidence](const EvalAnswer& answer) {
          return answer.result.localized && answer.result.confidence > confidence;
        });
    series.points.push_back({confidence, WilsonInterval(static_cast<int>(num_above),
                                                        static_cast<int>(answers.size()))});
  }
  figure.series = {series};
  return figure;
}

ExperimentOutcome RunElsewhere(const ExperimentContext& context) {
  ExperimentOutcome outcome;
  outcome.table = ResultTable({{"map"},
                               {"queries"},
                               {"asked"},
                               {"answered"},
                               {"confidence_above_0.5"},
                               {"confidence_above_0.9"},
                               {"highest_confidence"}});
  std::vector<NamedWorld> cities;
  for (const auto& [city, options] : Cities(context)) {
    cities.push_back({city, context.worlds->Get(options, context.progress)});
    outcome.parameters.emplace_back(city, cities.back().world->description);
  }
  std::vector<EvalAnswer> all;
  for (const NamedWorld& map : cities) {
    for (const NamedWorld& other : cities) {
      if (other.city == map.city) {
        continue;
      }
      for (const bool with_priors : {true, false}) {
        AddRow(map.city, other.city + (with_priors ? "" : ", no prior, no gravity"),
               Ask(*map.world, AskedIn(*map.world, other.world->queries, with_priors, context.seed),
                   context),
               &outcome.table, &all);
      }
    }
    std::vector<EvalQuery> permuted = map.world->queries;
    PermuteDescriptors(context.seed, &permuted);
    AddRow(map.city, "its own, descriptors permuted", Ask(*map.world, std::move(permuted), context),
           &outcome.table, &all);
  }
  const ElsewhereReport report = MeasureElsewhere(all);
  outcome.figures = {ShareOverConfidence(all)};
  outcome.verdict = report.share_confident.value <= kMaxConfidentShare && report.num_sure == 0
                        ? Verdict::kHolds
                        : Verdict::kDoesNotHold;
  outcome.sentence = fmt::format(
      "Of {} queries from elsewhere, {} are answered: {} with a confidence above 0.5, {} with a "
      "confidence above 0.9.",
      report.num_queries, report.num_answered, report.num_confident, report.num_sure);
  return outcome;
}

}  // namespace

Experiment ElsewhereExperiment() {
  return {"22_elsewhere",
          "Photos from elsewhere",
          "not in the paper",
          "Queries that show nothing of the map are not answered.",
          "holds if at most 0.2 % of the queries get an answer with a confidence above 0.5 and no "
          "query gets one with a confidence above 0.9.",
          "8 min",
          RunElsewhere};
}

}  // namespace cairn
