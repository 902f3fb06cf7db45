#include <string>
#include <string_view>
#include <type_traits>

#include "cli/options/cairn_options.h"
#include "ingest/codebook/codebook_option_visit.h"
#include "ingest/ingest_option_visit.h"

namespace cairn {
namespace {

constexpr EnumName<AppearanceKind> kAppearanceNames[] = {{"kmeans", AppearanceKind::kKMeans},
                                                         {"kmedoids", AppearanceKind::kKMedoids},
                                                         {"random", AppearanceKind::kRandom}};

constexpr EnumName<ProjectionKind> kProjectionNames[] = {
    {"principal_components", ProjectionKind::kPrincipalComponents},
    {"likelihood_ratio", ProjectionKind::kLikelihoodRatio}};

constexpr EnumName<Unanchored> kUnanchoredNames[] = {{"accept", Unanchored::kAccept},
                                                     {"refuse", Unanchored::kRefuse},
                                                     {"refuse_always", Unanchored::kRefuseAlways}};

constexpr EnumName<SessionFitting> kFittingNames[] = {{"bend", SessionFitting::kBend},
                                                      {"adjust", SessionFitting::kAdjust}};

const auto& NamesOf(CodebookSource) { return kCodebookSourceNames; }
const auto& NamesOf(ProjectionKind) { return kProjectionNames; }
const auto& NamesOf(LandmarkSelectionKind) { return kLandmarkSelectionNames; }
const auto& NamesOf(AppearanceKind) { return kAppearanceNames; }
const auto& NamesOf(Unanchored) { return kUnanchoredNames; }

// Adds what VisitOptions tells to a list.
class OptionLister {
 public:
  explicit OptionLister(OptionList* list) : list_(*list) {}

  template <typename T>
  void Visit(std::string_view name, T& value, const OptionRange&, std::string_view meaning) const {
    if constexpr (std::is_enum_v<T>) {
      list_.Add(name, &value, NamesOf(value), std::string(meaning));
    } else {
      list_.Add(name, &value, std::string(meaning));
    }
  }
  template <typename Options>
  void Section(std::string_view name, Options& options, std::string_view meaning) const {
    list_.AddSection(name, std::string(meaning), [&] { VisitOptions(options, *this); });
  }

 private:
  OptionList& list_;
};

}  // namespace

void DescribeIngest(IngestOptions* options, OptionList* list) {
  list->Add("max_sigma_m", &options->max_sigma_m,
            "Landmarks with a larger standard deviation of the position are dropped, meters");
  list->Add("max_reprojection_error_px", &options->max_reprojection_error_px,
            "Landmarks with a larger median reprojection error are dropped, pixels");
  list->Add("earth_accuracy_m", &options->earth_accuracy_m,
            "How far the session is from its true place on Earth, 68 % radius, meters; 0: as the "
            "georegistration estimates it");
  list->Add("earth_accuracy_rad", &options->earth_accuracy_rad,
            "How far the session is from its true direction, 68 % radius, radians; counts if "
            "earth_accuracy_m is set");
  list->Add("fitting", &options->fitting, kFittingNames,
            "How an anchored session follows the map: bent by a smooth drift, or also adjusted "
            "with the landmarks of the map held; cairn map adjusts");
  const OptionLister lister(list);
  lister.Section("codebook", options->codebook,
                 "How descriptors are compressed; counts for the first session of a map only");
  lister.Section("selection", options->selection, "Which landmarks of a tile are kept");
  lister.Section("appearance", options->appearance, "Which descriptors represent a landmark");
  lister.Section("agreement", options->agreement, "How far a session may contradict the map");
  lister.Section("gate", options->gate, "What an update may take from the map");
  lister.Section("upkeep", options->upkeep, "What becomes of a place that the map knows");
}

}  // namespace cairn
