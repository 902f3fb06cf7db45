// All that an options file may set, for every verb: one file serves `cairn ingest` and `cairn
// serve`.
#ifndef CAIRN_CLI_OPTIONS_CAIRN_OPTIONS_H_
#define CAIRN_CLI_OPTIONS_CAIRN_OPTIONS_H_

#include "cli/options/option_list.h"
#include "core/features/sift/sift_extractor.h"
#include "engine/localizer_options.h"
#include "eval/eval_query.h"
#include "http/service/server_options.h"
#include "ingest/ingest_session.h"
#include "ingest/place/georegister.h"
#include "mapping/session/map_photos.h"

namespace cairn {

struct CairnOptions {
  LocalizerOptions localizer;  // Its stages are sections of the top level.
  SiftOptions sift;
  ServerOptions server;  // Without the address and the map, which the command line names.
  IngestOptions ingest;  // Without the names of the session and its source.
  GeoregisterOptions georegister;
  MappingOptions mapping;
  PriorNoiseOptions noise;  // Without the seed, which is that of the localizer.

  // Throws Error(kInvalidArgument) naming the option.
  void Validate() const;
};

// The names --index takes. Exhaustive search is not among them; it is for tests.
inline constexpr EnumName<IndexKind> kIndexKindNames[] = {
    {"random_grids", IndexKind::kRandomGrids}, {"inverted_lists", IndexKind::kInvertedLists}};

// The names --codebook of `cairn ingest` takes.
inline constexpr EnumName<CodebookSource> kCodebookSourceNames[] = {
    {"auto", CodebookSource::kAuto},
    {"shipped", CodebookSource::kShipped},
    {"trained", CodebookSource::kTrained}};

// The names --selection takes.
inline constexpr EnumName<LandmarkSelectionKind> kLandmarkSelectionNames[] = {
    {"observation_count", LandmarkSelectionKind::kObservationCount},
    {"coverage", LandmarkSelectionKind::kCoverage}};

// The names --up takes.
inline constexpr EnumName<UpSource> kUpSourceNames[] = {
    {"auto", UpSource::kAuto},     {"positions", UpSource::kPositions},
    {"photos", UpSource::kPhotos}, {"top", UpSource::kTop},
    {"left", UpSource::kLeft},     {"right", UpSource::kRight},
    {"bottom", UpSource::kBottom}, {"down", UpSource::kDown}};

// The descriptions. Options that only tests set are left out. CairnOptions is the top level.
void DescribeLocalizer(LocalizerOptions* options, OptionList* list);
void DescribeIngest(IngestOptions* options, OptionList* list);
void DescribeMapping(MappingOptions* options, OptionList* list);
void DescribeSift(SiftOptions* options, OptionList* list);
OptionList Describe(CairnOptions* options);

}  // namespace cairn

#endif  // CAIRN_CLI_OPTIONS_CAIRN_OPTIONS_H_
