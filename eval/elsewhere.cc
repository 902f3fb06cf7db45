#include "eval/elsewhere.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <utility>

#include "core/check.h"
#include "core/require.h"

namespace cairn {
namespace {

// Separates these random numbers from the noise of the priors, which is seeded by the same names.
constexpr uint64_t kPlaceStream = 0x706c616365ull;
constexpr uint64_t kPermutationStream = 0x7065726dull;

// An index in [0, count). Gives the same value with every standard library.
size_t DrawIndex(std::mt19937_64* generator, size_t count) { return (*generator)() % count; }

}  // namespace

std::vector<Geodetic> KeyframePlaces(const MapSnapshot& map) {
  std::vector<Geodetic> places;
  for (const SessionRecord& session : map.Sessions()) {
    for (const KeyframeRecord& keyframe : map.KeyframesOfSession(session.id)) {
      places.push_back(GeodeticFromEcef(keyframe.cam_from_ecef.Inverse().translation));
    }
  }
  RequireOption(!places.empty(), "the map has no keyframes to move queries to");
  return places;
}

void PlaceElsewhere(const std::vector<Geodetic>& places, uint64_t seed,
                    std::vector<EvalQuery>* queries) {
  CAIRN_CHECK(!places.empty(), "places must not be empty");
  for (EvalQuery& query : *queries) {
    std::mt19937_64 generator = GeneratorOfQuery(query, seed ^ kPlaceStream);
    const Geodetic& place = places[DrawIndex(&generator, places.size())];
    const Geodetic truth = GeodeticFromEcef(query.cam_from_ecef.Inverse().translation);
    const Rigid3d cam_from_enu = query.cam_from_ecef * EcefFromEnu(truth);
    query.cam_from_ecef = cam_from_enu * EcefFromEnu(place).Inverse();
  }
}

void PermuteDescriptors(uint64_t seed, std::vector<EvalQuery>* queries) {
  for (EvalQuery& query : *queries) {
    std::mt19937_64 generator = GeneratorOfQuery(query, seed ^ kPermutationStream);
    DescriptorMatrix& descriptors = query.query.features.descriptors;
    for (Eigen::Index i = descriptors.rows() - 1; i > 0; --i) {  // Fisher-Yates.
      const auto j = static_cast<Eigen::Index>(DrawIndex(&generator, static_cast<size_t>(i) + 1));
      descriptors.row(i).swap(descriptors.row(j));
    }
  }
}

ElsewhereReport MeasureElsewhere(const std::vector<EvalAnswer>& answers) {
  RequireOption(!answers.empty(), "there are no answers to measure");
  ElsewhereReport report;
  report.num_queries = static_cast<int>(answers.size());
  for (const EvalAnswer& answer : answers) {
    if (!answer.result.localized) {
      continue;
    }
    ++report.num_answered;
    report.num_confident += answer.result.confidence > 0.5;
    report.num_sure += answer.result.confidence > 0.9;
    report.highest_confidence = std::max(report.highest_confidence, answer.result.confidence);
  }
  report.share_confident = WilsonInterval(report.num_confident, report.num_queries);
  report.share_sure = WilsonInterval(report.num_sure, report.num_queries);
  return report;
}

std::string ElsewhereAsText(const ElsewhereReport& report) {
  const auto line = [](const char* what, int count, const Interval& share) {
    return fmt::format("{:<28}{:>9}   {:.2f} % [{:.2f}, {:.2f}]\n", what, count,
                       100.0 * share.value, 100.0 * share.low, 100.0 * share.high);
  };
  return fmt::format("{} of {} queries from elsewhere answered\n\n", report.num_answered,
                     report.num_queries) +
         line("confidence above 0.5", report.num_confident, report.share_confident) +
         line("confidence above 0.9", report.num_sure, report.share_sure) +
         fmt::format("{:<28}{:>9.3f}\n", "highest confidence", report.highest_confidence);
}

}  // namespace cairn
