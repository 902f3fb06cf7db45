#include "ingest/ingest_options.h"

#include <cmath>

#include "core/require.h"
#include "ingest/ingest_option_visit.h"
#include "storage/map/utc_time.h"

namespace cairn {

void AgreementOptions::Validate() const { CheckOptions("ingest.agreement", *this); }

void GateOptions::Validate() const { CheckOptions("ingest.gate", *this); }

void UpkeepOptions::Validate() const { CheckOptions("ingest.upkeep", *this); }

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
