// A leader role that threads pass to each other.
#ifndef CAIRN_HTTP_NET_LEAD_H_
#define CAIRN_HTTP_NET_LEAD_H_

#include <memory>
#include <mutex>
#include <semaphore>
#include <vector>

namespace cairn {

// At most one thread holds the lead. The actions of one leader happen before the actions of the
// next. Safe to call from any thread.
class Lead {
 public:
  // Returns when the caller has the lead.
  void Take();
  // Gives the lead to the thread that began to wait last, because its data are still in the caches.
  // The other threads are spares.
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
