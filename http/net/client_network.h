// Who a client is, by its address.
#ifndef CAIRN_HTTP_NET_CLIENT_NETWORK_H_
#define CAIRN_HTTP_NET_CLIENT_NETWORK_H_

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace cairn {

// Returns a number for the client with this numeric address: the IPv4 address, or the first 64 bits
// of the IPv6 address, because a client with one address of such a network has all of them. Returns
// nothing if the text is no address.
std::optional<uint64_t> NetworkOfAddress(const std::string& address);

// A range of addresses. IPv4 is the part ::ffff:0:0/96 of IPv6.
struct AddressRange {
  std::array<uint8_t, 16> address{};
  int num_bits = 128;  // Of the address, from its beginning, that all addresses of the range have.
};

// The fronts that are believed when they name their clients.
using TrustedFronts = std::vector<AddressRange>;

// Reads addresses and networks such as "10.0.0.1,fd00::/8". Throws Error(kInvalidArgument) that
// names the wrong one.
TrustedFronts ParseTrustedFronts(std::string_view list);

// Returns the address of the client behind the fronts. `chain` is the value of X-Forwarded-For:
// each front adds the address of its peer at the end. A client can write what it wants before that,
// so the last address that is no trusted front counts. Returns `peer` if it is no trusted front.
std::string ForwardedClient(const std::string& peer, std::string_view chain,
                            const TrustedFronts& fronts);

}  // namespace cairn

#endif  // CAIRN_HTTP_NET_CLIENT_NETWORK_H_
