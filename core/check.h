// CAIRN_CHECK is for bugs only. No input from outside may make a check fail.
#ifndef CAIRN_CORE_CHECK_H_
#define CAIRN_CORE_CHECK_H_

namespace cairn {

// Prints `file:line: condition: message` to stderr and aborts.
[[noreturn]] void CheckFailed(const char* file, int line, const char* condition,
                              const char* message);

}  // namespace cairn

#define CAIRN_CHECK(condition, message)                              \
  do {                                                               \
    if (!(condition)) [[unlikely]] {                                 \
      ::cairn::CheckFailed(__FILE__, __LINE__, #condition, message); \
    }                                                                \
  } while (false)

#endif  // CAIRN_CORE_CHECK_H_
