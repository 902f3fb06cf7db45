// A connection to a PostgreSQL server that breaks in the middle of an answer.
#ifndef CAIRN_TESTS_SUPPORT_CUT_WIRE_H_
#define CAIRN_TESTS_SUPPORT_CUT_WIRE_H_

#include <atomic>
#include <cstdint>
#include <string>
#include <thread>

#include "support/temp_dir.h"

namespace cairn::testing {

// Listens on a socket of its own and passes bytes on to the server's socket and back.
class CutWire {
 public:
  // `server_folder`: the folder of the server's socket.
  explicit CutWire(const std::string& server_folder);
  ~CutWire();
  CutWire(const CutWire&) = delete;
  CutWire& operator=(const CutWire&) = delete;

  enum class Kind { kSilent, kClosed };
  // Passes `num_bytes` of the server's next bytes on, over all connections. The connection that
  // brings the byte after them is silent or closed from then on, and so is every other one.
  void CutAfter(int64_t num_bytes, Kind kind);
  // Closes all connections and passes everything on over new ones.
  void Mend();

  // The folder of the socket, for the host of a URL.
  std::string folder() const { return folder_.path().string(); }

 private:
  struct Pair;

  void Run();
  // Passes on what there is. Returns false if the pair is at its end.
  bool PassOn(Pair* pair);

  TempDir folder_;
  std::string server_socket_;
  int listener_ = -1;
  std::atomic<int64_t> num_bytes_left_;
  std::atomic<Kind> kind_ = Kind::kSilent;
  std::atomic<int> num_mends_ = 0;
  std::atomic<bool> ends_ = false;
  std::thread thread_;
};

}  // namespace cairn::testing

#endif  // CAIRN_TESTS_SUPPORT_CUT_WIRE_H_
