// The summary of a session that `cairn ingest` and `cairn publish` print.
#ifndef CAIRN_CLI_INGEST_SUMMARY_H_
#define CAIRN_CLI_INGEST_SUMMARY_H_

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "ingest/ingest_report.h"
#include "ingest/place/georegister.h"

namespace cairn {

// Of a plan that was read from a folder, only the median residual of the georegistration is known:
// num_positions is 0.
void PrintIngestJson(const std::string& session_name, const Georegistration& georegistration,
                     const IngestReport& report);
void PrintIngestText(const std::string& session_name, const Georegistration& georegistration,
                     const IngestReport& report);

nlohmann::ordered_json IngestJson(const std::string& session_name,
                                  const Georegistration& georegistration,
                                  const IngestReport& report);

// The parts that `cairn plan` prints, too.
nlohmann::ordered_json GeoregistrationJson(const Georegistration& georegistration);
void PrintGeoregistration(const Georegistration& georegistration);

}  // namespace cairn

#endif  // CAIRN_CLI_INGEST_SUMMARY_H_
