#include "mapping/session/map_photos.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <memory>
#include <span>
#include <utility>

#include "core/available_memory.h"
#include "core/error.h"
#include "mapping/growth/grown_focals.h"
#include "mapping/matching/calibrate_guesses.h"
#include "mapping/matching/correct_focals.h"
#include "mapping/matching/settle_planes.h"
#include "mapping/session/match_in_parts.h"
#include "mapping/session/photo_places.h"
#include "mapping/session/place_growth.h"
#include "mapping/session/row_jumps.h"
#include "mapping/session/stage_clock.h"
#include "mapping/session/stage_codec.h"
#include "mapping/session/stage_keys.h"
#include "mapping/work_folder.h"

namespace cairn {
namespace {

// Drives of 20 to 51 photos whose guess was 0.7 to 2.4 times the true focal length needed one or
// two.
constexpr int kMaxRegrowths = 2;

// The stages, with the work folder between them.
class Mapper {
 public:
  Mapper(const MapPhotosInput& input, const MappingOptions& options,
         const GeoregisterOptions& georegister, const MapProgress& progress)
      : input_(input), options_(options), georegister_(georegister), progress_(progress) {
    options_.pairs.num_threads = input.num_threads;
    options_.two_views.num_threads = input.num_threads;
    options_.growth.num_threads = input.num_threads;
    options_.adjust.num_threads = input.num_threads;
    options_.pairs.default_accuracy_m =
        std::max(options_.pairs.default_accuracy_m, input.gps_accuracy_m);
    options_.growth.default_gps_accuracy_m =
        std::max(options_.growth.default_gps_accuracy_m, input.gps_accuracy_m);
    if (!input.work_dir.empty()) {
      work_ = std::make_unique<WorkFolder>(input.work_dir);
    }
  }

  MappedPhotos Run() {
    Read();
    Calibrate();
    MappedPhotos mapped = Place(Grow());
    Complete(&mapped);
    return mapped;
  }

 private:
  void Report(const char* phase, int64_t done, int64_t total) const {
    if (progress_) {
      progress_(phase, done, total);
    }
  }
  auto Reporter(const char* phase) const {
    return [this, phase](int done, int total) { Report(phase, done, total); };
  }

  void Read();
  void Calibrate();
  void FindPairsOnce();
  std::vector<TwoView> Match(const char* stage, const std::string& file, const std::string& key,
                             std::span<const std::pair<int, int>> pairs);
  bool LoadCameras(const std::string& file, const std::string& key);
  void ChangeCameras(std::vector<MappingCamera> cameras, const std::string& file,
                     const std::string& key);
  std::vector<TwoView> MatchAndCorrect();
  Growth GrowOnce(bool is_corrected, int num_regrowths);
  Growth Grow();
  MappedPhotos Place(const Growth& growth);
  void Complete(MappedPhotos* mapped);

  const MapPhotosInput& input_;
  MappingOptions options_;
  const GeoregisterOptions& georegister_;
  const MapProgress& progress_;
  std::unique_ptr<WorkFolder> work_;
  PhotoFolder folder_;
  PhotoPlaces places_;
  std::string views_key_, segments_key_;
  std::vector<MappingCamera> cameras_as_read_;  // Those of the set before Calibrate().
  std::optional<std::vector<std::pair<int, int>>> pairs_;
  int num_photos_ = 0;  // Files that were found.
  std::vector<StageCost> stages_;
};

void Mapper::Read() {
  StageClock clock("photos", &stages_);
  folder_ = ReadPhotos(input_.paths, SiftExtractor(options_.sift),
                       {.cameras = input_.cameras,
                        .work = work_.get(),
                        .num_threads = input_.num_threads,
                        .available_bytes = AvailableMemoryBytes(),
                        .descriptors = input_.descriptors,
                        .names_to_keep = NamesInTable(input_)},
                       Reporter("photos"));
  const int num_read = static_cast<int>(folder_.set.photos.size());
  num_photos_ = num_read + static_cast<int>(folder_.left_out.size());
  if (num_read < options_.growth.min_photos) {
    throw Error(ErrorCode::kBadInput,
                fmt::format("{} of {} photos can be read, and a map needs {} that show the same "
                            "place from different places",
                            num_read, num_photos_, options_.growth.min_photos));
  }
  places_ = FindPhotoPlaces(input_, &folder_, &folder_.notes);
  DropJumps(input_.gps_accuracy_m, options_.two_views, &folder_.set);
  views_key_ = ViewsKeyOf(folder_, places_, options_);
  segments_key_ = SegmentsKeyOf(views_key_, options_.growth);
  clock.End(folder_.num_from_work == num_read);
}

std::vector<TwoView> Mapper::Match(const char* stage, const std::string& file,
                                   const std::string& key,
                                   std::span<const std::pair<int, int>> pairs) {
  StageClock clock(stage, &stages_);
  MatchedParts matched = FindTwoViewsInParts(folder_.set, pairs, options_.two_views,
                                             {work_.get(), file, key}, Reporter(stage));
  SettlePlanes(folder_.set, input_.num_threads, &matched.views);
  clock.End(matched.is_from_work);
  return std::move(matched.views);
}

void Mapper::FindPairsOnce() {
  if (!pairs_) {
    StageClock clock("pairs", &stages_);
    const auto stored = work_ ? work_->Load("pairs", views_key_) : std::nullopt;
    if (stored) {
      pairs_ = DecodePairs(*stored, folder_.set, work_->PathOf("pairs"));
    } else {
      pairs_ = FindPairs(folder_.set, options_.pairs, Reporter("pairs"));
    }
    if (work_ && !stored) {
      work_->Store("pairs", views_key_, EncodePairs(*pairs_));
    }
    clock.End(stored.has_value());
  }
}

// Finds focal lengths that nobody knows, before the pairs are matched with them.
void Mapper::Calibrate() {
  cameras_as_read_ = folder_.set.cameras;
  if (!HasGuesses(folder_.set)) {
    return;
  }
  if (work_) {
    StageClock clock("focal lengths", &stages_);
    if (LoadCameras("cameras", views_key_)) {
      clock.End(true);
      return;
    }
  }
  FindPairsOnce();
  const std::vector<TwoView> views =
      Match("calibration", "focal", views_key_, PairsForCalibration(folder_.set, *pairs_));
  StageClock clock("focal lengths", &stages_);
  ChangeCameras(CalibrateGuesses(folder_.set, views, input_.num_threads), "cameras", views_key_);
  clock.End(false);
}

// True if an earlier run changed the cameras at this stage.
bool Mapper::LoadCameras(const std::string& file, const std::string& key) {
  const auto stored = work_ ? work_->Load(file, key) : std::nullopt;
  if (stored) {
    folder_.set.cameras = DecodeCameras(*stored, folder_.set, work_->PathOf(file));
  }
  return stored.has_value();
}

void Mapper::ChangeCameras(std::vector<MappingCamera> cameras, const std::string& file,
                           const std::string& key) {
  folder_.set.cameras = std::move(cameras);
  if (work_) {
    work_->Store(file, key, EncodeCameras(folder_.set.cameras));
  }
}

// Matches once more if the photos contradict focal lengths of their EXIF.
std::vector<TwoView> Mapper::MatchAndCorrect() {
  std::vector<TwoView> views = Match("matching", "views", views_key_, *pairs_);
  StageClock clock("EXIF check", &stages_);
  auto corrected = CorrectFocals(folder_.set, views, input_.num_threads);
  clock.End(false);
  if (!corrected) {
    return views;
  }
  ChangeCameras(std::move(*corrected), "corrected", views_key_);
  return Match("matching again", "again", views_key_, *pairs_);
}

Growth Mapper::GrowOnce(bool is_corrected, int num_regrowths) {
  std::vector<TwoView> views;
  if (num_regrowths > 0) {
    views =
        Match("matching again", fmt::format("regrown-{}", num_regrowths), segments_key_, *pairs_);
  } else if (is_corrected) {
    views = Match("matching again", "again", views_key_, *pairs_);
  } else {
    views = MatchAndCorrect();
  }
  StageClock clock("growth", &stages_);
  if (input_.descriptors) {
    input_.descriptors->EmptyCache();  // The growth takes the most memory.
  }
  Report("growth", 0, std::ssize(folder_.set.photos));
  Growth growth = GrowSegments(folder_.set, views, options_.growth, Reporter("growth"),
                               Reporter("growth: adjustment"));
  clock.End(false);
  return growth;
}

// Grows again while the segments find focal lengths that their two views did not tell.
Growth Mapper::Grow() {
  const bool is_corrected = LoadCameras("corrected", views_key_);
  int num_regrowths = 0;
  const auto cameras_file = [&] { return fmt::format("grown-{}", num_regrowths); };
  while (num_regrowths < kMaxRegrowths && LoadCameras(cameras_file(), segments_key_)) {
    ++num_regrowths;
  }
  if (work_) {
    StageClock clock("growth", &stages_);
    if (const auto stored = work_->Load("segments", segments_key_)) {
      Growth growth = DecodeGrowth(*stored, folder_.set, work_->PathOf("segments"));
      clock.End(true);
      return growth;
    }
  }
  FindPairsOnce();
  while (true) {
    Growth growth = GrowOnce(is_corrected, num_regrowths);
    auto cameras =
        num_regrowths < kMaxRegrowths ? GrownFocals(folder_.set, growth.segments) : std::nullopt;
    if (!cameras) {
      if (work_) {
        work_->Store("segments", segments_key_, EncodeGrowth(growth));
      }
      return growth;
    }
    ChangeCameras(std::move(*cameras), cameras_file(), segments_key_);
    ++num_regrowths;
  }
}

MappedPhotos Mapper::Place(const Growth& growth) {
  StageClock clock("placement", &stages_);
  PlacedGrowth placed =
      PlaceGrowth(growth, folder_.set, places_, cameras_as_read_,
                  {.georegister = georegister_,
                   .adjust = options_.adjust,
                   .keeps_unplaced = input_.keeps_unplaced,
                   .work = work_.get(),
                   .key = PlacementKeyOf(segments_key_, options_.adjust, georegister_),
                   .progress = progress_});
  clock.End(placed.is_from_work);
  return std::move(placed.mapped);
}

// What is known of the photos since they were read, and the stages.
void Mapper::Complete(MappedPhotos* mapped) {
  mapped->num_photos = num_photos_;
  std::ranges::move(folder_.left_out, std::back_inserter(mapped->left_out));
  std::ranges::sort(mapped->left_out, {}, &LeftOutPhoto::name);
  mapped->notes.insert(mapped->notes.begin(), folder_.notes.begin(), folder_.notes.end());
  mapped->stages = std::move(stages_);
}

}  // namespace

MappedPhotos MapPhotos(const MapPhotosInput& input, const MappingOptions& options,
                       const GeoregisterOptions& georegister, const MapProgress& progress) {
  options.Validate();
  georegister.Validate();
  return Mapper(input, options, georegister, progress).Run();
}

}  // namespace cairn
