// The access log: who asked for what, and what came of it.
#ifndef CAIRN_HTTP_SERVICE_ACCESS_LOG_H_
#define CAIRN_HTTP_SERVICE_ACCESS_LOG_H_

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>

namespace cairn {

// One request. Texts come from clients and may hold any bytes.
struct AccessRecord {
  std::chrono::system_clock::time_point time;  // Of the answer.
  std::string_view client;                     // Address, as HttpRequest::remote_address.
  std::string_view label;                      // Of the API key; empty without one.
  std::string_view method;                     // Empty, like the path, if no head arrived.
  // Without the query, which may hold secrets. A line has its first 256 bytes.
  std::string_view path;
  int status = 0;
  size_t num_bytes = 0;     // Of the answer's body.
  double seconds = 0.0;     // From the last byte of the request to the answer.
  std::string_view reason;  // Why there is no pose, or the code of a refusal; empty otherwise.
  std::string_view request_id;
};

// The record as one line of JSON in ASCII, with its end (docs/http.md has an example).
std::string AccessLine(const AccessRecord& record);

// A thread of its own writes the lines, so nobody waits for the disk. Lines that the disk does not
// take, because it is full or too slow, are lost; the server's log says so once, and again when
// lines are written. Safe to call from any thread.
class AccessLog {
 public:
  // Appends to the file, which it creates if necessary, for its owner and group. Throws Error(kIo),
  // which names the file.
  explicit AccessLog(const std::string& path);
  ~AccessLog();  // Writes what is left, as far as the disk takes it at once.
  AccessLog(const AccessLog&) = delete;
  AccessLog& operator=(const AccessLog&) = delete;

  // Returns at once.
  void Add(const AccessRecord& record);

  // Opens the path again before the next line is written, because somebody has moved the file. If
  // that fails, logs why and goes on with the file of before.
  void Reopen();

 private:
  // Returns a descriptor, or -1 with errno.
  int Open() const;
  void Work();
  void OpenAgain();
  void Write(std::string_view lines);
  bool WriteAll(std::string_view* lines);
  void CountLost(std::string_view lines, int64_t num_others, int error);

  const std::string path_;
  std::mutex mutex_;
  std::condition_variable wake_;
  std::string lines_;         // Not written yet.
  int64_t num_left_out_ = 0;  // Since `lines_` was taken; there was no room for them.
  bool must_reopen_ = false;
  bool stopping_ = false;

  // Used by the thread only.
  int fd_;
  bool is_within_line_ = false;  // The last write ended there.
  int64_t num_lost_ = 0;         // Lines, since the last one that was written.

  std::thread thread_;  // Last member, because the thread uses all others.
};

}  // namespace cairn

#endif  // CAIRN_HTTP_SERVICE_ACCESS_LOG_H_
