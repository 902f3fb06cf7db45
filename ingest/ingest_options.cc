#include "ingest/ingest_options.h"

#include <cmath>

#include "core/require.h"
#include "storage/map/utc_time.h"

namespace cairn {

void AgreementOptions::Validate() const {
  RequireOption(max_moved_m >= 0.0, "agreement.max_moved_m must not be negative");
  RequireOption(max_turned_rad >= 0.0, "agreement.max_turned_rad must not be negative");
  RequireOption(max_scale_change >= 0.0, "agreement.max_scale_change must not be negative");
  RequireOption(position_accuracy_m >= 0.0 && std::isfinite(position_accuracy_m),
                "agreement.position_accuracy_m must be finite and not negative");
  RequireOption(min_agreeing_share >= 0.0 && min_agreeing_share <= 1.0,
                "agreement.min_agreeing_share must be between 0 and 1");
  RequireOption(min_recognized_share >= 0.0 && min_recognized_share <= 1.0,
                "agreement.min_recognized_share must be between 0 and 1");
  RequireOption(min_expected >= 1, "agreement.min_expected must be at least 1");
}

void GateOptions::Validate() const {
  RequireOption(max_lost_share >= 0.0 && max_lost_share <= 1.0,
                "gate.max_lost_share must be between 0 and 1");
}

void UpkeepOptions::Validate() const {
  linking.Validate();
  merging.Validate();
  RequireOption(viewpoints.radius_m > 0.0, "upkeep.viewpoints.radius_m must be positive");
  RequireOption(viewpoints.angle_rad > 0.0, "upkeep.viewpoints.angle_rad must be positive");
  RequireOption(persistence.loss_per_year >= 0.0 && persistence.loss_per_year < 1.0,
                "upkeep.persistence.loss_per_year must be in [0, 1)");
  RequireOption(persistence.least_miss_share > 0.0 && persistence.least_miss_share <= 1.0,
                "upkeep.persistence.least_miss_share must be in (0, 1]");
  RequireOption(enough_landmarks >= 0, "upkeep.enough_landmarks must not be negative");
  RequireOption(least_existence >= 0.0 && least_existence <= 1.0,
                "upkeep.least_existence must be between 0 and 1");
}

void TileOptions::Validate() const {
  selection.Validate();
  appearance.Validate();
  upkeep.Validate();
}

void IngestOptions::Validate() const {
  RequireOption(!session_name.empty(), "ingest.session_name must not be empty");
  RequireOption(recorded_at.empty() || IsUtcTime(recorded_at),
                "the time of recording must be like 2026-01-31T12:00:00Z");
  RequireOption(now.empty() || IsUtcTime(now),
                "the time of the ingest must be like 2026-01-31T12:00:00Z");
  RequireOption(max_sigma_m > 0.0, "ingest.max_sigma_m must be positive");
  RequireOption(max_reprojection_error_px > 0.0,
                "ingest.max_reprojection_error_px must be positive");
  RequireOption(std::isfinite(georef_median_residual_m),
                "ingest.georef_median_residual_m must be finite");
  RequireWithin("ingest.earth_accuracy_m", earth_accuracy_m, 0.0, 1e6);
  RequireWithin("ingest.earth_accuracy_rad", earth_accuracy_rad, 0.0, 3.2);
  RequireOption(num_threads >= 1, "ingest.num_threads must be at least 1");
  TileOptions::Validate();
  codebook.Validate();
  agreement.Validate();
  gate.Validate();
}

}  // namespace cairn
