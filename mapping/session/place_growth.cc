#include "mapping/session/place_growth.h"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <iterator>
#include <optional>
#include <utility>
#include <vector>

#include "core/angles.h"
#include "core/error.h"
#include "core/statistics.h"
#include "mapping/session/add_segment.h"
#include "mapping/session/edited_photos.h"
#include "mapping/session/stage_codec.h"

namespace cairn {
namespace {

class Placement {
 public:
  Placement(const PhotoPlaces& places, std::span<const MappingCamera> cameras_as_read,
            const PlaceGrowthOptions& options, const PhotoSet& set)
      : places_(places), cameras_as_read_(cameras_as_read), options_(options), set_(set) {
    result_.position_of_photo.resize(set_.photos.size());
    result_.center_of_photo.resize(set_.photos.size());
  }

  PlacedGrowth Run(const Growth& growth) {
    PlaceAll(growth.segments);
    ReportLeftOut(growth);
    std::ranges::move(NotesOnEditedPhotos(result_.model, cameras_as_read_),
                      std::back_inserter(result_.notes));
    FillImages();
    return {std::move(result_), options_.work != nullptr && is_from_work_};
  }

 private:
  void PlaceAll(const std::vector<Segment>& segments);
  void Place(const Segment& segment, int number);
  AdjustedSegment Adjusted(const Segment& segment, int number);
  void LeaveOut(const Segment& segment, const std::string& problem);
  void Keep(const Segment& segment, int number, const std::string& problem);
  void StandAtPositions();
  void ReportLeftOut(const Growth& growth);
  void FillImages();
  void FillDescriptors(const std::vector<int>& photo_of_image, Reconstruction* model) const;

  const PhotoPlaces& places_;
  const std::span<const MappingCamera> cameras_as_read_;
  const PlaceGrowthOptions& options_;
  const PhotoSet& set_;
  bool is_from_work_ = true;
  MappedPhotos result_;
};

void Placement::PlaceAll(const std::vector<Segment>& segments) {
  std::exception_ptr first_problem;
  const auto count = std::ssize(segments);
  for (size_t i = 0; i < segments.size(); ++i) {
    if (options_.progress) {
      options_.progress("placement", static_cast<int64_t>(i), count);
    }
    const int number = static_cast<int>(i);
    try {
      Place(segments[i], number);
    } catch (const Error& error) {
      if (error.code() != ErrorCode::kBadInput && error.code() != ErrorCode::kInternal) {
        throw;
      }
      first_problem = first_problem ? first_problem : std::current_exception();
      if (options_.keeps_unplaced && error.code() == ErrorCode::kBadInput) {
        Keep(segments[i], number, error.what());
      }
      LeaveOut(segments[i], error.what());
    }
  }
  if (result_.model.images.empty()) {
    if (result_.unplaced.empty()) {
      std::rethrow_exception(first_problem);
    }
    StandAtPositions();
  }
  if (options_.progress) {
    options_.progress("placement", count, count);
  }
}

void Placement::Place(const Segment& segment, int number) {
  const PlacedSegment placed =
      PlaceSegment(places_, Adjusted(segment, number), options_.georegister);
  const Georegistration& georegistration = placed.georegistration;
  if (result_.model.images.empty()) {
    result_.ecef_from_world = georegistration.ecef_from_world;
    result_.georegistration = georegistration;
  }
  TakeWorst(georegistration, &result_.georegistration);
  AddSegment(placed.segment, georegistration.ecef_from_world, number, &result_, &result_.model);
  std::ranges::move(ReportCameras(placed.segment, cameras_as_read_),
                    std::back_inserter(result_.cameras));
  std::ranges::move(NotesOnOutliers(georegistration), std::back_inserter(result_.notes));
  result_.segments.push_back({.num_photos = static_cast<int>(segment.photo_of_image.size()),
                              .georegistration = georegistration,
                              .adjustment = placed.adjustment});
}

AdjustedSegment Placement::Adjusted(const Segment& segment, int number) {
  const WorkFolder* work = options_.work;
  const std::string file = fmt::format("adjusted-{}", number);
  if (const auto stored = work ? work->Load(file, options_.key) : std::nullopt) {
    return DecodeAdjusted(*stored, set_, work->PathOf(file));
  }
  is_from_work_ = false;
  AdjustedSegment adjusted = AdjustToPositions(
      set_, places_, segment, options_.georegister, options_.adjust, [&](int done, int most) {
        if (options_.progress) {
          options_.progress("placement: adjustment", done, most);
        }
      });
  if (work) {
    work->Store(file, options_.key, EncodeAdjusted(adjusted));
  }
  return adjusted;
}

void Placement::LeaveOut(const Segment& segment, const std::string& problem) {
  SegmentReport report;
  report.num_photos = static_cast<int>(segment.photo_of_image.size());
  report.problem = problem;
  for (const int photo : segment.photo_of_image) {
    result_.left_out.push_back(
        {set_.photos[photo].name,
         fmt::format("is in a part of {} photos that is not connected to the others and has no "
                     "place of its own",
                     report.num_photos)});
  }
  result_.segments.push_back(std::move(report));
}

// Keeps a segment for the map if one of its photos has a position, which says where to ask.
void Placement::Keep(const Segment& segment, int number, const std::string& problem) {
  UnplacedSegment unplaced = {
      segment, number, problem, ReportCameras(segment, cameras_as_read_), {}};
  for (const int photo : segment.photo_of_image) {
    const std::optional<CameraPosition>& position = places_.positions[photo];
    unplaced.positions.push_back(position ? std::optional(position->position) : std::nullopt);
  }
  if (std::ranges::any_of(unplaced.positions,
                          [](const auto& position) { return position.has_value(); })) {
    result_.unplaced.push_back(std::move(unplaced));
  }
}

// The world of a session without a placed segment.
void Placement::StandAtPositions() {
  std::vector<double> accuracies_m;
  std::optional<Geodetic> first;
  for (const std::optional<CameraPosition>& position : places_.positions) {
    if (position) {
      accuracies_m.push_back(position->accuracy_m);
      first = first.value_or(position->position);
    }
  }
  const Rigid3d ecef_from_enu = EcefFromEnu(*first);
  result_.ecef_from_world = {1.0, ecef_from_enu.rotation, ecef_from_enu.translation};
  Georegistration& georegistration = result_.georegistration;
  georegistration.ecef_from_world = result_.ecef_from_world;
  georegistration.is_by_map = true;
  georegistration.stated_accuracy_m = Median(std::move(accuracies_m));
  georegistration.accuracy = {.position_m = georegistration.stated_accuracy_m, .rotation_rad = kPi};
}

void Placement::ReportLeftOut(const Growth& growth) {
  for (size_t i = 0; i < growth.verdict_of_photo.size(); ++i) {
    if (growth.verdict_of_photo[i] != PhotoVerdict::kInSegment) {
      result_.left_out.push_back({set_.photos[i].name, ExplainVerdict(growth.verdict_of_photo[i])});
    }
  }
}

void Placement::FillImages() {
  const Sim3d world_from_ecef = result_.ecef_from_world.Inverse();
  for (size_t i = 0; i < set_.photos.size(); ++i) {
    if (const auto& position = places_.positions[i]) {
      result_.position_of_photo[i] = world_from_ecef * EcefFromGeodetic(position->position);
    }
  }
  FillDescriptors(result_.photo_of_image, &result_.model);
  for (UnplacedSegment& unplaced : result_.unplaced) {
    FillDescriptors(unplaced.segment.photo_of_image, &unplaced.segment.model);
  }
}

void Placement::FillDescriptors(const std::vector<int>& photo_of_image,
                                Reconstruction* model) const {
  for (size_t i = 0; i < model->images.size(); ++i) {
    const StoredDescriptors& descriptors = set_.photos[photo_of_image[i]].descriptors;
    model->images[i].features.descriptors = PackedDescriptors(descriptors);
  }
  model->descriptor_type = set_.descriptor_type;
  model->Validate();
}

}  // namespace

PlacedGrowth PlaceGrowth(const Growth& growth, const PhotoSet& set, const PhotoPlaces& places,
                         std::span<const MappingCamera> cameras_as_read,
                         const PlaceGrowthOptions& options) {
  if (growth.segments.empty()) {
    throw Error(ErrorCode::kBadInput,
                fmt::format("no three of the {} photos show the same place from different places. "
                            "Take a photo every two or three steps, not only turning on the spot",
                            set.photos.size()));
  }
  return Placement(places, cameras_as_read, options, set).Run(growth);
}

}  // namespace cairn
