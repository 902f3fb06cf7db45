// The error of JSON that cannot be used, in files and in requests.
#ifndef CAIRN_CORE_WIRE_JSON_ERROR_H_
#define CAIRN_CORE_WIRE_JSON_ERROR_H_

#include <optional>
#include <string>
#include <utility>

#include "core/error.h"

namespace cairn {

// An Error(kBadInput). `what()` names the value at fault.
class JsonError : public Error {
 public:
  // `pointer` is the JSON pointer (RFC 6901) of the value at fault, or nothing if the text is not
  // usable JSON. `hint` is advice on how to mend it; it may be empty.
  JsonError(const std::string& message, std::optional<std::string> pointer, std::string hint)
      : Error(ErrorCode::kBadInput, message),
        pointer_(std::move(pointer)),
        hint_(std::move(hint)) {}

  const std::optional<std::string>& pointer() const { return pointer_; }
  const std::string& hint() const { return hint_; }

 private:
  std::optional<std::string> pointer_;
  std::string hint_;
};

}  // namespace cairn

#endif  // CAIRN_CORE_WIRE_JSON_ERROR_H_
