// How a stage is told that its time is up.
#ifndef CAIRN_CORE_STOP_FUNCTION_H_
#define CAIRN_CORE_STOP_FUNCTION_H_

#include <functional>

namespace cairn {

// Asked between two pieces of work whether to leave the rest; once it has said so it keeps to it.
// Several threads may ask at once. Without a function in it: never.
using StopFunction = std::function<bool()>;

}  // namespace cairn

#endif  // CAIRN_CORE_STOP_FUNCTION_H_
