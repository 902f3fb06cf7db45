// The open connections of an event loop, and the share of each client.
#ifndef CAIRN_HTTP_NET_CONNECTION_TABLE_H_
#define CAIRN_HTTP_NET_CONNECTION_TABLE_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <unordered_map>
#include <vector>

#include "http/net/connection.h"

namespace cairn {

// Use from one thread at a time: in an event loop, the leader.
class ConnectionTable {
 public:
  // The resources that one client (Peer::network) holds.
  struct Usage {
    int num_connections = 0;
    size_t bytes = 0;
  };
  struct Entry : Connection {
    using Connection::Connection;

    size_t index = 0;          // Index in the table.
    Usage* usage = nullptr;    // Of the entry's client.
    size_t counted_bytes = 0;  // Bytes included in buffered_bytes().
    bool is_closed = false;
    bool is_postponed = false;  // The event loop will advance it in its next round.
    // While lent, all other state of the connection belongs to the borrower.
    bool is_lent = false;
    uint32_t events_while_lent = 0;
    bool has_event_while_lent = false;  // Guarded by the mutex of the event loop.
  };

  const std::vector<std::unique_ptr<Entry>>& entries() const { return entries_; }
  // Requests and responses in memory, summed over all connections.
  size_t buffered_bytes() const { return buffered_bytes_; }

  Entry* Add(std::unique_ptr<Entry> entry);
  // Sets the number of bytes that the connection has in memory.
  void Count(size_t bytes, Entry* entry);
  // Closes the connection and removes it; FreeClosed frees its memory. May be called repeatedly.
  void Close(Entry* entry);
  // Frees closed connections. Call it once no event refers to them any more.
  void FreeClosed() { closed_.clear(); }

  // The connection to close when there are too many: of the client with the most connections, the
  // one that has waited longest. Null if all are lent.
  Entry* LongestWaiting() const;
  // The connection to close when more than `max_bytes` are in memory: of the client with the most
  // bytes, the one that has held most bytes for longest. Null if all are lent. Null also if the
  // client holds at most half as much as the heaviest client, as long as there are no more than
  // twice `max_bytes`: those who fill the memory with requests that are lent, which cannot be
  // closed, must not keep others out.
  Entry* HeaviestWaiting(size_t max_bytes) const;

 private:
  // Among the connections that wait for their clients, the one with the highest rank.
  template <typename Rank>
  Entry* Foremost(const Rank& rank) const;

  std::vector<std::unique_ptr<Entry>> entries_;
  std::vector<std::unique_ptr<Entry>> closed_;
  std::unordered_map<uint64_t, Usage> usage_;
  size_t buffered_bytes_ = 0;
};

}  // namespace cairn

#endif  // CAIRN_HTTP_NET_CONNECTION_TABLE_H_
