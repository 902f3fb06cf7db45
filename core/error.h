// The project's one exception type and its error codes.
#ifndef CAIRN_CORE_ERROR_H_
#define CAIRN_CORE_ERROR_H_

#include <stdexcept>
#include <string>

namespace cairn {

// The kind of failure that an Error reports. `http/` maps each code to a status, `cli/` to an exit
// code.
enum class ErrorCode {
  kInternal,         // A library misbehaved or an invariant outside Cairn's control broke.
  kInvalidArgument,  // Options or a command line that make no sense.
  kBadInput,         // Data from outside that cannot be used: files, images, requests.
  kNotFound,         // The named file, tile, session or job does not exist.
  kConflict,         // The request does not fit the state of the map (locked, other codebook).
  kMapDamaged,       // The map file or a part of it fails its checks.
  kIo,               // The operating system refused: disk full, permission, broken pipe.
  kUnavailable,      // A server does not answer, or a needed resource is missing.
};

// Returns the stable lower-case name of a code, e.g. "bad_input", for the wire and for logs.
const char* ErrorCodeName(ErrorCode code);

// Thrown for every failure. The message names the file, tile or field and what to do about the
// problem.
class Error : public std::runtime_error {
 public:
  Error(ErrorCode code, const std::string& message) : std::runtime_error(message), code_(code) {}
  ErrorCode code() const { return code_; }

 private:
  ErrorCode code_;
};

}  // namespace cairn

#endif  // CAIRN_CORE_ERROR_H_
