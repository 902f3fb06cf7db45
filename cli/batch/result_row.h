// What `cairn localize --images` says about one photo, in the forms of its output.
#ifndef CAIRN_CLI_BATCH_RESULT_ROW_H_
#define CAIRN_CLI_BATCH_RESULT_ROW_H_

#include <optional>
#include <string>
#include <string_view>

#include "cli/batch/world_frame.h"
#include "engine/query/localize_query.h"
#include "engine/query/localize_result.h"

namespace cairn {

// A row is one line of JSON: `image`, then the members of the server's answer (docs/http.md)
// without times, then `camFromWorld` with its frame. It does not depend on the threads, nor on the
// photos before it.
std::string AnswerRow(const std::string& name, const LocalizeQuery& query,
                      const LocalizeResult& result, const WorldFrame& frame);

// The row of a photo that cannot be asked: status FAILED and reason BAD_PHOTO.
std::string FailureRow(const std::string& name, const std::string& why);

// The parts of a row that the other forms and the summary need.
struct RowSummary {
  bool localized = false;
  std::string reason;  // Empty if localized.
};

// Return nothing if the text is not a row.
std::optional<RowSummary> ReadRow(std::string_view row);

// RFC 4180: a header, and a record for each row.
std::string CsvHeader();
std::string CsvOfRow(std::string_view row);

// hloc's `name qw qx qy qz tx ty tz`, cam_from_world; empty if there is no pose. The name is that
// of the list, byte for byte.
std::string HlocOfRow(const std::string& name, std::string_view row);

}  // namespace cairn

#endif  // CAIRN_CLI_BATCH_RESULT_ROW_H_
