#include "mapping/session/map_photos.h"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
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
#include "mapping/session/edited_photos.h"
#include "mapping/session/match_in_parts.h"
#include "mapping/session/photo_places.h"
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
    if (!input.work_dir.empty()) {
      work_ = std::make_unique<WorkFolder>(input.work_dir);
    }
  }

  MappedPhotos Run() {
    Read();
    Calibrate();
    const Growth growth = Grow();
    Place(growth);
    return std::move(result_);
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
  void Place(const Growth& growth);
  void PlaceOne(const Segment& segment);
  void LeaveOut(const Segment& segment, const std::string& problem, const std::string& reason);
  void Add(const PlacedSegment& placed);
  void FillImages();
  void ReportCameras();
  void ReportLeftOut(const Growth& growth);

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
  MappedPhotos result_;
};

void Mapper::Read() {
  StageClock clock("photos", &result_.stages);
  folder_ = ReadPhotos(input_.paths,
                       {.cameras = input_.cameras,
                        .sift = options_.sift,
                        .work = work_.get(),
                        .num_threads = input_.num_threads,
                        .available_bytes = AvailableMemoryBytes(),
                        .names_to_keep = NamesInTable(input_)},
                       Reporter("photos"));
  const int num_read = static_cast<int>(folder_.set.photos.size());
  result_.num_photos = num_read + static_cast<int>(folder_.left_out.size());
  result_.left_out = folder_.left_out;
  result_.notes = folder_.notes;
  if (num_read < options_.growth.min_photos) {
    throw Error(ErrorCode::kBadInput,
                fmt::format("{} of {} photos can be read, and a map needs {} that show the same "
                            "place from different places",
                            num_read, result_.num_photos, options_.growth.min_photos));
  }
  places_ = FindPhotoPlaces(input_, &folder_, &result_.notes);
  DropJumps(input_.gps_accuracy_m, options_.two_views, &folder_.set);
  views_key_ = ViewsKeyOf(folder_, places_, options_);
  segments_key_ = SegmentsKeyOf(views_key_, options_.growth);
  clock.End(folder_.num_from_work == num_read);
}

std::vector<TwoView> Mapper::Match(const char* stage, const std::string& file,
                                   const std::string& key,
                                   std::span<const std::pair<int, int>> pairs) {
  StageClock clock(stage, &result_.stages);
  bool is_from_work = false;
  std::vector<TwoView> views =
      FindTwoViewsInParts(folder_.set, pairs, options_.two_views, {work_.get(), file, key},
                          Reporter(stage), &is_from_work);
  SettlePlanes(folder_.set, input_.num_threads, &views);
  clock.End(is_from_work);
  return views;
}

void Mapper::FindPairsOnce() {
  if (!pairs_) {
    StageClock clock("pairs", &result_.stages);
    pairs_ = FindPairs(folder_.set, options_.pairs, Reporter("pairs"));
    clock.End(false);
  }
}

// Finds focal lengths that nobody knows, before the pairs are matched with them.
void Mapper::Calibrate() {
  cameras_as_read_ = folder_.set.cameras;
  if (!HasGuesses(folder_.set)) {
    return;
  }
  if (work_) {
    StageClock clock("focal lengths", &result_.stages);
    if (LoadCameras("cameras", views_key_)) {
      clock.End(true);
      return;
    }
  }
  FindPairsOnce();
  const std::vector<TwoView> views =
      Match("calibration", "focal", views_key_, PairsForCalibration(folder_.set, *pairs_));
  StageClock clock("focal lengths", &result_.stages);
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
  StageClock clock("EXIF check", &result_.stages);
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
  StageClock clock("growth", &result_.stages);
  Growth growth = GrowSegments(folder_.set, views, options_.growth, Reporter("growth"));
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
    StageClock clock("growth", &result_.stages);
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

void Mapper::Place(const Growth& growth) {
  if (growth.segments.empty()) {
    throw Error(ErrorCode::kBadInput,
                fmt::format("no three of the {} photos show the same place from different places. "
                            "Take a photo every two or three steps, not only turning on the spot",
                            folder_.set.photos.size()));
  }
  StageClock clock("placement", &result_.stages);
  result_.position_of_photo.resize(folder_.set.photos.size());
  result_.center_of_photo.resize(folder_.set.photos.size());
  std::exception_ptr first_problem;
  const auto num_segments = std::ssize(growth.segments);
  for (size_t i = 0; i < growth.segments.size(); ++i) {
    Report("placement", static_cast<int64_t>(i), num_segments);
    try {
      PlaceOne(growth.segments[i]);
    } catch (const Error& error) {
      if (error.code() != ErrorCode::kBadInput && error.code() != ErrorCode::kInternal) {
        throw;
      }
      if (!first_problem) {
        first_problem = std::current_exception();
      }
      LeaveOut(growth.segments[i], error.what(), "has no place of its own");
    }
  }
  if (result_.model.images.empty()) {
    std::rethrow_exception(first_problem);
  }
  Report("placement", num_segments, num_segments);
  ReportLeftOut(growth);
  ReportCameras();
  FillImages();
  clock.End(false);
}

void Mapper::PlaceOne(const Segment& segment) {
  const PlacedSegment placed =
      PlaceSegment(folder_.set, places_, segment, georegister_, options_.adjust);
  Add(placed);
  std::ranges::move(NotesOnOutliers(placed.georegistration), std::back_inserter(result_.notes));
  result_.segments.push_back({.num_photos = static_cast<int>(segment.photo_of_image.size()),
                              .georegistration = placed.georegistration,
                              .adjustment = placed.adjustment});
}

// `problem` is of the segment, `reason` completes a sentence about each of its photos.
void Mapper::LeaveOut(const Segment& segment, const std::string& problem,
                      const std::string& reason) {
  SegmentReport report;
  report.num_photos = static_cast<int>(segment.photo_of_image.size());
  report.problem = problem;
  for (const int photo : segment.photo_of_image) {
    result_.left_out.push_back(
        {folder_.set.photos[photo].name,
         fmt::format("is in a part of {} photos that is not connected to the others and {}",
                     report.num_photos, reason)});
  }
  result_.segments.push_back(std::move(report));
}

// Appends the segment to the model, in whose world it is moved.
void Mapper::Add(const PlacedSegment& placed) {
  Reconstruction& model = result_.model;
  if (model.images.empty()) {
    result_.ecef_from_world = placed.georegistration.ecef_from_world;
    result_.georegistration = placed.georegistration;
  }
  TakeWorst(placed.georegistration, &result_.georegistration);
  const Sim3d world_from_segment =
      Rigid3d(result_.ecef_from_world.rotation, result_.ecef_from_world.translation).Inverse() *
      placed.georegistration.ecef_from_world;
  const int first_camera = static_cast<int>(model.cameras.size());
  const int first_image = static_cast<int>(model.images.size());
  const Reconstruction& part = placed.segment.model;
  model.cameras.insert(model.cameras.end(), part.cameras.begin(), part.cameras.end());
  for (size_t i = 0; i < part.images.size(); ++i) {
    ReconImage image = part.images[i];
    image.camera_idx += first_camera;
    image.cam_from_world = CamFromTarget(image.cam_from_world, world_from_segment);
    const int photo = placed.segment.photo_of_image[i];
    result_.center_of_photo[photo] = image.cam_from_world.Inverse().translation;
    result_.photo_of_image.push_back(photo);
    result_.segment_of_image.push_back(static_cast<int>(result_.segments.size()));
    model.images.push_back(std::move(image));
  }
  for (ReconLandmark landmark : part.landmarks) {
    landmark.x_in_world = world_from_segment * landmark.x_in_world;
    for (ReconObservation& seen : landmark.observations) {
      seen.image_idx += first_image;
    }
    model.landmarks.push_back(std::move(landmark));
  }
}

// Gives the images of the model their descriptors, which the set then no longer has.
void Mapper::FillImages() {
  const Sim3d world_from_ecef = result_.ecef_from_world.Inverse();
  for (size_t i = 0; i < folder_.set.photos.size(); ++i) {
    if (const auto& position = places_.positions[i]) {
      result_.position_of_photo[i] = world_from_ecef * EcefFromGeodetic(position->position);
    }
  }
  for (size_t i = 0; i < result_.model.images.size(); ++i) {
    ByteDescriptorMatrix& descriptors = folder_.set.photos[result_.photo_of_image[i]].descriptors;
    result_.model.images[i].features.descriptors = PackedDescriptors(std::move(descriptors));
  }
  result_.num_mapped = static_cast<int>(result_.model.images.size());
  result_.model.Validate();
}

void Mapper::ReportCameras() {
  const size_t num_cameras = folder_.set.cameras.size();
  std::vector<int> num_photos(result_.model.cameras.size(), 0);
  for (const ReconImage& image : result_.model.images) {
    ++num_photos[image.camera_idx];
  }
  for (size_t i = 0; i < result_.model.cameras.size(); ++i) {
    const MappingCamera& before = cameras_as_read_[i % num_cameras];
    if (num_photos[i] > 0) {
      result_.cameras.push_back(
          {result_.model.cameras[i], before.camera.focal_px(), before.source, num_photos[i]});
    }
  }
  std::ranges::move(NotesOnEditedPhotos(result_.model, cameras_as_read_),
                    std::back_inserter(result_.notes));
}

void Mapper::ReportLeftOut(const Growth& growth) {
  for (size_t i = 0; i < growth.verdict_of_photo.size(); ++i) {
    if (growth.verdict_of_photo[i] != PhotoVerdict::kInSegment) {
      result_.left_out.push_back(
          {folder_.set.photos[i].name, ExplainVerdict(growth.verdict_of_photo[i])});
    }
  }
  std::ranges::sort(result_.left_out, {}, &LeftOutPhoto::name);
}

}  // namespace

MappedPhotos MapPhotos(const MapPhotosInput& input, const MappingOptions& options,
                       const GeoregisterOptions& georegister, const MapProgress& progress) {
  options.Validate();
  georegister.Validate();
  return Mapper(input, options, georegister, progress).Run();
}

}  // namespace cairn
