// The headers Accept and Accept-Encoding (RFC 9110 section 12.5).
#ifndef CAIRN_CORE_WIRE_ACCEPT_H_
#define CAIRN_CORE_WIRE_ACCEPT_H_

#include <string_view>

namespace cairn {

// Removes and returns the first element of a list with commas.
std::string_view TakeElement(std::string_view* list);

// The weight that an element states, 0 if the client refuses it; 1 without a weight.
double Quality(std::string_view element);

// True if a client with this Accept header prefers `media_type` to `usual`, which clients without
// the header get. The client must name `media_type`, with a larger weight than that of `usual`; or
// with the same weight, but not behind `usual`. Ranges ("*/*", "application/*") give a weight to
// `usual` only. Types are in lower case; those of the header may be in any case.
bool Prefers(std::string_view accept, std::string_view media_type, std::string_view usual);

}  // namespace cairn

#endif  // CAIRN_CORE_WIRE_ACCEPT_H_
