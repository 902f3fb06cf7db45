#include "http/net/client_network.h"

#include <arpa/inet.h>
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstring>

#include "core/error.h"
#include "core/wire/header_line.h"

namespace cairn {
namespace {

using Address = std::array<uint8_t, 16>;

constexpr size_t kIpv4Begin = 12;  // Of an IPv4 address within IPv6.

std::optional<Address> ParseAddress(const std::string& text) {
  Address address{};
  if (inet_pton(AF_INET6, text.c_str(), address.data()) == 1) {
    return address;
  }
  address = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xff, 0xff, 0, 0, 0, 0};
  if (inet_pton(AF_INET, text.c_str(), address.data() + kIpv4Begin) == 1) {
    return address;
  }
  return std::nullopt;
}

bool IsIpv4(const Address& address) {
  return std::all_of(address.begin(), address.begin() + 10,
                     [](uint8_t byte) { return byte == 0; }) &&
         address[10] == 0xff && address[11] == 0xff;
}

// The address without what some fronts add: "192.0.2.1:4711", "[2001:db8::1]:4711".
std::string WithoutPort(std::string_view text) {
  if (text.starts_with('[')) {
    return std::string(text.substr(1, text.find(']') - 1));
  }
  const size_t colon = text.find(':');
  const bool has_port =
      colon != std::string_view::npos && text.find(':', colon + 1) == std::string_view::npos;
  return std::string(has_port ? text.substr(0, colon) : text);
}

bool Contains(const AddressRange& range, const Address& address) {
  for (int bit = 0; bit < range.num_bits; bit += 8) {
    const int num_left = std::min(8, range.num_bits - bit);
    const auto mask = static_cast<uint8_t>(0xff << (8 - num_left));
    if (((range.address[bit / 8] ^ address[bit / 8]) & mask) != 0) {
      return false;
    }
  }
  return true;
}

bool IsTrusted(const std::string& text, const TrustedFronts& fronts) {
  const std::optional<Address> address = ParseAddress(text);
  return address && std::any_of(fronts.begin(), fronts.end(), [&](const AddressRange& range) {
           return Contains(range, *address);
         });
}

AddressRange ParseRange(std::string_view text) {
  const size_t slash = text.find('/');
  const std::optional<Address> address = ParseAddress(std::string(text.substr(0, slash)));
  AddressRange range{.address = address.value_or(Address{}), .num_bits = 128};
  bool is_valid = address.has_value();
  if (slash != std::string_view::npos) {
    const std::string_view digits = text.substr(slash + 1);
    const int num_fixed_bits = IsIpv4(range.address) ? 96 : 0;
    int num_bits = -1;
    const auto [end, error] =
        std::from_chars(digits.data(), digits.data() + digits.size(), num_bits);
    is_valid = is_valid && error == std::errc() && end == digits.data() + digits.size() &&
               num_bits >= 0 && num_bits <= 128 - num_fixed_bits;
    range.num_bits = is_valid ? num_fixed_bits + num_bits : 128;
  }
  if (!is_valid) {
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format("server.trusted_fronts: '{}' is neither an address nor a network such as "
                    "10.0.0.0/8",
                    text));
  }
  return range;
}

}  // namespace

std::optional<uint64_t> NetworkOfAddress(const std::string& address) {
  const std::optional<Address> bytes = ParseAddress(address.substr(0, address.find('%')));
  if (!bytes) {
    return std::nullopt;
  }
  uint64_t network = 0;
  std::memcpy(&network, bytes->data() + (IsIpv4(*bytes) ? 8 : 0), sizeof(network));
  return network;
}

TrustedFronts ParseTrustedFronts(std::string_view list) {
  TrustedFronts fronts;
  while (!list.empty()) {
    const size_t comma = list.find(',');
    fronts.push_back(ParseRange(TrimBlanks(list.substr(0, comma))));
    list = comma == std::string_view::npos ? "" : list.substr(comma + 1);
  }
  return fronts;
}

std::string ForwardedClient(const std::string& peer, std::string_view chain,
                            const TrustedFronts& fronts) {
  std::string client = peer;
  while (!chain.empty() && IsTrusted(client, fronts)) {
    const size_t comma = chain.rfind(',');
    const bool is_first = comma == std::string_view::npos;
    const std::string named = WithoutPort(TrimBlanks(is_first ? chain : chain.substr(comma + 1)));
    if (!ParseAddress(named)) {
      break;  // Nobody knows who is behind this front.
    }
    client = named;
    chain = is_first ? "" : chain.substr(0, comma);
  }
  return client;
}

}  // namespace cairn
