// The checks of option structs; private to eval/city.
#ifndef CAIRN_EVAL_CITY_REQUIRE_OPTION_H_
#define CAIRN_EVAL_CITY_REQUIRE_OPTION_H_

namespace cairn {

// Throws Error(kInvalidArgument) "<field> = 3 must lie in [0, 1]; the nearest possible value is 1"
// unless low <= value <= high.
void RequireInRange(const char* field, double value, double low, double high);

}  // namespace cairn

#endif  // CAIRN_EVAL_CITY_REQUIRE_OPTION_H_
