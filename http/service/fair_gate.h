// Decides which requests compute, and divides the cores among the clients.
#ifndef CAIRN_HTTP_SERVICE_FAIR_GATE_H_
#define CAIRN_HTTP_SERVICE_FAIR_GATE_H_

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <list>
#include <mutex>
#include <unordered_map>
#include <vector>

namespace cairn {

struct FairGateOptions {
  int num_slots = 1;  // Requests that compute at a time, one for each core.
  // Requests that wait at a time. Each holds a thread of the server.
  int max_waiting = 48;
  // A client without a turn waits no longer than this for turns that take long. Most queries take
  // less, so few turns run beside each other.
  std::chrono::milliseconds patience{100};
};

// With more requests at once than cores, each would run in small slices and finish after its
// deadline. At the gate, they wait for a slot.
//
// Requests of one client get their turns in the order of their deadlines. Among clients, the next
// turn goes to the one with the fewest turns under way, and then to the one that has used the least
// time lately. So that long turns do not keep other clients out, a client without a turn gets one
// beside them when they have taken longer than `patience`; at most twice `num_slots` turns are then
// under way. More turns than slots then compute, until a long turn makes room (Turn::MakeRoom).
//
// If too many requests wait, the client with most of them loses the one with the latest deadline.
//
// Safe to call from any thread.
class FairGate {
 public:
  using Clock = std::chrono::steady_clock;
  // Equal for requests of one client (HttpRequest::client).
  using ClientId = uint64_t;

  enum class Outcome {
    kEntered,
    kLate,     // The deadline passed first.
    kRefused,  // Too many requests wait.
  };

  class Turn;

 private:
  struct Client {
    std::list<Turn*> waiting;  // By deadline, and then by arrival.
    int num_running = 0;       // Turns under way.
    int num_paused = 0;        // Of these.
    double used_s = 0.0;  // The time of its turns, which counts less and less, as of `used_at`.
    Clock::time_point used_at;

    int num_computing() const { return num_running - num_paused; }
    bool is_idle() const { return num_running == 0 && waiting.empty(); }
    double UsedSeconds(Clock::time_point now) const;
  };

 public:
  // A request's stay at the gate. The destructor gives the slot to the next request.
  class Turn {
   public:
    // Waits for a slot.
    Turn(FairGate* gate, ClientId client, Clock::time_point deadline);
    ~Turn();
    Turn(const Turn&) = delete;
    Turn& operator=(const Turn&) = delete;

    Outcome outcome() const { return outcome_; }

    // Call now and then during a turn that may be long, on the thread that entered, without locks.
    // Pauses the turn if it has computed for longer than `patience`, and
    // - more turns than slots compute, and another client computes fewer of them, or
    // - a request of its own client is next whose deadline is earlier.
    // The turn goes on when a slot is free. So that it can finish, it pauses for at most half of
    // the time that it had from its start to its deadline.
    void MakeRoom();

   private:
    friend class FairGate;
    Clock::duration Computed(Clock::time_point now) const { return now - start_ - paused_; }
    Clock::duration PauseLeft() const { return (deadline_ - start_) / 2 - paused_; }

    FairGate* gate_;
    Client* client_ = nullptr;
    const Clock::time_point deadline_;
    Outcome outcome_ = Outcome::kLate;
    bool is_waiting_ = true;
    std::condition_variable changed_;
    // Of a turn that has entered.
    Clock::time_point start_;
    bool is_paused_ = false;
    Clock::time_point pause_start_;
    Clock::duration paused_{0};  // In pauses that have ended.
  };

  explicit FairGate(const FairGateOptions& options) : options_(options) {}

  int num_waiting() const;
  int num_paused() const;  // Of the turns under way. Tests wait for it.

 private:
  void Queue(Turn* turn);
  void Wait(std::unique_lock<std::mutex>* lock, Turn* turn);
  void Leave(Turn* turn);
  // Gives slots to waiting requests.
  void Admit(Clock::time_point now);
  Client* NextClient(Clock::time_point now) const;
  bool MayEnter(const Client& client, Clock::time_point now) const;
  void Enter(Turn* turn, Clock::time_point now);
  static bool IsUrgent(const Client& client, const Turn& turn);
  bool MustPause(const Turn& turn, Clock::time_point now) const;
  void Pause(std::unique_lock<std::mutex>* lock, Turn* turn, Clock::time_point now);
  // The turn that pauses of the client that computes least; of its turns, that with the earliest
  // deadline. Null if none pauses.
  Turn* NextPaused(Clock::time_point now) const;
  void Resume(Turn* turn, Clock::time_point now);
  size_t num_computing() const { return running_.size() - num_paused_; }
  // When a client without a turn may enter beside long turns; the end of time if it may not.
  Clock::time_point EndOfPatience(const Client& client) const;
  void RefuseOne();
  void StopWaiting(Outcome outcome, Turn* turn);
  void ForgetIdleClients();

  const FairGateOptions options_;
  mutable std::mutex mutex_;
  std::unordered_map<ClientId, Client> clients_;
  std::vector<Client*> waiting_clients_;  // Those with waiting requests.
  std::list<Turn*> running_;              // By start.
  size_t num_paused_ = 0;                 // Of the running.
  int num_waiting_ = 0;
};

}  // namespace cairn

#endif  // CAIRN_HTTP_SERVICE_FAIR_GATE_H_
