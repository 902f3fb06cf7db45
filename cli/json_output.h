// Results as JSON: the flag --json, which verbs that print a result have, and what it prints.
#ifndef CAIRN_CLI_JSON_OUTPUT_H_
#define CAIRN_CLI_JSON_OUTPUT_H_

#include <nlohmann/json_fwd.hpp>

#include "storage/map/map_store.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace cairn {

// Adds --json.
CLI::Option* AddJsonFlag(CLI::App* command, bool* json);

// Prints a document to standard output. Bytes that are not UTF-8 are replaced.
void PrintJson(const nlohmann::ordered_json& json);

// Numbers of sessions, tiles, keyframes, landmarks and descriptors, and the bytes of the tiles.
nlohmann::ordered_json TotalsJson(const MapTotals& totals);

}  // namespace cairn

#endif  // CAIRN_CLI_JSON_OUTPUT_H_
