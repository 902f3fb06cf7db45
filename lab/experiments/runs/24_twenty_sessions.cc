// Measures a map over twenty sessions in ten years: size, average precision, links between
// sessions, time of the ingests.
#include <fmt/format.h>

#include <algorithm>
#include <ctime>
#include <deque>
#include <filesystem>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <unordered_set>
#include <vector>

#include "eval/evaluation_compare.h"
#include "lab/city/city_sessions.h"
#include "lab/experiments/figure.h"
#include "lab/experiments/measure/link_judge.h"
#include "lab/experiments/measure/variants.h"
#include "lab/experiments/runs/runs.h"
#include "lab/experiments/verdict.h"
#include "storage/tile/tile_codec.h"

namespace cairn {
namespace {

constexpr double kGeoregistrationSigmaM = 0.3;
constexpr int kNumNewest = 3;  // Sessions of the map that knows the newest alone.
constexpr double kQuarterYears = 0.25;
constexpr double kFirstJudgedYears = 2.0;  // Before, the three maps hardly differ.
// The bars: growth of the bytes after session kNumNewest, false links, links that are found, fall
// of the average precision where nothing has changed, and time of the last ingest over that of
// session kNumNewest, each for a landmark of its session: the sessions differ in length.
constexpr double kMaxGrowth = 0.05, kMaxFalseShare = 0.005, kMinFoundShare = 0.8;
constexpr double kMaxFall = 0.02, kMaxSlowdown = 1.5;

struct KeptMap {
  std::string name;
  IngestOptions ingest;
  std::shared_ptr<MapStore> store;
  double last_ingest_seconds = 0.0;  // Processor time, all threads.
  IngestReport last_report;
};

void Ingest(const CitySession& session, int session_idx, KeptMap* map) {
  IngestOptions options = map->ingest;
  options.session_name = fmt::format("session {:02}", session_idx);
  options.source = "simulated city";
  options.gate.max_lost_share = 1.0;  // The experiment measures what is lost.
  options.recorded_at = session.recorded_at;
  const std::clock_t start = std::clock();
  map->last_report =
      IngestSession(session.reconstruction, session.ecef_from_world, options, map->store.get(), {});
  map->last_ingest_seconds =
      static_cast<double>(std::clock() - start) / static_cast<double>(CLOCKS_PER_SEC);
}

std::unordered_set<uint64_t> LandmarksOf(const MapStore& store) {
  const MapSnapshot snapshot = store.Snapshot();
  std::unordered_set<uint64_t> ids;
  for (const TileRecord& record : snapshot.AllTiles(1000)) {
    for (const LandmarkId id : DecodeTile(snapshot.LoadPayload(record.payload_id)).landmark_ids) {
      ids.insert(Value(id));
    }
  }
  return ids;
}

CityWorldOptions WorldOf(const ExperimentContext& context, uint64_t seed) {
  CityWorldOptions options = CityWorldPreset(CityCharacter::kGrid, CityWorldSize::kQuick);
  options.city.area_km2 = context.Pick(0.01, 0.0225);
  options.city.seed = options.mapping.seed = options.descriptors.seed = seed;
  options.mapping.num_passes = context.Pick(5, 20);
  options.mapping.years = context.Pick(2.5, 10.0);
  options.mapping.rig.image_width_px = options.mapping.rig.image_height_px = 560;
  options.mapping.detector.max_keypoints = 350;
  options.mapping.keyframe_spacing_m = 4.0;
  options.queries.num_queries = context.NumQueries(20, 150);
  options.num_threads = context.num_threads;
  return options;
}

// One seed's city, session by session.
class LivingMapRun {
 public:
  LivingMapRun(const ExperimentContext& context, uint64_t seed)
      : context_(context), seed_(seed), sessions_(WorldOf(context, seed), kGeoregistrationSigmaM) {}

  void Run(ResultTable* table) {
    const CitySession first = sessions_.Record(0);
    const int64_t budget = Budget(first);
    living_ = Make("living", SessionJoining::kJoin, budget);
    united_ = Make("united", SessionJoining::kApart, budget);
    for (int i = 0; i < sessions_.size(); ++i) {
      const CitySession session = i == 0 ? first : sessions_.Record(i);
      Ingest(session, i, &living_);
      Ingest(session, i, &united_);
      judge_.Add(session, living_.last_report, LandmarksOf(*living_.store));
      Remember(session);
      if (i + 1 <= kNumNewest) {
        known_early_.insert(session.city_landmarks.begin(), session.city_landmarks.end());
      }
      bytes_.push_back(living_.store->Snapshot().Info().payload_bytes);
      seconds_.push_back(living_.last_ingest_seconds);
      num_landmarks_.push_back(static_cast<double>(session.reconstruction.landmarks.size()));
      // Two sessions in three are measured no further: asking takes longer than ingesting.
      const bool is_in_turn = i + 1 >= kNumNewest && (i + 1) % context_.Pick(1, 3) == 0;
      if (is_in_turn || i + 1 == sessions_.size()) {
        measured_sessions_.push_back(i + 1);
        Measure(i, session.time_years, budget, table);
        MeasureUnchanged(i, table);
      }
      if (context_.progress) {
        context_.progress("sessions", i + 1, sessions_.size());
      }
    }
  }

  const LinkJudge& judge() const { return judge_; }
  const std::vector<int>& measured_sessions() const { return measured_sessions_; }
  // Index of the first measured session after kFirstJudgedYears, in the reports.
  size_t first_judged() const {
    return static_cast<size_t>(std::find_if(measured_sessions_.begin(), measured_sessions_.end(),
                                            [this](int session) {
                                              return sessions_.TimeYears(session - 1) >=
                                                     kFirstJudgedYears;
                                            }) -
                               measured_sessions_.begin());
  }
  // Largest size after session kNumNewest over the size then, less 1.
  double Growth() const {
    const auto then = bytes_.begin() + kNumNewest - 1;
    return static_cast<double>(*std::max_element(then, bytes_.end())) / static_cast<double>(*then) -
           1.0;
  }
  // Time of the last ingest over that of session kNumNewest.
  double Slowdown() const { return LastOverEarly(seconds_); }
  // The same for a landmark of the session.
  double SlowdownOfLandmark() const { return Slowdown() / LastOverEarly(num_landmarks_); }
  const std::vector<EvalReport>& living_reports() const { return living_reports_; }
  const std::vector<EvalReport>& united_reports() const { return united_reports_; }
  const std::vector<EvalReport>& newest_reports() const { return newest_reports_; }
  const std::vector<EvalReport>& unchanged_reports() const { return unchanged_reports_; }

 private:
  static double LastOverEarly(const std::vector<double>& of_sessions) {
    return of_sessions.back() / of_sessions[kNumNewest - 1];
  }

  // Descriptors of a tile with the budget of one session and a half.
  int64_t Budget(const CitySession& first) {
    KeptMap alone = Make("budget", SessionJoining::kApart, 10'000'000);
    Ingest(first, 0, &alone);
    int64_t most = 1;
    for (const TileRecord& tile : alone.store->Snapshot().AllTiles(1000)) {
      most = std::max(most, tile.num_descriptors);
    }
    return most * 3 / 2;
  }

  KeptMap Make(const std::string& name, SessionJoining joining, int64_t budget) {
    KeptMap map;
    map.name = name;
    map.ingest.joining = joining;
    map.ingest.selection.max_descriptors = budget;
    const std::string path =
        context_.worlds->MapPath(fmt::format("twenty_{}_{}_{}", seed_, name, num_maps_++));
    std::filesystem::remove(path);  // Of an earlier run.
    map.store = std::make_shared<MapStore>(MapStore::Create(path));
    return map;
  }

  void Remember(const CitySession& session) {
    newest_.push_back(session);
    if (newest_.size() > kNumNewest) {
      newest_.pop_front();
    }
  }

  void Measure(int session_idx, double time_years, int64_t budget, ResultTable* table) {
    std::unordered_set<uint64_t> mapped;
    KeptMap newest = Make("newest", SessionJoining::kApart, budget);
    for (size_t i = 0; i < newest_.size(); ++i) {
      mapped.insert(newest_[i].city_landmarks.begin(), newest_[i].city_landmarks.end());
      Ingest(newest_[i], static_cast<int>(i), &newest);
    }
    const std::vector<EvalQuery> queries = sessions_.Ask(
        time_years + kQuarterYears, mapped, seed_ * 1000 + static_cast<uint64_t>(session_idx));
    for (auto& [map, reports] :
         {std::pair(&living_, &living_reports_), std::pair(&united_, &united_reports_),
          std::pair(&newest, &newest_reports_)}) {
      AddRow(session_idx, *map, queries, reports, table);
    }
  }

  // Asks the living map the same queries after every session: photos of things that the first
  // kNumNewest sessions saw and that still stand after the last one.
  void MeasureUnchanged(int session_idx, ResultTable* table) {
    if (unchanged_.empty()) {
      const double last_years = sessions_.TimeYears(sessions_.size() - 1);
      const double asked_years = sessions_.TimeYears(kNumNewest - 1) + kQuarterYears;
      const std::unordered_set<uint64_t> lasting = sessions_.Lasting(asked_years, last_years);
      std::erase_if(known_early_, [&](uint64_t id) { return !lasting.contains(id); });
      unchanged_ = sessions_.Ask(asked_years, known_early_, seed_ * 1000 + 999);
    }
    KeptMap asked = living_;
    asked.name = "living, unchanged places";
    AddRow(session_idx, asked, unchanged_, &unchanged_reports_, table);
  }

  void AddRow(int session_idx, const KeptMap& map, const std::vector<EvalQuery>& queries,
              std::vector<EvalReport>* reports, ResultTable* table) {
    ExperimentWorld world;
    world.store = map.store;
    world.queries = queries;
    const EvalReport report =
        MeasureVariants(world, {{map.name, 0.0, BestVariant()}}, context_).front().report;
    const MapInfo info = map.store->Snapshot().Info();
    const TileChanges& changes = map.last_report.changes;
    std::vector<Cell> cells = {map.name,
                               static_cast<double>(seed_),
                               static_cast<double>(session_idx + 1),
                               static_cast<double>(info.payload_bytes),
                               static_cast<double>(info.num_landmarks),
                               static_cast<double>(info.num_descriptors),
                               static_cast<double>(info.num_keyframes),
                               static_cast<double>(changes.num_merged),
                               static_cast<double>(changes.num_new),
                               static_cast<double>(changes.num_faded),
                               static_cast<double>(changes.num_evicted)};
    AddIntervalCells(report.average_precision, &cells);
    cells.emplace_back(map.last_ingest_seconds);
    table->AddRow(std::move(cells));
    reports->push_back(report);
  }

  const ExperimentContext& context_;
  uint64_t seed_;
  CitySessions sessions_;
  LinkJudge judge_;
  KeptMap living_, united_;
  int num_maps_ = 0;
  std::deque<CitySession> newest_;
  std::unordered_set<uint64_t> known_early_;  // City landmarks of the first kNumNewest sessions.
  std::vector<EvalQuery> unchanged_;
  std::vector<int> measured_sessions_;  // Parallel to the reports.
  std::vector<int64_t> bytes_;          // Of the living map, by session.
  std::vector<double> seconds_;         // Of its ingests.
  std::vector<double> num_landmarks_;   // Of the sessions.
  std::vector<EvalReport> living_reports_, united_reports_, newest_reports_, unchanged_reports_;
};

// Appends the answers, so that reports of all times and cities are compared as one.
void Append(std::span<const EvalReport> reports, EvalReport* all) {
  for (const EvalReport& report : reports) {
    all->answers.insert(all->answers.end(), report.answers.begin(), report.answers.end());
    all->num_queries += report.num_queries;
  }
}

// What the verdict depends on, over all seeds.
struct LivingMapFigures {
  EvalReport living, united, newest;  // From kFirstJudgedYears on.
  double false_share = 0.0;           // Largest of the seeds.
  double found_share = 1.0;           // Smallest of the seeds.
  double growth = 0.0;                // Largest of the seeds, after session kNumNewest.
  double slowdown = 0.0;              // Largest of the seeds.
  double landmark_slowdown = 0.0;     // Largest of the seeds.
  std::vector<EvalReport> unchanged;  // By measured session, all seeds together.

  void Add(const LivingMapRun& run) {
    Append(std::span(run.living_reports()).subspan(run.first_judged()), &living);
    Append(std::span(run.united_reports()).subspan(run.first_judged()), &united);
    Append(std::span(run.newest_reports()).subspan(run.first_judged()), &newest);
    false_share = std::max(false_share, run.judge().FalseShare());
    found_share = std::min(found_share, run.judge().FoundShare());
    growth = std::max(growth, run.Growth());
    slowdown = std::max(slowdown, run.Slowdown());
    landmark_slowdown = std::max(landmark_slowdown, run.SlowdownOfLandmark());
    unchanged.resize(run.unchanged_reports().size());
    for (size_t i = 0; i < unchanged.size(); ++i) {
      Append({&run.unchanged_reports()[i], 1}, &unchanged[i]);
    }
  }

  // Largest fall of the average precision on the unchanged queries from the best before, paired.
  Interval Fall() const {
    Interval largest{0.0, 0.0, 0.0};
    for (size_t later = 1; later < unchanged.size(); ++later) {
      for (size_t earlier = 0; earlier < later; ++earlier) {
        const Interval fall = PairedDifference(unchanged[earlier], unchanged[later],
                                               AccuracyMeasure::kAveragePrecision);
        largest = fall.value > largest.value ? fall : largest;
      }
    }
    return largest;
  }
};

// Draws the average precision over the sessions for each map of the first seed.
Figure PrecisionOverSessions(const LivingMapRun& run) {
  Figure figure{.name = "24_twenty_sessions",
                .title = "Queries of the newest year",
                .x_label = "sessions",
                .y_label = "average precision"};
  for (const auto& [label, reports] : {std::pair("living map", &run.living_reports()),
                                       std::pair("side by side", &run.united_reports()),
                                       std::pair("newest three", &run.newest_reports())}) {
    FigureSeries series{label, {}};
    for (size_t i = 0; i < reports->size(); ++i) {
      series.points.push_back(
          {static_cast<double>(run.measured_sessions()[i]), (*reports)[i].average_precision});
    }
    figure.series.push_back(std::move(series));
  }
  return figure;
}

ExperimentOutcome RunTwentySessions(const ExperimentContext& context) {
  ExperimentOutcome outcome;
  std::vector<Column> columns = {{"map"},       {"seed"},        {"session"},   {"payload_bytes"},
                                 {"landmarks"}, {"descriptors"}, {"keyframes"}, {"merged"},
                                 {"new"},       {"faded"},       {"evicted"}};
  AddIntervalColumns("average_precision", &columns);
  columns.push_back({"ingest_cpu_s", true});
  outcome.table = ResultTable(std::move(columns));
  LivingMapFigures figures;
  const int num_seeds = context.Pick(1, 4);
  const CityWorldOptions world = WorldOf(context, context.seed);
  outcome.parameters = {
      {"city", fmt::format("grid, {:.0f} m square, {} seeds", world.city.SideM(), num_seeds)},
      {"sessions", fmt::format("{} in {} years, each a drive with routes of its own",
                               world.mapping.num_passes, world.mapping.years)},
      {"budget", "one and a half times the descriptors of the first session"},
      {"queries", fmt::format("{} a quarter of a year after every measured session",
                              world.queries.num_queries)}};
  for (int i = 0; i < num_seeds; ++i) {
    LivingMapRun run(context, context.seed + static_cast<uint64_t>(i));
    run.Run(&outcome.table);
    figures.Add(run);
    if (i == 0) {
      outcome.figures = {PrecisionOverSessions(run)};
    }
  }
  const Interval over_united =
      PairedDifference(figures.living, figures.united, AccuracyMeasure::kAveragePrecision);
  const Interval over_newest =
      PairedDifference(figures.living, figures.newest, AccuracyMeasure::kAveragePrecision);
  const Interval fall = figures.Fall();
  const bool is_small = figures.growth <= kMaxGrowth && figures.landmark_slowdown <= kMaxSlowdown;
  const bool links_well =
      figures.false_share <= kMaxFalseShare && figures.found_share >= kMinFoundShare;
  const bool holds = is_small && links_well && fall.value <= kMaxFall && over_united.low > 0.0 &&
                     over_newest.low > 0.0;
  const bool fails = !is_small || !links_well || fall.value > kMaxFall || over_united.high < 0.0 ||
                     over_newest.high < 0.0;
  outcome.verdict = holds ? Verdict::kHolds : fails ? Verdict::kDoesNotHold : Verdict::kUndecided;
  outcome.sentence = fmt::format(
      "After session {} the map grows by {:.3f} at most, and the last ingest takes {:.2f} times "
      "the "
      "processor time for a landmark of its session at worst ({:.2f} times in all). From year {:g} "
      "on, its average precision minus that of all sessions side by side is {}, minus that of the "
      "newest {} sessions {}. On unchanged places it falls by {} at most. Of the links {:.4f} are "
      "false at worst; {:.3f} of the possible links are found.",
      kNumNewest, figures.growth, figures.landmark_slowdown, figures.slowdown, kFirstJudgedYears,
      DifferenceText(over_united), kNumNewest, DifferenceText(over_newest), DifferenceText(fall),
      figures.false_share, figures.found_share);
  return outcome;
}

}  // namespace

Experiment TwentySessionsExperiment() {
  return {
      "24_twenty_sessions",
      "Twenty sessions in ten years",
      "Section \"Conclusion\": a model of constant size that takes up new data",
      "A map keeps its size over twenty sessions and localizes at least as well as a map of the "
      "newest sessions.",
      "holds if the bytes grow by at most 5 % after session 3, the last ingest takes at most 1.5 "
      "times the processor time of session 3's for a landmark of the session, the average "
      "precision is above that of the newest three sessions alone and of all sessions side by side "
      "under the same budget and falls by at most 0.02 where nothing has changed, at most 0.5 % of "
      "the links are false and at least 80 % are found.",
      "10 min",
      RunTwentySessions};
}

}  // namespace cairn
