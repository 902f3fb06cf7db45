// How lines of the log reach stderr.
#ifndef CAIRN_CORE_LOG_SINK_H_
#define CAIRN_CORE_LOG_SINK_H_

#include <memory>

namespace spdlog::sinks {
class sink;
}  // namespace spdlog::sinks

namespace cairn {

// The one sink of the process. Thread-safe.
std::shared_ptr<spdlog::sinks::sink> LogSink();

// Whether the writer of a line waits until stderr takes the line, as is the default. Without
// waiting, lines that stderr does not take at once are lost: nobody reads from the pipe, or the
// terminal is halted. The next line that stderr takes follows a warning with their number. A line
// then has at most PIPE_BUF bytes. Thread-safe.
void SetLogWaits(bool waits);

}  // namespace cairn

#endif  // CAIRN_CORE_LOG_SINK_H_
