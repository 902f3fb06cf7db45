// Tells a stage that its time is up.
#ifndef CAIRN_CORE_STOP_FUNCTION_H_
#define CAIRN_CORE_STOP_FUNCTION_H_

#include <functional>

namespace cairn {

// Polled between pieces of work. Once the function returns true, it keeps returning true, and the
// stage skips its remaining work. Must be safe to call from several threads. An empty function
// never stops the stage.
using StopFunction = std::function<bool()>;

}  // namespace cairn

#endif  // CAIRN_CORE_STOP_FUNCTION_H_
