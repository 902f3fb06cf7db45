#include "ingest/maps/merge_maps.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "core/error.h"
#include "core/printable.h"
#include "core/require.h"
#include "ingest/join_tiles.h"
#include "ingest/maps/meet_maps.h"
#include "ingest/maps/merge_source.h"
#include "ingest/session_digest.h"
#include "ingest/session_placement.h"
#include "ingest/tiles/tile_edit.h"
#include "ingest/tiles/viewpoints.h"
#include "ingest/tiles/write_tile.h"

namespace cairn {
namespace {

// Makes both maps come in one codebook. Returns the codebook, null if neither map has one. A map
// without sessions has none.
std::shared_ptr<const Codebook> RequireOneCodebook(const MergeSource& a, bool recode,
                                                   MergeSource* b) {
  const auto of_a = a.codebook();
  const auto of_b = b->codebook();
  if (!of_a || !of_b) {
    return of_a ? of_a : of_b;
  }
  const std::string reason = WhyNotTranscodable(*of_a, *of_b);
  if (!reason.empty()) {
    throw Error(ErrorCode::kBadInput,
                fmt::format("{} and {} cannot be merged: {}", a.path(), b->path(), reason));
  }
  const std::string digest_a = a.snapshot().CodebookDigest(of_a->id);
  const std::string digest_b = b->snapshot().CodebookDigest(of_b->id);
  if (digest_a == digest_b) {
    return of_a;
  }
  if (!recode) {
    throw Error(ErrorCode::kConflict,
                fmt::format("{0} is coded with codebook {1}, {2} with codebook {3}; run `cairn "
                            "recode {2} --codebook {0}` first, or merge with --recode",
                            a.path(), digest_a, b->path(), digest_b));
  }
  b->RecodeTo(of_a);
  return of_a;
}

void RequireDistinctSessions(const MergeSource& a, const MergeSource& b, SessionJoining joining) {
  const std::vector<SessionRecord> sessions_of_b = b.snapshot().Sessions();
  for (const SessionRecord& of_a : a.snapshot().Sessions()) {
    for (const SessionRecord& of_b : sessions_of_b) {
      if (of_a.name == of_b.name) {
        throw Error(ErrorCode::kConflict,
                    fmt::format("{} and {} both have a session '{}'; ingest it under another name "
                                "or remove it from one of them",
                                a.path(), b.path(), Excerpt(of_a.name)));
      }
      if (joining == SessionJoining::kJoin && AreOneRecording(of_a, of_b)) {
        throw Error(ErrorCode::kConflict,
                    fmt::format("session '{}' of {} and session '{}' of {} are the same recording; "
                                "remove it from one of them, or keep both apart (--apart)",
                                Excerpt(of_a.name), a.path(), Excerpt(of_b.name), b.path()));
      }
      if (joining == SessionJoining::kApart) {
        continue;
      }
      const SharedPhotos shared = CountSharedPhotos(of_a, of_b);
      if (!AreMostlyNew(shared)) {
        throw Error(
            ErrorCode::kConflict,
            fmt::format("session '{}' of {} and session '{}' of {} share {} of the {} photos that "
                        "were compared; remove one of them, or keep both apart (--apart)",
                        Excerpt(of_a.name), a.path(), Excerpt(of_b.name), b.path(),
                        shared.num_shared, shared.num_compared));
      }
    }
  }
}

// A turn that fits where the maps meet must not carry the rest of b away.
void RequireNearMove(const Sim3d& moved_from_ecef, const MergeSource& b,
                     const MotionLimits& limits) {
  for (const TileId tile_id : b.TileIds()) {
    const Eigen::Vector3d anchor = EcefFromEnu(tile_id.Anchor()).translation;
    const double moved_m = (moved_from_ecef * anchor - anchor).norm();
    if (moved_m > limits.moved_m) {
      throw Error(ErrorCode::kConflict,
                  fmt::format("{}: fits the other map where both meet, but its tile {} would move "
                              "by {:.2f} m (allowed: {:.1f} m). Extract the part that meets the "
                              "other map, or keep both apart (--apart)",
                              b.path(), tile_id.ToString(), moved_m, limits.moved_m));
    }
  }
}

// Notes the chances of each session of `fresh` at landmarks that `fresh` lacks. Those that it has
// bring theirs along.
void NoteMisses(const Tile& fresh, const std::map<KeyframeId, const Camera*>& cameras,
                const ViewpointOptions& viewpoints, Tile* tile) {
  const std::set<LandmarkId> own(fresh.landmark_ids.begin(), fresh.landmark_ids.end());
  std::set<SessionId> sessions;
  for (const TileKeyframe& keyframe : fresh.keyframes) {
    sessions.insert(keyframe.session_id);
  }
  for (const SessionId session_id : sessions) {
    std::vector<int> chances = CountChances(*tile, session_id, cameras, viewpoints);
    for (size_t i = 0; i < chances.size(); ++i) {
      if (own.contains(tile->landmark_ids[i])) {
        chances[i] = 0;
      }
    }
    NoteChances(chances, session_id, tile);
  }
}

// The tiles of both maps, and in how many of the maps each is.
std::map<TileId, int> CountTiles(const MergeSource& a, const MergeSource& b) {
  std::map<TileId, int> counts;
  for (const MergeSource* source : {&a, &b}) {
    for (const TileId tile_id : source->TileIds()) {
      ++counts[tile_id];
    }
  }
  return counts;
}

std::vector<TileId> TilesOfBoth(const MergeSource& a, const MergeSource& b) {
  std::vector<TileId> tiles;
  for (const auto& [tile_id, num_maps] : CountTiles(a, b)) {
    if (num_maps == 2) {
      tiles.push_back(tile_id);
    }
  }
  return tiles;
}

// How b moves.
Sim3d MotionOf(const MergeReport& report) {
  return IsJudged(report.comparison) ? report.comparison.fit.map_from_session : Sim3d();
}

PositionAccuracies AccuracyOfMaps(const MergeSource& a, const MergeSource& b,
                                  const AgreementOptions& options,
                                  const MapComparison& comparison) {
  double worst_of_b_m = 0.0;
  for (const SessionRecord& session : b.snapshot().Sessions()) {
    worst_of_b_m = std::max(worst_of_b_m, session.georef_median_residual_m);
  }
  return AccuracyOf(comparison, std::max(options.position_accuracy_m, worst_of_b_m), worst_of_b_m,
                    a.snapshot().Sessions());
}

// Moves b to where a sees it, and links its landmarks to those of a.
void Meet(const MergeSource& a, const MapMergeOptions& options, MergeSource* b,
          MergeReport* report) {
  if (a.codebook() == nullptr || b->codebook() == nullptr) {
    return;
  }
  report->comparison = CompareMaps(a, *b, options.num_threads);
  const MapComparison& comparison = report->comparison;
  const PositionAccuracies accuracy = AccuracyOfMaps(a, *b, options.agreement, comparison);
  RequireAgreement(comparison, options.agreement, accuracy, b->path());
  if (IsJudged(comparison)) {
    RequireNearMove(MotionOf(*report), *b, LimitsOf(comparison, options.agreement, accuracy));
    b->Move(MotionOf(*report));
  }
  b->Link(
      LinkMaps(a, *b, TilesOfBoth(a, *b), DescriptorCodec(a.codebook()), options.upkeep.linking));
}

// Writes the tiles of two maps into a third.
class MapMerger {
 public:
  MapMerger(const MapMergeOptions& options, MergeSource* a, MergeSource* b, MapUpdate* update,
            MergeReport* report)
      : options_(options), a_(a), b_(b), update_(update), report_(report) {}

  void Merge(const Codebook& codebook, const std::map<TileId, int>& tiles,
             const std::function<void(int64_t, int64_t)>& progress) {
    Codebook merged_codebook = codebook;
    merged_codebook.id = update_->AddCodebook(codebook);
    a_->CopySessions(merged_codebook.id, update_);
    b_->CopySessions(merged_codebook.id, update_);
    const DescriptorCodec codec(std::make_shared<const Codebook>(merged_codebook));
    const auto summarizer = MakeAppearanceSummarizer(options_.appearance);
    const auto selector = MakeLandmarkSelector(options_.selection);
    const SessionTimes times = TimesOf(update_->Sessions());
    const TileJoinContext context = {.upkeep = &options_.upkeep,
                                     .selection = &options_.selection,
                                     .codec = &codec,
                                     .summarizer = summarizer.get(),
                                     .selector = selector.get(),
                                     .session_times = &times,
                                     .is_judged = IsJudged(report_->comparison)};
    int64_t num_done = 0;
    for (const auto& [tile_id, num_maps] : tiles) {
      std::optional<Tile> tile = a_->LoadRenumbered(tile_id, *b_);
      std::optional<Tile> other = b_->LoadRenumbered(tile_id, *a_);
      if (tile && other) {
        *tile = Combine(*tile, *other, context);
      }
      Write(tile ? *tile : *other, merged_codebook);
      if (progress) {
        progress(++num_done, std::ssize(tiles));
      }
    }
  }

 private:
  void Write(const Tile& tile, const Codebook& codebook) {
    const EncodedTile encoded = EncodeForMap(tile, codebook);
    PutTile(encoded, update_);
    report_->changes.num_bytes_after += std::ssize(encoded.payload);
    if (encoded.decoded != nullptr) {
      a_->tiles().memory()->Keep(encoded.payload, encoded.decoded);
    }
  }

  Tile Combine(const Tile& of_a, const Tile& of_b, const TileJoinContext& context) {
    ++report_->num_tiles_of_both;
    if (options_.joining == SessionJoining::kApart) {
      Tile both = of_a;
      AppendTile(of_b, &both);
      return both;
    }
    const std::vector<KeyframeRecord> keyframes = update_->KeyframesOfTile(of_a.id);
    std::map<KeyframeId, const Camera*> cameras;
    for (const KeyframeRecord& keyframe : keyframes) {
      cameras[keyframe.id] = &keyframe.camera;
    }
    const auto note_misses = [&](Tile* tile) {
      NoteMisses(of_b, cameras, options_.upkeep.viewpoints, tile);
    };
    JoinedTile joined = JoinTiles(of_a, of_b, note_misses, context);
    for (const KeyframeId id : joined.replaced_keyframes) {
      update_->RemoveKeyframe(id);
    }
    report_->changes.Add(joined.changes);
    return std::move(joined.tile);
  }

  const MapMergeOptions& options_;
  MergeSource* a_;
  MergeSource* b_;
  MapUpdate* update_;
  MergeReport* report_;
};

std::vector<Eigen::Vector3d> PlacesOfKeyframes(const MergeSource& map,
                                               const Sim3d& moved_from_ecef) {
  std::vector<Eigen::Vector3d> places;
  for (const SessionRecord& session : map.snapshot().Sessions()) {
    for (const KeyframeRecord& keyframe : map.snapshot().KeyframesOfSession(session.id)) {
      places.push_back(moved_from_ecef * keyframe.cam_from_ecef.Inverse().translation);
    }
  }
  return places;
}

// Asks keyframes of one map near those of the other.
KeyframeAnswers AskKeyframesOf(const MergeSource& source, const Sim3d& moved_from_ecef,
                               const std::vector<Eigen::Vector3d>& news_in_ecef,
                               const MapStore& merged, int num_threads) {
  const MapSnapshot after = merged.Snapshot();
  return AskKeyframes(KeyframesNear(source.snapshot(), news_in_ecef, moved_from_ecef, SessionId{}),
                      source.tiles(), RememberedTiles(after, source.tiles().memory()),
                      moved_from_ecef, num_threads);
}

void RequireAnswersIfJoined(const KeyframeAnswers& answers, const MapMergeOptions& options,
                            const MergeSource& b) {
  if (options.joining == SessionJoining::kJoin) {
    RequireAnswers(answers, options.gate, b.path());
  }
}

void RequireKeyframesOfBoth(const MergeSource& a, const MergeSource& b,
                            const MapMergeOptions& options, const MapStore& merged,
                            MergeReport* report) {
  if (options.gate.max_lost_share >= 1.0 || a.codebook() == nullptr || b.codebook() == nullptr) {
    return;
  }
  const Sim3d b_motion = MotionOf(*report);
  KeyframeAnswers answers =
      AskKeyframesOf(a, Sim3d(), PlacesOfKeyframes(b, b_motion), merged, options.num_threads);
  RequireAnswersIfJoined(answers, options, b);
  if (a.snapshot().CodebookDigest(a.codebook()->id) ==
      b.snapshot().CodebookDigest(b.codebook()->id)) {
    const KeyframeAnswers of_b =
        AskKeyframesOf(b, b_motion, PlacesOfKeyframes(a, Sim3d()), merged, options.num_threads);
    RequireAnswersIfJoined(of_b, options, b);
    answers.Add(of_b);
  }
  report->keyframe_answers = answers;
}

int64_t PayloadBytes(const MergeSource& source) { return source.snapshot().Info().payload_bytes; }

}  // namespace

void MapMergeOptions::Validate() const {
  selection.Validate();
  appearance.Validate();
  agreement.Validate();
  gate.Validate();
  RequireOption(num_threads >= 1, "merge.num_threads must be at least 1");
  upkeep.Validate();
}

MergeReport MergeMaps(const MapStore& a, const MapStore& b, const std::string& to,
                      const MapMergeOptions& options,
                      const std::function<void(int64_t, int64_t)>& progress) {
  options.Validate();
  const auto memory = std::make_shared<TileMemory>();
  MergeSource source_a(a, memory);
  MergeSource source_b(b, memory);
  const std::shared_ptr<const Codebook> codebook =
      RequireOneCodebook(source_a, options.recode, &source_b);
  RequireDistinctSessions(source_a, source_b, options.joining);
  MergeReport report;
  MapStore::CreateFilled(to, [&](MapStore* store) {
    if (options.joining == SessionJoining::kJoin) {
      Meet(source_a, options, &source_b, &report);
    }
    const std::map<TileId, int> tiles = CountTiles(source_a, source_b);
    MapUpdate update = store->BeginUpdate();
    report.changes.num_bytes_before = PayloadBytes(source_a) + PayloadBytes(source_b);
    if (codebook != nullptr) {
      MapMerger(options, &source_a, &source_b, &update, &report).Merge(*codebook, tiles, progress);
    }
    update.Publish({.kind = VersionKind::kMerge,
                    .summary = source_a.Describe() + " and " + source_b.Describe()});
    RequireKeyframesOfBoth(source_a, source_b, options, *store, &report);
    report.totals = store->Snapshot().Info();
  });
  return report;
}

}  // namespace cairn
