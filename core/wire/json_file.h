// Reads files of JSON.
#ifndef CAIRN_CORE_WIRE_JSON_FILE_H_
#define CAIRN_CORE_WIRE_JSON_FILE_H_

#include <cstdint>
#include <string>

#include "core/error.h"
#include "core/file_bytes.h"
#include "core/wire/json_reader.h"

namespace cairn {

// Returns read(top level) for the JSON of a file. Throws the errors of ReadTextFile, and those of
// the parser and of `read` with the path before the message.
template <typename Read>
auto ReadJsonFile(const std::string& path, uint64_t max_bytes, const JsonLimits& limits,
                  const Read& read) {
  const std::string text = ReadTextFile(path, max_bytes);
  try {
    const JsonDocument document = ParseJson(text, limits);
    return read(JsonReader(document));
  } catch (const Error& error) {
    throw Error(error.code(), path + ": " + error.what());
  }
}

}  // namespace cairn

#endif  // CAIRN_CORE_WIRE_JSON_FILE_H_
