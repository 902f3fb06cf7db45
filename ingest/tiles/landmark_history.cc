#include "ingest/tiles/landmark_history.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <string>

namespace cairn {
namespace {

// Prior knowledge of the share of observations: one in three.
constexpr double kPriorObservations = 1.0, kPriorChances = 3.0;

uint8_t SaturatingSum(uint8_t a, uint8_t b) {
  return static_cast<uint8_t>(std::min(int{a} + int{b}, 255));
}

// Share of observations in chances, up to and without entry `end`.
double ObservationShare(std::span<const HistoryEntry> history, size_t end) {
  double observations = kPriorObservations, chances = kPriorChances;
  for (size_t i = 0; i < end; ++i) {
    observations += history[i].num_observations;
    chances += history[i].num_chances;
  }
  return observations / chances;
}

double YearsBetween(SessionId from, SessionId to, const SessionTimes& times) {
  const auto begin = times.find(from), end = times.find(to);
  if (begin == times.end() || end == times.end()) {
    return 0.0;
  }
  return std::max(0.0, end->second - begin->second);
}

// Years since 1970 of "2026-01-31T12:00:00Z"; days count, hours do not.
double YearsOf(const std::string& utc_time) {
  int year = 1970;
  unsigned month = 1, day = 1;
  if (std::sscanf(utc_time.c_str(), "%d-%u-%u", &year, &month, &day) != 3) {
    return 0.0;
  }
  using namespace std::chrono;
  const sys_days date = std::chrono::year(year) / std::chrono::month(month) / std::chrono::day(day);
  return duration<double, std::chrono::years::period>(date.time_since_epoch()).count();
}

}  // namespace

SessionTimes TimesOf(const std::vector<SessionRecord>& sessions) {
  SessionTimes times;
  for (const SessionRecord& session : sessions) {
    times[session.id] = YearsOf(session.recorded_at);
  }
  return times;
}

void AppendToHistory(const HistoryEntry& entry, std::vector<HistoryEntry>* history) {
  const bool is_sum = entry.session_id == SessionId{};
  history->insert(is_sum ? history->begin() : history->end(), entry);
  const bool has_two_sums =
      is_sum && history->size() > 1 && (*history)[1].session_id == SessionId{};
  if (!has_two_sums && history->size() <= Tile::kMaxHistory) {
    return;
  }
  HistoryEntry& sum = history->front();
  const HistoryEntry oldest = (*history)[1];
  sum = {SessionId{}, SaturatingSum(sum.num_observations, oldest.num_observations),
         SaturatingSum(sum.num_chances, oldest.num_chances)};
  history->erase(history->begin() + 1);
}

double ExistenceProbability(std::span<const HistoryEntry> history, const SessionTimes& times,
                            const PersistenceOptions& options) {
  size_t next = history.size();  // After the last observation.
  while (next > 0 && history[next - 1].num_observations == 0) {
    --next;
  }
  if (next == 0) {
    return history.empty() ? 1.0 : 0.0;
  }
  const double observation_share = ObservationShare(history, next);
  double existence = 1.0;
  for (size_t i = next; i < history.size(); ++i) {
    const double years = YearsBetween(history[i - 1].session_id, history[i].session_id, times);
    existence *= std::pow(1.0 - options.loss_per_year, years);
    const double miss_share = std::max(options.least_miss_share,
                                       std::pow(1.0 - observation_share, history[i].num_chances));
    const double missed_though_there = existence * miss_share;
    existence = missed_though_there / (missed_though_there + 1.0 - existence);
  }
  return existence;
}

double ExpectedObservations(std::span<const HistoryEntry> history, const SessionTimes& times,
                            const PersistenceOptions& options) {
  if (history.empty()) {
    return 0.0;
  }
  double observations = 0.0, chances = 0.0, latest_chances = 0.0;
  int num_latest = 0;
  for (const HistoryEntry& entry : history) {
    observations += entry.num_observations;
    chances += entry.num_chances;
    if (entry.session_id != SessionId{}) {
      latest_chances += entry.num_chances;
      ++num_latest;
    }
  }
  const double share = chances > 0.0 ? observations / chances : 0.0;
  const double chances_a_session = num_latest > 0 ? latest_chances / num_latest : chances;
  return ExistenceProbability(history, times, options) * share * chances_a_session;
}

}  // namespace cairn
