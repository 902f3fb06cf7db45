#include "cli/json_output.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

namespace cairn {

CLI::Option* AddJsonFlag(CLI::App* command, bool* json) {
  return command->add_flag("--json", *json, "Print the result as JSON");
}

void PrintJson(const nlohmann::ordered_json& json) {
  fmt::print("{}\n", json.dump(2, ' ', true, nlohmann::ordered_json::error_handler_t::replace));
}

nlohmann::ordered_json TotalsJson(const MapTotals& totals) {
  return {{"sessions", totals.num_sessions},       {"tiles", totals.num_tiles},
          {"keyframes", totals.num_keyframes},     {"landmarks", totals.num_landmarks},
          {"descriptors", totals.num_descriptors}, {"payloadBytes", totals.payload_bytes}};
}

}  // namespace cairn
