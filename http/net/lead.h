// A lead that threads pass to each other.
#ifndef CAIRN_HTTP_NET_LEAD_H_
#define CAIRN_HTTP_NET_LEAD_H_

#include <memory>
#include <mutex>
#include <semaphore>
#include <vector>

namespace cairn {

// One thread has it, or none. What the leader does comes before what the next leader does. Safe to
// call from any thread.
class Lead {
 public:
  // Returns when the caller has the lead.
  void Take();
  // The thread that began to wait last is the next to have it: what it uses is in the caches still.
  // The others are spares.
  void Pass();

 private:
  struct Follower {
    std::binary_semaphore promoted{0};
  };

  std::mutex mutex_;
  bool is_taken_ = false;
  std::vector<std::shared_ptr<Follower>> followers_;
};

}  // namespace cairn

#endif  // CAIRN_HTTP_NET_LEAD_H_
