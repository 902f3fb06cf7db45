#include "http/net/connection_table.h"

#include <algorithm>
#include <chrono>
#include <tuple>
#include <utility>

namespace cairn {

using std::chrono::steady_clock;

ConnectionTable::Entry* ConnectionTable::Add(std::unique_ptr<Entry> entry) {
  entry->index = entries_.size();
  entry->usage = &usage_[entry->peer().network];
  ++entry->usage->num_connections;
  entries_.push_back(std::move(entry));
  return entries_.back().get();
}

void ConnectionTable::Count(size_t bytes, Entry* entry) {
  buffered_bytes_ += bytes - entry->counted_bytes;
  entry->usage->bytes += bytes - entry->counted_bytes;
  entry->counted_bytes = bytes;
}

void ConnectionTable::Close(Entry* entry) {
  if (entry->is_closed) {
    return;
  }
  entry->is_closed = true;
  buffered_bytes_ -= entry->counted_bytes;
  entry->usage->bytes -= entry->counted_bytes;
  if (--entry->usage->num_connections == 0) {
    usage_.erase(entry->peer().network);
  }
  entry->socket().Close();
  std::swap(entries_[entry->index], entries_.back());
  entries_[entry->index]->index = entry->index;
  closed_.push_back(std::move(entries_.back()));
  entries_.pop_back();
}

template <typename Rank>
ConnectionTable::Entry* ConnectionTable::Foremost(const Rank& rank) const {
  Entry* foremost = nullptr;
  for (const auto& entry : entries_) {
    if (entry->is_lent) {
      continue;
    }
    if (foremost == nullptr || rank(*entry) > rank(*foremost)) {
      foremost = entry.get();
    }
  }
  return foremost;
}

ConnectionTable::Entry* ConnectionTable::LongestWaiting() const {
  const auto now = steady_clock::now();
  return Foremost([now](const Entry& entry) {
    return std::tuple(entry.usage->num_connections, now - entry.waiting_since());
  });
}

ConnectionTable::Entry* ConnectionTable::HeaviestWaiting(size_t max_bytes) const {
  const auto now = steady_clock::now();
  Entry* const heaviest = Foremost([now](const Entry& entry) {
    const std::chrono::duration<double> age = now - entry.waiting_since();
    return std::tuple(entry.usage->bytes, static_cast<double>(entry.counted_bytes) * age.count());
  });
  size_t most_bytes = 0;
  for (const auto& [network, usage] : usage_) {
    most_bytes = std::max(most_bytes, usage.bytes);
  }
  const bool is_modest = heaviest != nullptr && heaviest->usage->bytes <= most_bytes / 2;
  return is_modest && buffered_bytes_ <= 2 * max_bytes ? nullptr : heaviest;
}

}  // namespace cairn
