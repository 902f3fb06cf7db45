#include "cli/codebook_hint.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>

#include "core/printable.h"
#include "ingest/codebook/train_codebook.h"

namespace cairn {
namespace {

// After a version of these kinds, the codebook need not be that of the first ingest.
bool MayChangeCodebook(const VersionRecord& version) {
  constexpr VersionKind kKinds[] = {VersionKind::kRecode, VersionKind::kMerge,
                                    VersionKind::kExtract, VersionKind::kRollback};
  return std::ranges::any_of(
      kKinds, [&](VersionKind kind) { return version.kind == VersionKindName(kind); });
}

}  // namespace

std::optional<std::string> SessionThatTrained(const std::vector<VersionRecord>& versions,
                                              bool codebook_is_shipped) {
  const bool is_complete =
      !versions.empty() && versions.back().kind == VersionKindName(VersionKind::kCreate);
  if (codebook_is_shipped || !is_complete || std::ranges::any_of(versions, MayChangeCodebook)) {
    return std::nullopt;
  }
  const auto first =
      std::find_if(versions.rbegin(), versions.rend(), [](const VersionRecord& version) {
        return version.kind == VersionKindName(VersionKind::kIngest);
      });
  return first == versions.rend() ? std::nullopt : std::optional(first->session);
}

const SessionRecord* SessionToTrainOn(const std::vector<SessionRecord>& sessions,
                                      const std::optional<std::string>& trained_on,
                                      bool codebook_is_shipped) {
  if (sessions.empty() || (!codebook_is_shipped && !trained_on)) {
    return nullptr;
  }
  const auto largest = std::ranges::max_element(sessions, {}, &SessionRecord::num_landmarks);
  // A landmark has two descriptors or more.
  if (2 * largest->num_landmarks < CodebookOptions().min_training_descriptors) {
    return nullptr;
  }
  if (codebook_is_shipped) {
    return &*largest;
  }
  const auto trainer = std::ranges::find(sessions, *trained_on, &SessionRecord::name);
  const int64_t num_trained = trainer == sessions.end() ? 0 : trainer->num_landmarks;
  return largest->num_landmarks >= kOutgrownFactor * num_trained ? &*largest : nullptr;
}

std::string RecodeHint(const SessionRecord& session, const std::string& map_path) {
  return fmt::format(
      "session {} has {} landmarks and would train a codebook with which queries find more "
      "matches: ingest it into a map of its own with --codebook trained, then run cairn recode {} "
      "--codebook THAT_MAP",
      Excerpt(session.name), session.num_landmarks, Printable(map_path));
}

}  // namespace cairn
