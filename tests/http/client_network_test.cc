#include "http/net/client_network.h"

#include <gtest/gtest.h>

#include "core/error.h"

namespace cairn {
namespace {

TEST(ClientNetwork, IsTheAddressOfIpv4AndTheNetworkOfIpv6) {
  EXPECT_NE(NetworkOfAddress("192.0.2.1"), NetworkOfAddress("192.0.2.2"));
  EXPECT_EQ(NetworkOfAddress("192.0.2.1"), NetworkOfAddress("::ffff:192.0.2.1"));
  EXPECT_EQ(NetworkOfAddress("2001:db8:1:2::1"), NetworkOfAddress("2001:db8:1:2:ffff::2"));
  EXPECT_NE(NetworkOfAddress("2001:db8:1:2::1"), NetworkOfAddress("2001:db8:1:3::1"));
  EXPECT_EQ(NetworkOfAddress("fe80::1%eth0"), NetworkOfAddress("fe80::1"));
  for (const char* text : {"", "unknown", "1.2.3", "1.2.3.4.5", "example.org"}) {
    EXPECT_EQ(NetworkOfAddress(text), std::nullopt) << text;
  }
}

TEST(ForwardedClient, IsTheLastAddressThatIsNoFront) {
  const TrustedFronts fronts = ParseTrustedFronts("127.0.0.1, 10.0.0.0/8,fd00::/8");
  EXPECT_EQ(ForwardedClient("127.0.0.1", "192.0.2.7", fronts), "192.0.2.7");
  EXPECT_EQ(ForwardedClient("127.0.0.1", "192.0.2.7, 10.3.2.1", fronts), "192.0.2.7");
  EXPECT_EQ(ForwardedClient("fd00::1", "2001:db8::1", fronts), "2001:db8::1");
  EXPECT_EQ(ForwardedClient("::ffff:10.1.1.1", "192.0.2.7:4711", fronts), "192.0.2.7");
  EXPECT_EQ(ForwardedClient("10.1.1.1", "[2001:db8::1]:4711", fronts), "2001:db8::1");
  // What a client wrote itself stands before the address that the front added.
  EXPECT_EQ(ForwardedClient("127.0.0.1", "1.1.1.1, 192.0.2.7", fronts), "192.0.2.7");
  // Nobody else is believed.
  EXPECT_EQ(ForwardedClient("192.0.2.9", "192.0.2.7", fronts), "192.0.2.9");
  EXPECT_EQ(ForwardedClient("11.0.0.1", "192.0.2.7", fronts), "11.0.0.1");
  // A front that names nobody is the client.
  EXPECT_EQ(ForwardedClient("10.1.1.1", "", fronts), "10.1.1.1");
  EXPECT_EQ(ForwardedClient("10.1.1.1", "unknown", fronts), "10.1.1.1");
  EXPECT_EQ(ForwardedClient("10.1.1.1", "10.2.2.2", fronts), "10.2.2.2");
}

TEST(TrustedFronts, RefusesWhatIsNoAddress) {
  EXPECT_TRUE(ParseTrustedFronts("").empty());
  for (const char* list : {"front.example", "10.0.0.0/33", "10.0.0.0/-1", "::1/129", "10.0.0.0/",
                           "10.0.0.1,,10.0.0.2", "10.0.0.0/8x", "10.0.0.0/2147483647"}) {
    EXPECT_THROW(ParseTrustedFronts(list), Error) << list;
  }
}

}  // namespace
}  // namespace cairn
